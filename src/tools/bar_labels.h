#pragma once

#include <span>
#include <vector>

#include "tools/canvas.h"

namespace chequer {

/// How the values of a bar chart are written over its bars, so that none covers another or a bar: level where each is
/// as narrow as its bar, upwards where the letters are, not at all where bars are narrower still (a legend has them
/// then).
class BarLabels {
 public:
  /// @param bar_width of every bar, which stand at least 2 apart.
  BarLabels(const Canvas& canvas, std::span<const double> values, double bar_width);

  /// The room that labels need above a bar.
  double height() const { return height_; }
  /// Writes a value over the bar whose top begins at (left, top).
  void Write(Canvas& canvas, double value, double left, double top, const Ink& ink) const;

  enum class Style : std::uint8_t { kLevel, kUpwards, kNone };
  Style style() const { return style_; }

 private:
  Style style_ = Style::kNone;
  double bar_width_ = 0;
  double size_ = 0;  ///< of the letters
  double height_ = 0;
};

}  // namespace chequer
