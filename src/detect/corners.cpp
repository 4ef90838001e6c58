#include "detect/corners.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace chequer {
namespace {

/// Least response of a peak, grey levels: a corner of 8-bit contrast C answers with 0.3 C to 0.6 C, noise of 1 to 2
/// levels with 1 to 3.
constexpr std::uint8_t kLeastResponse = 4;
/// Least share of the contrast in the response; corners of sharp cells have 0.3 and more at cells of 4 px, 0.18 tilted
/// by 60 degrees; clutter mostly less.
constexpr float kLeastShare = 0.10f;

constexpr int kRing = 12;
struct Offset {
  int x, y;
};
/// By growing angle from (3, 1).
constexpr std::array<Offset, kRing> kOffsets{
    {{3, 1}, {2, 2}, {1, 3}, {-1, 3}, {-2, 2}, {-3, 1}, {-3, -1}, {-2, -2}, {-1, -3}, {1, -3}, {2, -2}, {3, -1}}};

/// Angles of the ring's pixels.
const std::array<float, kRing + 1>& RingAngles() {
  static const auto angles = [] {
    std::array<float, kRing + 1> a{};
    for (std::size_t i = 0; i < kRing; ++i) {
      const double angle = std::atan2(kOffsets[i].y, kOffsets[i].x);
      a[i] = static_cast<float>(angle < 0 ? angle + 2 * std::numbers::pi : angle);
    }
    a[kRing] = a[0] + static_cast<float>(2 * std::numbers::pi);
    return a;
  }();
  return angles;
}

/// Peak of a parabola through three values, −½..½.
float ParabolaPeak(int left, int middle, int right) {
  const int curvature = 2 * middle - left - right;
  return curvature > 0
             ? std::clamp(0.5f * static_cast<float>(right - left) / static_cast<float>(curvature), -0.5f, 0.5f)
             : 0.0f;
}

/// The four edges from the values on the ring; nothing if it does not change between light and dark exactly four times
/// or opposite edges are not in line.
std::optional<Corner> Saddle(const BytePlane& plane, const BytePlane& response, const Peak& peak) {
  std::array<int, kRing + 1> value;
  int sum = 0;
  for (std::size_t i = 0; i < kRing; ++i) sum += value[i] = plane.at(peak.x + kOffsets[i].x, peak.y + kOffsets[i].y);
  value[kRing] = value[0];
  int light_sum = 0, light_count = 0;
  for (std::size_t i = 0; i < kRing; ++i)
    if (kRing * value[i] > sum) light_sum += value[i], ++light_count;
  if (light_count == 0 || light_count == kRing) return std::nullopt;
  const float light = static_cast<float>(light_sum) / static_cast<float>(light_count);
  const float dark = static_cast<float>(sum - light_sum) / static_cast<float>(kRing - light_count);
  const float contrast = light - dark;
  if (static_cast<float>(peak.response) < kLeastShare * contrast) return std::nullopt;
  const float middle = (light + dark) / 2;

  std::array<float, 4> crossing{};  // angles; first the rising ones
  int rising = 0, falling = 0;
  const auto& angles = RingAngles();
  for (std::size_t i = 0; i < kRing; ++i) {
    const float a = static_cast<float>(value[i]) - middle, b = static_cast<float>(value[i + 1]) - middle;
    if ((a < 0) == (b < 0)) continue;
    const float angle = angles[i] + (angles[i + 1] - angles[i]) * a / (a - b);
    int& count = a < 0 ? rising : falling;
    if (count == 2) return std::nullopt;
    crossing[static_cast<std::size_t>((a < 0 ? 0 : 2) + count++)] = angle;
  }
  if (rising != 2 || falling != 2) return std::nullopt;

  constexpr float kPi = std::numbers::pi_v<float>;
  // Opposite edges lie half a turn apart.
  constexpr float kStraight = 0.75f;
  const float bend_rising = crossing[1] - crossing[0] - kPi, bend_falling = crossing[3] - crossing[2] - kPi;
  if (std::abs(bend_rising) > kStraight || std::abs(bend_falling) > kStraight) return std::nullopt;
  const float r = crossing[0] + bend_rising / 2;
  float f = crossing[2] + bend_falling / 2;
  while (f < r) f += kPi;
  while (f > r + kPi) f -= kPi;

  Corner corner;
  corner.rays[0] = {std::cos(r), std::sin(r)};
  corner.rays[1] = {std::cos(f), std::sin(f)};
  corner.rays[2] = -corner.rays[0];
  corner.rays[3] = -corner.rays[1];
  corner.contrast = contrast;
  const std::uint8_t* p = response.row(peak.y) + peak.x;
  corner.position = {static_cast<float>(peak.x) + ParabolaPeak(p[-1], p[0], p[1]),
                     static_cast<float>(peak.y) + ParabolaPeak(p[-response.stride()], p[0], p[response.stride()])};
  return corner;
}

/// The strongest kMaxPeaks of the peaks.
void LimitPeaks(std::vector<Peak>& peaks) {
  if (peaks.size() <= kMaxPeaks) return;
  std::nth_element(peaks.begin(), peaks.begin() + kMaxPeaks, peaks.end(),
                   [](const Peak& a, const Peak& b) { return a.response > b.response; });
  peaks.resize(kMaxPeaks);
}

}  // namespace

int FindCorners(Pyramid& pyramid, std::vector<Corner>& corners) {
  corners.clear();
  int looked_at = 0;
  for (int level = 0; level < Pyramid::kLevels; ++level) {
    if (level > 0) HalvePlane(pyramid.level(level - 1), pyramid.halves[static_cast<std::size_t>(level - 1)]);
    const BytePlane& plane = pyramid.level(level);
    BytePlane& response = pyramid.response[static_cast<std::size_t>(level)];
    CornerResponse(plane, response);
    pyramid.peaks.clear();
    FindPeaks(response, kLeastResponse, pyramid.peaks);
    LimitPeaks(pyramid.peaks);
    looked_at += static_cast<int>(pyramid.peaks.size());
    const float scale = static_cast<float>(1 << level);
    for (const Peak& peak : pyramid.peaks) {
      std::optional<Corner> corner = Saddle(plane, response, peak);
      if (!corner) continue;
      corner->position = pyramid.ToImage(corner->position, level);
      corner->scale = scale;
      corners.push_back(*corner);
    }
  }
  return looked_at;
}

}  // namespace chequer
