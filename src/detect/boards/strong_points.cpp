#include "detect/boards/strong_points.h"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>

namespace chequer {
namespace {

/// Beyond the edges' blur, inside what lies around narrow cells, px.
constexpr std::array<std::array<float, 2>, InkSigns::kAround> kOffsets{
    {{4, 0}, {0, 4}, {-4, 0}, {0, -4}, {3, 3}, {-3, 3}, {-3, -3}, {3, -3}}};
/// The ink at the first pixels around a point: of four of a board's cells, one has ink for the most part (a guess).
constexpr float kLeastInkAtFirst = 0.15f;

/// Sides of the tiles that count points, px, as a power of two (a guess).
constexpr int kTileShift = 5;
/// Points of a place that are asked for inks (a guess).
constexpr std::size_t kMostAsked = 3;
/// Places that are larger than that are no boards, px (a guess).
constexpr float kMostSpread = 160;
/// Fewer points hide no board. They are all kept: where cells are very narrow, inks run together and do not show (a
/// guess).
constexpr std::size_t kManyPoints = 100;
/// Of more points, the weakest are left out: they come from print and endless textures. Five hundred boards that the
/// first look misses have as many (a guess).
constexpr std::size_t kMostPoints = 10'000;
/// Steps from the fullest tile on, as far as the points go on (a guess).
constexpr int kMostGathered = 6;
/// Times that each point is asked where it belongs, at most, for a place: by two counts, the steps, and Forget().
constexpr std::uint64_t kPassesOfPlace = 2 + kMostGathered + 1;

/// Leaves out the weakest of too many, and of equals the last.
void KeepStrongest(std::size_t most, std::vector<StrongPoint>& points) {
  if (points.size() <= most) return;
  std::vector<float> contrasts;
  for (const StrongPoint& point : points) contrasts.push_back(point.contrast);
  const auto weakest = contrasts.begin() + static_cast<std::ptrdiff_t>(most - 1);
  std::nth_element(contrasts.begin(), weakest, contrasts.end(), std::greater<>());
  const float least = *weakest;
  std::size_t equals = most - static_cast<std::size_t>(std::count_if(contrasts.begin(), weakest,
                                                                     [&](float contrast) { return contrast > least; }));
  std::erase_if(points, [&](const StrongPoint& point) {
    if (point.contrast != least) return point.contrast < least;
    return equals == 0 || equals-- == 0;
  });
}

}  // namespace

void InkSigns::Add(const LightReader& reader, const Eigen::Vector2f& at, std::size_t first, std::size_t past) {
  for (std::size_t i = first; i < past; ++i) {
    const Eigen::Vector3f rgb = reader.RoughRgb(at.x() + kOffsets[i][0], at.y() + kOffsets[i][1], 0);
    // A mean of red and green would take a green circuit board for ink.
    yellow_ = std::max(yellow_, std::min(rgb[0], rgb[1]) - rgb[2]);
    blue_ = std::max(blue_, rgb[2] - std::max(rgb[0], rgb[1]));
    light_ = std::max(light_, rgb.sum() / 3);
  }
}

bool ShowsInks(const LightReader& reader, const Eigen::Vector2f& at) {
  InkSigns signs;
  signs.Add(reader, at, 0, InkSigns::kFirstAround);
  if (!signs.AreThere(kLeastInkAtFirst)) return false;
  signs.Add(reader, at, InkSigns::kFirstAround);
  return signs.AreThere();
}

int StrongPoints::cols() const { return (width_ >> kTileShift) + 1; }
int StrongPoints::rows() const { return (height_ >> kTileShift) + 1; }

std::size_t StrongPoints::TileOf(float x, float y) const {
  const int col = std::clamp(static_cast<int>(x) >> kTileShift, 0, cols() - 1),
            row = std::clamp(static_cast<int>(y) >> kTileShift, 0, rows() - 1);
  return static_cast<std::size_t>(row * cols() + col);
}

void StrongPoints::Start(int width, int height, std::span<const StrongPoint> points, float least,
                         std::span<const PixelBox> boards) {
  width_ = width;
  height_ = height;
  explained_.assign(static_cast<std::size_t>(cols() * rows()), 0);
  for (const PixelBox& box : boards) {
    const std::size_t first = TileOf(box.left, box.top), last = TileOf(box.right, box.bottom),
                      across = TileOf(box.right, box.top) - first;
    for (std::size_t row = first; row + across <= last; row += static_cast<std::size_t>(cols()))
      std::fill_n(explained_.begin() + static_cast<std::ptrdiff_t>(row), across + 1, std::uint8_t{1});
  }
  for (const StrongPoint& point : points)
    if (point.contrast >= least && !explained_[TileOf(point.position.x(), point.position.y())])
      points_.push_back(point);
}

void StrongPoints::ThinOut(const LightReader& reader, WorkMeter& work) {
  if (std::exchange(thinned_out_, true) || points_.size() <= kManyPoints) return;
  KeepStrongest(kMostPoints, points_);
  KeepInks(reader, work);
}

void StrongPoints::KeepInks(const LightReader& reader, WorkMeter& work) {
  // They lie all over the image: the memory is asked for what some of the next will need.
  constexpr std::size_t kAhead = 8;
  constexpr float kReachPx = InkSigns::kAroundPx;
  work.Add(WorkStep::kInkProbe, points_.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (i + kAhead < points_.size()) {
      const Eigen::Vector2f& at = points_[i + kAhead].position;
      PixelBox box;
      box.Add(at.x() - kReachPx, at.y() - kReachPx);
      box.Add(at.x() + kReachPx, at.y() + kReachPx);
      reader.Prefetch(box);
    }
    if (ShowsInks(reader, points_[i].position)) points_[kept++] = points_[i];
  }
  points_.resize(kept);
}

std::optional<Place> StrongPoints::FindPlace(WorkMeter& work) {
  if (points_.empty()) return std::nullopt;
  const auto tile_of = [&](const StrongPoint& point) { return TileOf(point.position.x(), point.position.y()); };
  in_tile_.assign(static_cast<std::size_t>(cols() * rows()), 0);
  std::size_t fullest = 0;
  for (const StrongPoint& point : points_) {
    const std::size_t tile = tile_of(point);
    if (++in_tile_[tile] > in_tile_[fullest]) fullest = tile;
  }
  work.Add(WorkStep::kComparison, 2 * points_.size());
  Place place;
  const float side = static_cast<float>(1 << kTileShift);
  const int tile = static_cast<int>(fullest);
  place.middle =
      side * Eigen::Vector2f(static_cast<float>(tile % cols()) + 0.5f, static_cast<float>(tile / cols()) + 0.5f);
  place.spread.setConstant(side / 2);
  for (int i = 0, before = -1; i < kMostGathered && place.count != before; ++i) {
    before = place.count;
    work.Add(WorkStep::kComparison, points_.size());
    place = GatherPoints(points_, place);
  }
  members_.clear();
  for (const StrongPoint& point : points_)
    if (members_.size() < kMostAsked && IsWithinReach(place, point.position)) members_.push_back(point.position);
  if (place.count < kFewest || IsTooLarge(place))
    std::erase_if(points_, [&](const StrongPoint& point) { return tile_of(point) == fullest; });
  return place;
}

bool StrongPoints::IsTooLarge(const Place& place) { return place.count >= kFewest && place.spread[0] > kMostSpread; }

void StrongPoints::Forget(const Place& place, WorkMeter& work) {
  work.Add(WorkStep::kComparison, points_.size());
  std::erase_if(points_, [&](const StrongPoint& point) { return IsWithinReach(place, point.position); });
}

std::uint64_t StrongPoints::MostInstructions(int places) const {
  if (points_.size() < kFewest) return 0;
  const std::uint64_t kept = std::min(points_.size(), kMostPoints);
  std::uint64_t instructions =
      kept * kPassesOfPlace * static_cast<std::uint64_t>(places) * WorkMeter::Instructions(WorkStep::kComparison);
  if (kept > kManyPoints) instructions += kept * WorkMeter::Instructions(WorkStep::kInkProbe);
  return instructions;
}

}  // namespace chequer
