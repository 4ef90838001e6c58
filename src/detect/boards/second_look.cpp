#include "detect/boards/second_look.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "detect/boards/affine_view.h"
#include "detect/boards/motion_blur_view.h"
#include "detect/common/smooth_rows.h"

namespace chequer {
namespace {

/// Fewer points are no place: a board that can be read leaves more behind.
constexpr int kFewestPoints = 6;
/// Sides of the tiles that count points, px, as a power of two.
constexpr int kTileShift = 5;
/// What lies so near to a board's points is of that board for the most part, px.
constexpr float kSeedPx = 14;
/// Points of a place that are asked for inks.
constexpr std::size_t kMostAsked = 3;
/// Cells in the view, px, and its half side in cells: a board of six and what the spread misjudges.
constexpr float kCellPx = 8, kHalfCells = 5.5f;
constexpr int kViewPx = static_cast<int>(2 * kHalfCells * kCellPx);
/// Beyond that, pixels are only blown up; with less, a coarser plane shows as much.
constexpr float kMostZoom = 3, kLeastZoom = 1.2f;
/// Smaller cells are not seen in a view of the most zoom, which shows them 3.5 px high: points spread like that along
/// lines.
constexpr float kLeastCellPx = 3.5f / kMostZoom;
/// Other places had their chance in the first look, px: a spread that is so many times longer than wide, or cells that
/// are smaller.
constexpr float kLeastSlant = 1.8f, kMostCellPx = 4.5f;
/// Points of a place whose cells are wider: all corners of such a board leave one, and chance gathers fewer.
constexpr int kFewestOfWide = 18;
/// Views of a place, each by what the one before it showed; one shows a board where so many corners are linked.
constexpr int kMostViews = 2, kEnoughLinked = 12;
/// Share of the most contrast that corners of one board have at least.
constexpr float kShareOfMost = 0.4f;
/// A place changes along one direction by no more than that, of what it changes across, if it holds a motion-blurred
/// board: blurred by a motion of 1.2 cells, 0.05 to 0.35; by less, the first look shows it.
constexpr float kMostEven = 0.55f;
/// Places that are considered; of few points, as those of an image without anything else.
constexpr int kMostPlaces = 6, kMostSparse = 2;
/// Blur of common images, px: of a view that is stretched along y it is much the same along y as what the smoothing
/// makes of it along x. Uneven blur would leave ridges where corners are.
constexpr float kBlurPx = 0.8f;
/// Places that are larger than that are no boards, px.
constexpr float kMostSpread = 160;
/// Fewer points hide nothing, and where cells are very narrow, colours that ran together would take the board's own.
constexpr std::size_t kManyPoints = 100;
/// Of more than these, the weakest are left out: print and textures without end. Five hundred boards that no first look
/// shows have as many.
constexpr std::size_t kMostPoints = 10'000;
/// The pixels around a point that show its cells' colours, px: beyond the edges' blur, inside what lies around narrow
/// cells. The first four tell most of clutter.
constexpr std::array<std::array<float, 2>, 8> kAround{
    {{4, 0}, {0, 4}, {-4, 0}, {0, -4}, {3, 3}, {-3, 3}, {-3, -3}, {3, -3}}};
constexpr std::size_t kFirstAround = 4;
/// As far as they lie from it, px.
constexpr float kAroundPx = 4;
/// By how much yellow returns less blue than red and green, and blue more, together, as a share of the light: white and
/// ink make 0.6 to 1.5 of it even where cells are 3 px high, photographs mostly less than 0.3.
constexpr float kLeastInk = 0.55f;
/// The same along a place whose points have it: cells of one ink lie there by chance.
constexpr float kLeastInkAlong = 0.35f;
/// The same at the first pixels around a point: of four of a board's cells, one has ink for the most part.
constexpr float kLeastInkAtFirst = 0.15f;

/// Leaves out the weakest of too many, and of equals the last.
void KeepStrongest(std::size_t most, std::vector<StrongPoint>& points) {
  if (points.size() <= most) return;
  std::vector<float> contrasts;
  for (const StrongPoint& point : points) contrasts.push_back(point.contrast);
  const auto weakest = contrasts.begin() + static_cast<std::ptrdiff_t>(most - 1);
  std::nth_element(contrasts.begin(), weakest, contrasts.end(), std::greater<>());
  const float least = *weakest;
  std::size_t equals = most - static_cast<std::size_t>(std::count_if(
                                  contrasts.begin(), weakest, [&](float contrast) { return contrast > least; }));
  std::erase_if(points, [&](const StrongPoint& point) {
    if (point.contrast != least) return point.contrast < least;
    return equals == 0 || equals-- == 0;
  });
}

/// Times that each point is asked where it belongs, at most.
constexpr std::uint64_t kMostPasses = 9 * kMostPlaces;

/// Whether the first look may have missed a board there.
bool MayHaveEscaped(const Place& place) {
  return place.cell_px() < kMostCellPx || place.spread[0] > kLeastSlant * place.spread[1];
}

/// What the pixels around points show of the inks.
class InkSigns {
 public:
  void Add(const LightReader& reader, const Eigen::Vector2f& at,
           std::span<const std::array<float, 2>> around = kAround) {
    for (const auto& [x, y] : around) {
      const Eigen::Vector3f rgb = reader.RoughRgb(at.x() + x, at.y() + y, 0);
      // A mean of red and green would take a green circuit board for ink.
      yellow_ = std::max(yellow_, std::min(rgb[0], rgb[1]) - rgb[2]);
      blue_ = std::max(blue_, rgb[2] - std::max(rgb[0], rgb[1]));
      light_ = std::max(light_, rgb.sum() / 3);
    }
  }
  bool AreThere(float least = kLeastInk) const { return yellow_ + blue_ > least * light_; }

 private:
  float yellow_ = 0, blue_ = 0, light_ = 0;
};

/// Whether a point stands among yellow and blue. Clutter around a board, which would hide how the board's own points
/// spread, hardly ever does.
bool ShowsInks(const LightReader& reader, const Eigen::Vector2f& at) {
  const std::span around(kAround);
  InkSigns signs;
  signs.Add(reader, at, around.first(kFirstAround));
  if (!signs.AreThere(kLeastInkAtFirst)) return false;
  signs.Add(reader, at, around.subspan(kFirstAround));
  return signs.AreThere();
}

}  // namespace

std::uint64_t SecondLook::MostUnits() const {
  if (image_->points.size() < kFewestPoints) return 0;
  const std::uint64_t kept = std::min(image_->points.size(), kMostPoints);
  std::uint64_t instructions = kept * kMostPasses * WorkMeter::Instructions(WorkStep::kComparison);
  if (kept > kManyPoints) instructions += kept * WorkMeter::Instructions(WorkStep::kInkProbe);
  return instructions / WorkMeter::kInstructionsPerUnit + kMostLooks * kMostUnitsOfLook;
}

void SecondLook::Start(const LightReader& reader, std::span<const StrongPoint> points, float least,
                       std::span<const PixelBox> boards, std::vector<TracePlace>* trace) {
  image_.Start().trace = trace;
  image_->width = reader.width();
  image_->height = reader.height();
  const int cols = (image_->width >> kTileShift) + 1, rows = (image_->height >> kTileShift) + 1;
  const auto tile = [](float at, int count) { return std::clamp(static_cast<int>(at) >> kTileShift, 0, count - 1); };
  image_->explained.assign(static_cast<std::size_t>(cols * rows), 0);
  for (const PixelBox& box : boards)
    for (int row = tile(box.top, rows); row <= tile(box.bottom, rows); ++row)
      for (int col = tile(box.left, cols); col <= tile(box.right, cols); ++col)
        image_->explained[static_cast<std::size_t>(row * cols + col)] = 1;
  for (const StrongPoint& point : points)
    if (point.contrast >= least && !image_->explained[static_cast<std::size_t>(tile(point.position.y(), rows) * cols +
                                                                               tile(point.position.x(), cols))])
      image_->points.push_back(point);
}

void SecondLook::ThinOut(const LightReader& reader) {
  if (std::exchange(image_->thinned_out, true) || image_->points.size() <= kManyPoints) return;
  KeepStrongest(kMostPoints, image_->points);
  KeepInks(reader);
}

void SecondLook::KeepInks(const LightReader& reader) {
  // They lie all over the image: the memory is asked for what some of the next will need.
  constexpr std::size_t kAhead = 8;
  image_->work.Add(WorkStep::kInkProbe, image_->points.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < image_->points.size(); ++i) {
    if (i + kAhead < image_->points.size()) {
      const Eigen::Vector2f& at = image_->points[i + kAhead].position;
      PixelBox box;
      box.Add(at.x() - kAroundPx, at.y() - kAroundPx);
      box.Add(at.x() + kAroundPx, at.y() + kAroundPx);
      reader.Prefetch(box);
    }
    if (ShowsInks(reader, image_->points[i].position)) image_->points[kept++] = image_->points[i];
  }
  image_->points.resize(kept);
}

std::optional<Place> SecondLook::FindPlace() {
  if (image_->points.empty()) return std::nullopt;
  const int cols = (image_->width >> kTileShift) + 1, rows = (image_->height >> kTileShift) + 1;
  image_->in_tile.assign(static_cast<std::size_t>(cols * rows), 0);
  const auto tile_of = [&](const StrongPoint& point) {
    return (std::clamp(static_cast<int>(point.position.y()) >> kTileShift, 0, rows - 1)) * cols +
           std::clamp(static_cast<int>(point.position.x()) >> kTileShift, 0, cols - 1);
  };
  int fullest = 0;
  for (const StrongPoint& point : image_->points) {
    const int tile = tile_of(point);
    if (++image_->in_tile[static_cast<std::size_t>(tile)] > image_->in_tile[static_cast<std::size_t>(fullest)])
      fullest = tile;
  }
  image_->work.Add(WorkStep::kComparison, 2 * image_->points.size());
  Place place;
  const float side = static_cast<float>(1 << kTileShift);
  place.middle =
      side * Eigen::Vector2f(static_cast<float>(fullest % cols) + 0.5f, static_cast<float>(fullest / cols) + 0.5f);
  place.spread.setConstant(side / 2);
  // From the fullest tile on, as far as the points go on.
  for (int i = 0, before = -1; i < 6 && place.count != before; ++i) {
    before = place.count;
    image_->work.Add(WorkStep::kComparison, image_->points.size());
    place = GatherPoints(image_->points, place);
  }
  image_->members.clear();
  for (const StrongPoint& point : image_->points)
    if (image_->members.size() < kMostAsked && IsWithinReach(place, point.position))
      image_->members.push_back(point.position);
  if (place.count < kFewestPoints || place.spread[0] > kMostSpread) {
    std::erase_if(image_->points, [&](const StrongPoint& point) { return tile_of(point) == fullest; });
    if (place.count < kFewestPoints) return place;
    if (image_->trace) NotePlace(place, PlaceFate::kTooLarge);
    place.count = 0;
  }
  return place;
}

void SecondLook::View(const Pyramid& pyramid, const Place& place) {
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
  ShowCorners(place, image_by_view, scale);
}

void SecondLook::LookAt(const Pyramid& pyramid, Place place) {
  for (int view = 0; view < kMostViews; ++view) {
    View(pyramid, place);
    if (ShowsBoard()) return;
    // What looks like corners now tells better where they lie, and how they spread.
    float most = 0;
    for (const Corner& corner : shown_->corners) most = std::max(most, corner.contrast);
    for (const Corner& corner : shown_->corners)
      if (corner.contrast > kShareOfMost * most) shown_->seen.push_back({corner.position, corner.contrast});
    place = GatherPoints(shown_->seen, place);
    if (place.count < kFewestPoints) return;
  }
}

PlaceFate SecondLook::Judge(const Place& place) {
  if (place.count < kFewestPoints) return PlaceFate::kFewPoints;
  if (!MayHaveEscaped(place)) return PlaceFate::kFrontal;
  if (place.cell_px() < kLeastCellPx) return PlaceFate::kLine;
  return place.cell_px() >= kMostCellPx && place.count < kFewestOfWide ? PlaceFate::kSparse : PlaceFate::kViewed;
}

void SecondLook::Forget(const Place& place) {
  image_->work.Add(WorkStep::kComparison, image_->points.size());
  std::erase_if(image_->points, [&](const StrongPoint& point) { return IsWithinReach(place, point.position); });
}

void SecondLook::ShowCorners(const Place& place, const Eigen::Matrix2f& image_by_view, float scale) {
  FindCornersIn(shown_->view.plane, shown_->scan, shown_->corners, shown_->refused);
  shown_->linker.Link(shown_->view, shown_->corners, shown_->grids);
  image_->work.Add(WorkStep::kViewPixel, static_cast<std::uint64_t>(shown_->view.plane.width()) *
                                             static_cast<std::uint64_t>(shown_->view.plane.height()));
  image_->work.Add(WorkStep::kPeak, shown_->scan.peaks().size());
  image_->work.Add(shown_->linker.work());
  const float half = 0.5f * static_cast<float>(shown_->view.plane.width() - 1);
  for (Corner& corner : shown_->corners) {
    corner.position = place.middle + image_by_view * (corner.position - Eigen::Vector2f::Constant(half));
    corner.scale = scale;
  }
  if (image_->trace) NoteView(place, image_by_view);
}

bool SecondLook::LookThroughMotionBlur(const Pyramid& pyramid, const Place& place) {
  const float cell_px = std::sqrt(place.spread[0] * place.spread[1]) / kSpreadCells;
  int level = 0;
  while (level + 1 < Pyramid::kLevels && cell_px / static_cast<float>(2 << level) > kCellPx) ++level;
  const float scale = static_cast<float>(1 << level);
  const BytePlane& plane = pyramid.level(level);
  const Eigen::Vector2f middle = pyramid.FromImage(place.middle, level);
  const Change change = ChangeAround(plane, middle, cell_px / scale);
  if (change.share > kMostEven) return false;
  Eigen::Matrix2f image_by_view;
  image_by_view << change.least, Eigen::Vector2f(-change.least.y(), change.least.x());
  image_by_view *= cell_px / kCellPx;
  shown_.Start().motion_blurred = true;
  ViewPlane(plane, middle, image_by_view / scale, kViewPx, shown_->view.plane);
  EvenOutChange(static_cast<int>(kCellPx), shown_->view.plane, shown_->motion_blur);
  ShowCorners(place, image_by_view, scale);
  if (image_->trace) {
    image_->trace->back().fate = PlaceFate::kViewed;
    image_->trace->back().sharpened = true;
  }
  return true;
}

bool SecondLook::ShowsBoard() const {
  return std::any_of(shown_->grids.grids.begin(), shown_->grids.grids.end(),
                     [](const Grid& grid) { return grid.count >= kEnoughLinked; });
}

std::optional<Place> SecondLook::FindChange(const Pyramid& pyramid, const LightReader& reader,
                                            const Place& points) {
  InkSigns at_points, along_it;
  image_->work.Add(WorkStep::kInkProbe, image_->members.size() + 5);
  image_->work.Add(WorkStep::kPlace);
  for (const Eigen::Vector2f& point : image_->members) at_points.Add(reader, point);
  if (!at_points.AreThere()) return std::nullopt;
  std::optional<Place> place = PlaceOfChange(pyramid.base.plane, pyramid.FromImage(points.middle, 0), kSeedPx);
  if (!place || !MayHaveEscaped(*place)) return std::nullopt;
  place->middle = pyramid.ToImage(place->middle, 0);
  place->count = points.count;
  for (const float share : {-1.0f, -0.5f, 0.0f, 0.5f, 1.0f})
    along_it.Add(reader, place->middle + share * place->spread[0] * place->axes.col(0));
  return along_it.AreThere(kLeastInkAlong) ? place : std::nullopt;
}

void SecondLook::ViewSharpened(const Pyramid& pyramid, const Place& place) {
  // Along its narrow side, the lens has made the cells as even as motion would.
  const float scale = place.cell_px() / kCellPx, slant = place.spread[0] / place.spread[1];
  Eigen::Matrix2f image_by_view;
  image_by_view << scale * place.axes.col(1), -scale * slant * place.axes.col(0);
  shown_.Start();
  ViewPlane(pyramid.level(0), pyramid.FromImage(place.middle, 0), image_by_view, kViewPx, shown_->view.plane);
  EvenOutChange(static_cast<int>(kCellPx), shown_->view.plane, shown_->motion_blur);
  ShowCorners(place, image_by_view, 1);
  if (image_->trace) image_->trace->back().sharpened = true;
}

bool SecondLook::LookByChange(const Pyramid& pyramid, const LightReader& reader, const Place& points) {
  const std::optional<Place> place = FindChange(pyramid, reader, points);
  if (!place) return false;
  if (image_->trace) {
    NotePlace(*place, PlaceFate::kViewed);
    image_->trace->back().by_change = true;
  }
  Forget(*place);
  LookAt(pyramid, *place);
  if (!ShowsBoard()) ViewSharpened(pyramid, *place);
  return true;
}

void SecondLook::CountBoard() {
  --image_->looks;
  --image_->places;
}

bool SecondLook::MayGoOn() const {
  return image_->unclear ||
         (image_->looks < kMostLooks && image_->places < kMostPlaces && !image_->points.empty());
}

bool SecondLook::Next(const Pyramid& pyramid, const LightReader& reader) {
  ThinOut(reader);
  if (image_->unclear && LookByChange(pyramid, reader, *std::exchange(image_->unclear, std::nullopt))) return true;
  while (image_->looks < kMostLooks && image_->places < kMostPlaces) {
    const std::optional<Place> place = FindPlace();
    if (!place) return false;
    ++image_->places;
    if (place->count == 0) continue;
    const PlaceFate fate = Judge(*place);
    const bool by_points = fate == PlaceFate::kViewed || fate == PlaceFate::kFrontal;
    if (image_->trace && by_points) NotePlace(*place, fate);
    bool viewed = fate == PlaceFate::kViewed;
    if (viewed) LookAt(pyramid, *place);
    if (fate == PlaceFate::kFrontal) viewed = LookThroughMotionBlur(pyramid, *place);
    if (fate != PlaceFate::kFewPoints) Forget(*place);
    // Where points tell too little of a place, its pixels may tell more.
    if (viewed && !ShowsBoard()) image_->unclear = place;
    if (!viewed && (fate != PlaceFate::kFewPoints || ++image_->sparse <= kMostSparse))
      viewed = LookByChange(pyramid, reader, *place);
    if (image_->trace && !by_points && !viewed) NotePlace(*place, fate);
    // Where there is print, there are many lines.
    image_->looks += viewed || fate == PlaceFate::kLine;
    if (viewed) return true;
  }
  if (image_->trace) NoteTheRest();
  return false;
}

}  // namespace chequer
