#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "detect/common/light.h"

namespace chequer {

/// What the pixels around points show of yellow and blue.
class InkSigns {
 public:
  /// The pixels around a point that show its cells' colours. The first four tell most of clutter.
  static constexpr std::size_t kAround = 8, kFirstAround = 4;
  /// The farthest of them, px: the largest of the offsets.
  static constexpr float kAroundPx = 4;

  /// Looks at the pixels around a point from `first` to before `past`.
  void Add(const LightReader& reader, const Eigen::Vector2f& at, std::size_t first = 0, std::size_t past = kAround);
  /// @param least by how much yellow returns less blue than red and green, and blue more, together, as a share of the
  /// light.
  bool AreThere(float least = kLeastInk) const { return yellow_ + blue_ > least * light_; }

 private:
  /// White and ink make 0.6 to 1.5 even where cells are 3 px high, photographs mostly less than 0.3.
  static constexpr float kLeastInk = 0.55f;

  float yellow_ = 0, blue_ = 0, light_ = 0;
};

/// Whether a point stands among yellow and blue. Clutter around a board, which would hide how the board's own points
/// spread, hardly ever does.
bool ShowsInks(const LightReader& reader, const Eigen::Vector2f& at);

}  // namespace chequer
