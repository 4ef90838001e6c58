#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "chequer/detect_trace.h"
#include "detect/boards/motion_blur_view.h"
#include "detect/boards/place.h"
#include "detect/common/scratch.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/grids/grids.h"

namespace chequer {

/// Views a place of an image so that a board there looks as if seen from the front and sharp, and finds and links the
/// corners of that view. The pyramid is the image's, the trace gets what was viewed; may be null.
class PlaceView {
 public:
  /// Cells in the view, px (a guess: the ring sees cells from 4 px on).
  static constexpr float kCellPx = 8;
  /// Beyond that, pixels are only blown up (a guess).
  static constexpr float kMostZoom = 3;

  /// Stretched and squeezed as the place's spread tells, and once more as the corners tell that this shows.
  void Straighten(const Pyramid& pyramid, Place place, WorkMeter& work, TracePlace* trace);
  /// With what is blurred along its narrow side raised again.
  void Sharpen(const Pyramid& pyramid, const Place& place, WorkMeter& work, TracePlace* trace);
  /// Sharpened along the motion of a place that seems motion-blurred; false if it does not.
  bool UndoMotionBlur(const Pyramid& pyramid, const Place& place, WorkMeter& work, TracePlace* trace);

  /// Whether so much is linked that it will be a board if it is one.
  bool ShowsBoard() const;
  /// Positions in the image.
  const std::vector<Corner>& corners() const { return shown_->corners; }
  const Grids& grids() const { return shown_->grids; }
  const GridLinker& linker() const { return shown_->linker; }
  /// Whether motion blur was undone.
  bool motion_blurred() const { return shown_->motion_blurred; }

 private:
  void ViewStraightened(const Pyramid& pyramid, const Place& place, WorkMeter& work, TracePlace* trace);
  /// Fills the view with the plane of that level and makes its stripes even.
  void ViewEvenedOut(const Pyramid& pyramid, int level, const Place& place, const Eigen::Matrix2f& image_by_view,
                     WorkMeter& work, TracePlace* trace);
  /// Finds and links the corners of the view. @param scale image pixels a pixel of the plane that is viewed.
  void ShowCorners(const Place& place, const Eigen::Matrix2f& image_by_view, float scale, WorkMeter& work,
                   TracePlace* trace);
  void NoteView(const Place& place, const Eigen::Matrix2f& image_by_view, TracePlace& told) const;

  /// What one view shows.
  struct Shown {
    DetectionPlane view;
    std::vector<std::uint8_t> smoothed;
    MotionBlurScratch motion_blur;
    PeakScan scan;
    std::vector<RefusedPeak> refused;
    GridLinker linker;
    std::vector<Corner> corners;
    Grids grids;
    bool motion_blurred = false;
    std::vector<StrongPoint> seen;  ///< what looks like corners
  };

  Scratch<Shown> shown_;
};

}  // namespace chequer
