#include "detect/boards/place_view.h"

#include <algorithm>
#include <cmath>

#include "detect/boards/view_kernels.h"

namespace chequer {
namespace {

/// Half the side of a view, cells: a board of six and what the spread misjudges (a guess).
constexpr float kHalfCells = 5.5f;
constexpr int kViewPx = static_cast<int>(2 * kHalfCells * PlaceView::kCellPx);
/// With less zoom, a coarser plane shows as much (a guess).
constexpr float kLeastZoom = 1.2f;
/// A place is viewed so many times, each time by what the last view showed. It shows a board if so many corners are
/// linked (guesses).
constexpr int kMostViews = 2, kEnoughLinked = 12;
/// Share of the most contrast that corners of one board have at least (a guess).
constexpr float kShareOfMost = 0.4f;
/// Largest ratio of the change along the motion to the change across it, for a motion-blurred board. A motion of 1.2
/// cells gives 0.05 to 0.35; less blurred boards are found by the first look.
constexpr float kMostEven = 0.55f;
/// Fewer of them do not tell how a board lies (a guess).
constexpr int kFewestSeen = 6;
/// Typical blur of images, px (a guess). The view is smoothed along x until it is as blurred as along y, where it is
/// stretched: uneven blur would leave ridges at corners.
constexpr float kBlurPx = 0.8f;

}  // namespace

void PlaceView::ViewStraightened(const Pyramid& pyramid, const Place& place, WorkMeter& work, TracePlace* trace) {
  // Cells are as wide in the view as they are high.
  const float cell_px = place.cell_px(), zoom = std::min(kCellPx / cell_px, kMostZoom);
  int level = 0;
  while (level + 1 < Pyramid::kLevels && zoom * static_cast<float>(2 << level) < kLeastZoom) ++level;
  const float scale = static_cast<float>(1 << level);
  const Eigen::Vector2f step(place.spread[0] / place.spread[1] / zoom, 1 / zoom);  // image px a pixel of the view
  const Eigen::Matrix2f image_by_view = place.axes * step.asDiagonal();
  const int side = static_cast<int>(std::ceil(2 * kHalfCells * zoom * cell_px));
  shown_.Start();
  ViewPlane(pyramid.level(level), pyramid.FromImage(place.middle, level), image_by_view / scale, side,
            shown_->view.plane);
  // Two running means of width w have the variance (w² − 1) / 6.
  const float variance = kBlurPx * kBlurPx * (1 / (step[1] * step[1]) - 1 / (step[0] * step[0]));
  const int width = 2 * static_cast<int>(std::lround((std::sqrt(6 * std::max(variance, 0.0f) + 1) - 1) / 2)) + 1;
  if (width > 1) SmoothRows(width, shown_->view.plane, shown_->smoothed);
  ShowCorners(place, image_by_view, scale, work, trace);
}

void PlaceView::Straighten(const Pyramid& pyramid, Place place, WorkMeter& work, TracePlace* trace) {
  for (int view = 0; view < kMostViews; ++view) {
    ViewStraightened(pyramid, place, work, trace);
    if (ShowsBoard()) return;
    // What looks like corners now tells better where they lie, and how they spread.
    float most = 0;
    for (const Corner& corner : shown_->corners) most = std::max(most, corner.contrast);
    for (const Corner& corner : shown_->corners)
      if (corner.contrast > kShareOfMost * most) shown_->seen.push_back({corner.position, corner.contrast});
    place = GatherPoints(shown_->seen, place);
    if (place.count < kFewestSeen) return;
  }
}

void PlaceView::ViewEvenedOut(const Pyramid& pyramid, int level, const Place& place,
                              const Eigen::Matrix2f& image_by_view, WorkMeter& work, TracePlace* trace) {
  const float scale = static_cast<float>(1 << level);
  ViewPlane(pyramid.level(level), pyramid.FromImage(place.middle, level), image_by_view / scale, kViewPx,
            shown_->view.plane);
  EvenOutChange(static_cast<int>(kCellPx), shown_->view.plane, shown_->motion_blur);
  ShowCorners(place, image_by_view, scale, work, trace);
  if (trace) trace->sharpened = true;
}

void PlaceView::Sharpen(const Pyramid& pyramid, const Place& place, WorkMeter& work, TracePlace* trace) {
  // Along its narrow side, the lens has made the cells as even as motion would.
  const float scale = place.cell_px() / kCellPx, slant = place.spread[0] / place.spread[1];
  Eigen::Matrix2f image_by_view;
  image_by_view << scale * place.axes.col(1), -scale * slant * place.axes.col(0);
  shown_.Start();
  ViewEvenedOut(pyramid, 0, place, image_by_view, work, trace);
}

bool PlaceView::UndoMotionBlur(const Pyramid& pyramid, const Place& place, WorkMeter& work, TracePlace* trace) {
  const float cell_px = std::sqrt(place.spread[0] * place.spread[1]) / kSpreadCells;
  int level = 0;
  while (level + 1 < Pyramid::kLevels && cell_px / static_cast<float>(2 << level) > kCellPx) ++level;
  const Change change = ChangeAround(pyramid.level(level), pyramid.FromImage(place.middle, level),
                                     cell_px / static_cast<float>(1 << level));
  if (change.share > kMostEven) return false;
  Eigen::Matrix2f image_by_view;
  image_by_view << change.least, Eigen::Vector2f(-change.least.y(), change.least.x());
  image_by_view *= cell_px / kCellPx;
  shown_.Start().motion_blurred = true;
  ViewEvenedOut(pyramid, level, place, image_by_view, work, trace);
  if (trace) trace->fate = PlaceFate::kViewed;
  return true;
}

bool PlaceView::ShowsBoard() const {
  return std::any_of(shown_->grids.grids.begin(), shown_->grids.grids.end(),
                     [](const Grid& grid) { return grid.count >= kEnoughLinked; });
}

void PlaceView::ShowCorners(const Place& place, const Eigen::Matrix2f& image_by_view, float scale, WorkMeter& work,
                            TracePlace* trace) {
  FindCornersIn(shown_->view.plane, shown_->scan, shown_->corners, shown_->refused);
  shown_->linker.Link(shown_->view, shown_->corners, shown_->grids);
  work.Add(WorkStep::kViewPixel, static_cast<std::uint64_t>(shown_->view.plane.width()) *
                                     static_cast<std::uint64_t>(shown_->view.plane.height()));
  work.Add(WorkStep::kPeak, shown_->scan.peaks().size());
  work.Add(shown_->linker.work());
  const float half = 0.5f * static_cast<float>(shown_->view.plane.width() - 1);
  for (Corner& corner : shown_->corners) {
    corner.position = place.middle + image_by_view * (corner.position - Eigen::Vector2f::Constant(half));
    corner.scale = scale;
  }
  if (trace) NoteView(place, image_by_view, *trace);
}

void PlaceView::NoteView(const Place& place, const Eigen::Matrix2f& image_by_view, TracePlace& told) const {
  const BytePlane& plane = shown_->view.plane;
  told.center_px = place.middle.cast<double>();
  told.side = plane.width();
  ++told.views;
  told.view.clear();
  for (int y = 0; y < plane.height(); ++y) told.view.insert(told.view.end(), plane.row(y), plane.row(y) + told.side);
  const Eigen::Vector2f half = Eigen::Vector2f::Constant(0.5f * static_cast<float>(told.side - 1));
  told.image_from_view << image_by_view, place.middle - image_by_view * half;
  told.outline_px = OutlineAround(place.middle, image_by_view, half + Eigen::Vector2f::Constant(0.5f));
}

}  // namespace chequer
