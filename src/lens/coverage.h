#pragma once

#include <array>
#include <span>
#include <string>

#include "lens/lens_views.h"

namespace chequer {

/// How much of the image the views cover.
class Coverage {
 public:
  static constexpr int kCols = 12, kRows = 8;

  Coverage(int width, int height) : width_(width), height_(height) {}

  void Add(const LensView& view);
  /// Views that show a point in a part of the image.
  int CountAt(int col, int row) const { return counts_[static_cast<std::size_t>(row * kCols + col)]; }
  /// Share of the parts that at least two views cover.
  double Share() const;
  /// Where the target should be held next, such as "top left"; empty where all is covered.
  std::string Where() const;
  /// The parts as lines of text: '.' for none, digits, '+' for ten and more.
  std::string Picture() const;

 private:
  int width_, height_;
  std::array<int, kCols * kRows> counts_{};
};

/// How much a view is tilted against the others of the same size: the ratio of its largest to its smallest scale, 1 for
/// a target that is seen straight.
double Foreshortening(const LensView& view);

}  // namespace chequer
