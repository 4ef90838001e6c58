#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/detector.h"
#include "chequer/image.h"
#include "lens/lens_views.h"

namespace chequer {

/// Finds the points of a target in images. One thread.
class LensTarget {
 public:
  virtual ~LensTarget() = default;
  /// The points that an image shows; none where the target is not seen.
  virtual LensView Read(const ImageView& image) = 0;
  /// Tells what is known of the lens so far. Points of boards are then found by how that lens bends them.
  virtual void SetCamera(const CameraModel& camera) = 0;
  /// Whether what is known of the lens changes what is read.
  virtual bool WantsCamera() const = 0;
};

/// Our own markers: each is a board.
/// @param loose whether each moves on its own; then the biggest one of an image is read alone.
std::unique_ptr<LensTarget> MakeMarkerTarget(std::vector<MarkerFamily> families, bool loose);

/// A chessboard: one board.
struct Chessboard {
  int rows = 6;  ///< of inner corners
  int cols = 9;
  double square_m = 0.025;
};
std::unique_ptr<LensTarget> MakeChessboardTarget(const Chessboard& chessboard);

}  // namespace chequer
