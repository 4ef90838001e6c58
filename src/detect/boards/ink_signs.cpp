#include "detect/boards/ink_signs.h"

#include <algorithm>
#include <array>

namespace chequer {
namespace {

/// Beyond the edges' blur, inside what lies around narrow cells, px.
constexpr std::array<std::array<float, 2>, InkSigns::kAround> kOffsets{
    {{4, 0}, {0, 4}, {-4, 0}, {0, -4}, {3, 3}, {-3, 3}, {-3, -3}, {3, -3}}};
/// The ink at the first pixels around a point: of four of a board's cells, one has ink for the most part (a guess).
constexpr float kLeastInkAtFirst = 0.15f;

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

}  // namespace chequer
