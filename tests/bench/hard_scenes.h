#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "chequer/marker.h"
#include "simulate/random.h"
#include "simulate/render.h"

namespace chequer::bench {

/// Which hard conditions frames and boards have.
struct HardSceneOptions {
  std::vector<std::string> only;  ///< conditions that may be; empty: all
  double share = 0;               ///< of frames or boards that have each; 0: its own
  Variant variant = Variant::kSecded;
};

/// One to nine boards before a camera, and what makes them hard to read.
struct HardFrame {
  static constexpr double kSideM = 0.12;  ///< of boards

  Scene scene;
  RenderOptions render;
  std::vector<std::vector<const char*>> conditions;  ///< by marker: names

  /// The marker that a pose is of: the nearest by its direction, if it is less than half a side away.
  std::optional<std::size_t> BoardOf(const RigidTransform& camera_from_marker) const;
};

/// One frame. The same arguments give the same.
HardFrame DrawHardFrame(const HardSceneOptions& options, std::uint64_t seed);

/// Frames of one camera and of boards that drive in circles and turn. The lights, the camera's motion and what lies on
/// boards change at random, all at once from a frame to the next. The print, the tilts and the camera's format stay.
class HardStream {
 public:
  HardStream(const HardSceneOptions& options, std::uint64_t seed);

  HardFrame Next();

 private:
  struct Drive {
    double radius_px, turn_rad;  ///< of the circle, and a frame along it
    double from_rad;             ///< where on the circle the first frame is
    double yaw_rad;              ///< a frame, about the board's own axis
    std::uint64_t seed;          ///< of what lies on the board now
  };

  const HardSceneOptions options_;
  Random random_;
  std::uint64_t light_seed_ = 0;  ///< of what all boards are in now
  HardFrame plain_;
  std::vector<Drive> drives_;
  int frames_ = 0;
};

}  // namespace chequer::bench
