#include "detect/corners.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

namespace chequer {
namespace {

/// Least response of a peak, grey levels: a corner of 8-bit contrast C answers with 0.3 C to 0.6 C, noise of 1 to 2
/// levels with 1 to 3.
constexpr std::uint8_t kLeastResponse = 4;
/// Least share of the contrast in the response; corners of sharp cells have 0.3 and more at cells of 4 px, 0.18 tilted
/// by 60 degrees; clutter mostly less.
constexpr float kLeastShare = 0.10f;

/// Cosine of how far opposite edges may be from a straight line (43 degrees).
constexpr float kStraight = 0.73f;

/// Rows of the image that are worked on together: few enough for the second cache, and a multiple of 4, so that every
/// level gets whole rows.
constexpr int kBandRows = 16;
static_assert(kBandRows % (1 << (Pyramid::kLevels - 1)) == 0);

/// How many peaks ahead the memory is asked for what lies around them.
constexpr std::size_t kPeaksAhead = 12;

/// Peaks a pixel that are a lot, and the least share of the response that one in twenty reaches.
constexpr double kManyPeaks = 0.002;
constexpr float kWeakShare = 0.15f;

constexpr int kRing = 12;
struct Offset {
  int x, y;
};
/// By growing angle from (3, 1).
constexpr std::array<Offset, kRing> kOffsets{
    {{3, 1}, {2, 2}, {1, 3}, {-1, 3}, {-2, 2}, {-3, 1}, {-3, -1}, {-2, -2}, {-1, -3}, {1, -3}, {2, -2}, {3, -1}}};

/// Peak of a parabola through three values, −½..½.
float ParabolaPeak(int left, int middle, int right) {
  const int curvature = 2 * middle - left - right;
  return curvature > 0
             ? std::clamp(0.5f * static_cast<float>(right - left) / static_cast<float>(curvature), -0.5f, 0.5f)
             : 0.0f;
}

/// The ring's places in a plane with rows so far apart.
std::array<std::ptrdiff_t, kRing> RingOf(std::ptrdiff_t stride) {
  std::array<std::ptrdiff_t, kRing> ring;
  for (std::size_t i = 0; i < kRing; ++i) ring[i] = kOffsets[i].y * stride + kOffsets[i].x;
  return ring;
}

/// The four edges from the values on the ring; nothing if it does not change between light and dark exactly four times
/// or opposite edges are not in line.
std::optional<Corner> Saddle(const BytePlane& plane, const std::array<std::ptrdiff_t, kRing>& ring, const Peak& peak) {
  const std::uint8_t* center = plane.row(peak.y) + peak.x;
  std::array<int, kRing> value;
  int sum = 0;
  for (std::size_t i = 0; i < kRing; ++i) sum += value[i] = center[ring[i]];
  // All of it in integers and without branches, which the compiler turns into vectors.
  const int mean = sum / kRing;
  int light_sum = 0, light_count = 0;
  for (std::size_t i = 0; i < kRing; ++i) {
    const int is_light = -(value[i] > mean);  // all bits
    light_sum += is_light & value[i];
    light_count -= is_light;
  }
  if (light_count == 0 || light_count == kRing) return std::nullopt;
  const float light = static_cast<float>(light_sum) / static_cast<float>(light_count);
  const float dark = static_cast<float>(sum - light_sum) / static_cast<float>(kRing - light_count);
  const float contrast = light - dark;
  if (static_cast<float>(peak.response) < kLeastShare * contrast) return std::nullopt;
  const float middle = (light + dark) / 2;

  // Where the ring crosses between light and dark: the rising ones, then the falling ones, by growing angle.
  const int whole = static_cast<int>(middle), least = whole + (static_cast<float>(whole) < middle);
  unsigned lighter = 0;
  for (std::size_t i = 0; i < kRing; ++i) lighter |= static_cast<unsigned>(-(value[i] >= least)) & 1u << i;
  const unsigned next_lighter = (lighter >> 1 | lighter << (kRing - 1)) & ((1u << kRing) - 1);
  const unsigned rises = next_lighter & ~lighter, falls = lighter & ~next_lighter;
  // On a ring, there are as many falls as rises.
  const unsigned second = rises & (rises - 1);
  if (second == 0 || (second & (second - 1)) != 0) return std::nullopt;
  std::array<Eigen::Vector2f, 4> crossing;
  std::size_t count = 0;
  for (unsigned changes : {rises, falls})
    for (; changes != 0; changes &= changes - 1) {
      const std::size_t i = static_cast<std::size_t>(std::countr_zero(changes)), next = i + 1 == kRing ? 0 : i + 1;
      const float part = (static_cast<float>(value[i]) - middle) / static_cast<float>(value[i] - value[next]);
      const Offset &from = kOffsets[i], &to = kOffsets[next];
      crossing[count++] = {static_cast<float>(from.x) + part * static_cast<float>(to.x - from.x),
                           static_cast<float>(from.y) + part * static_cast<float>(to.y - from.y)};
    }
  // Opposite edges lie half a turn apart.
  const auto straight = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    const float dot = a.dot(b);
    return dot < 0 && dot * dot > kStraight * kStraight * a.squaredNorm() * b.squaredNorm();
  };
  if (!straight(crossing[0], crossing[1]) || !straight(crossing[2], crossing[3])) return std::nullopt;
  const Eigen::Vector2f up = (crossing[0] - crossing[1]).normalized();
  Eigen::Vector2f down = (crossing[2] - crossing[3]).normalized();
  // The falling ray comes within half a turn after the rising one.
  if (up.x() * down.y() - up.y() * down.x() < 0) down = -down;

  Corner corner;
  corner.rays = {up, down, -up, -down};
  corner.contrast = contrast;
  corner.position = {static_cast<float>(peak.x) + ParabolaPeak(peak.left, peak.response, peak.right),
                     static_cast<float>(peak.y) + ParabolaPeak(peak.above, peak.response, peak.below)};
  return corner;
}

/// Brings the pixels around a peak near: planes of large frames lie in far caches.
void AskFor(const BytePlane& plane, const Peak& peak) {
  for (int y = -3; y <= 3; ++y) __builtin_prefetch(plane.row(peak.y + y) + peak.x);
}

/// Where there is a lot to look at, leaves out what is much weaker than the strongest: of a board, all corners are
/// alike, so what goes is grain and grout, or a board in light many times as dim as its surroundings.
void LimitPeaks(double area_px, std::vector<Peak>& peaks) {
  if (static_cast<double>(peaks.size()) <= kManyPeaks * area_px) return;
  std::array<std::size_t, 256> count{};
  for (const Peak& peak : peaks) ++count[peak.response];
  std::size_t above = 0;
  int strong = 255;
  while (strong > 0 && (above += count[static_cast<std::size_t>(strong)]) < peaks.size() / 20) --strong;
  const int least = static_cast<int>(kWeakShare * static_cast<float>(strong));
  std::erase_if(peaks, [&](const Peak& peak) { return peak.response < least; });
  if (peaks.size() <= kMaxPeaks) return;
  std::nth_element(peaks.begin(), peaks.begin() + kMaxPeaks, peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.response > b.response; });
  peaks.resize(kMaxPeaks);
}

/// Where corners of finer levels lie, one bit for every block of 2 × 2 image pixels.
class Occupancy {
 public:
  Occupancy(std::vector<std::uint64_t>& words, int width, int height)
      : words_(words),
        cols_(width / 2 + 2),
        rows_(height / 2 + 2),
        row_words_(static_cast<std::size_t>(cols_ / 64) + 2) {
    words_.assign(row_words_ * static_cast<std::size_t>(rows_), 0);
  }
  void Mark(const Eigen::Vector2f& p) {
    const std::size_t col = Col(p.x());
    words_[Row(p.y()) * row_words_ + col / 64] |= std::uint64_t{1} << col % 64;
  }
  /// @param radius below 60 px.
  bool Near(const Eigen::Vector2f& p, float radius) const {
    const std::size_t first = Col(p.x() - radius), last = Col(p.x() + radius), shift = first % 64;
    std::uint64_t found = 0;
    for (std::size_t row = Row(p.y() - radius); row <= Row(p.y() + radius); ++row) {
      // Each row has a word more than it needs.
      const std::uint64_t* word = words_.data() + row * row_words_ + first / 64;
      found |= word[0] >> shift | word[1] << 1 << (63 - shift);
    }
    return (found & ((std::uint64_t{2} << (last - first)) - 1)) != 0;
  }

 private:
  std::size_t Col(float x) const { return static_cast<std::size_t>(std::clamp(static_cast<int>(x / 2), 0, cols_ - 1)); }
  std::size_t Row(float y) const { return static_cast<std::size_t>(std::clamp(static_cast<int>(y / 2), 0, rows_ - 1)); }

  std::vector<std::uint64_t>& words_;
  int cols_, rows_;
  std::size_t row_words_;
};

/// Fills planes and scans for peaks, band by band: each row is used by all while it is in a near cache.
void Scan(const ImageView& image, Pyramid& pyramid) {
  StartDetectionPlane(image, pyramid.base);
  for (std::size_t level = 0; level < Pyramid::kLevels; ++level) {
    const BytePlane& plane = pyramid.level(static_cast<int>(level));
    pyramid.scans[level].Start(plane, kLeastResponse);
    if (level + 1 < Pyramid::kLevels) pyramid.halves[level].Resize(plane.width() / 2, plane.height() / 2);
  }
  const int height = pyramid.base.plane.height();
  for (int first = 0; first < height; first += kBandRows) {
    int from = first, past = std::min(first + kBandRows, height);
    FillDetectionPlane(image, from, past, pyramid.base);
    for (std::size_t level = 0; level < Pyramid::kLevels; ++level) {
      const BytePlane& plane = pyramid.level(static_cast<int>(level));
      pyramid.scans[level].Advance(plane, past);
      if (level + 1 == Pyramid::kLevels) break;
      from /= 2;
      past /= 2;
      HalveRows(plane, from, past, pyramid.halves[level]);
    }
  }
}

}  // namespace

int FindCorners(const ImageView& image, Pyramid& pyramid, std::vector<Corner>& corners,
                std::vector<Eigen::Vector2f>* refused_px) {
  corners.clear();
  Scan(image, pyramid);
  int looked_at = 0;
  Occupancy occupancy(pyramid.occupied, pyramid.base.plane.width(), pyramid.base.plane.height());
  for (int level = 0; level < Pyramid::kLevels; ++level) {
    const BytePlane& plane = pyramid.level(level);
    std::vector<Peak>& peaks = pyramid.scans[static_cast<std::size_t>(level)].peaks();
    LimitPeaks(static_cast<double>(plane.width()) * plane.height(), peaks);
    looked_at += static_cast<int>(peaks.size());
    const float scale = static_cast<float>(1 << level);
    const std::array<std::ptrdiff_t, kRing> ring = RingOf(plane.stride());
    const std::size_t finer = corners.size();
    for (std::size_t i = 0; i < peaks.size(); ++i) {
      if (i + kPeaksAhead < peaks.size()) AskFor(plane, peaks[i + kPeaksAhead]);
      const Peak& peak = peaks[i];
      // Each corner counts at the finest level that shows it.
      const Eigen::Vector2f at = pyramid.ToImage({static_cast<float>(peak.x), static_cast<float>(peak.y)}, level);
      if (level > 0 && occupancy.Near(at, 2 * scale)) continue;
      std::optional<Corner> corner = Saddle(plane, ring, peak);
      if (!corner) {
        if (refused_px) refused_px->push_back(at);
        continue;
      }
      corner->position = pyramid.ToImage(corner->position, level);
      corner->scale = scale;
      corners.push_back(*corner);
    }
    for (std::size_t i = finer; i < corners.size(); ++i) occupancy.Mark(corners[i].position);
  }
  return looked_at;
}

}  // namespace chequer
