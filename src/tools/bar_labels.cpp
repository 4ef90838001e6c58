#include "tools/bar_labels.h"

#include <fmt/format.h>

#include <algorithm>

namespace chequer {
namespace {

constexpr double kLargestLabel = 11, kSmallestLabel = 7;  ///< letters; smaller ones are not read on a screen
/// Between a bar and its label.
constexpr double kGap = 4;
/// Of the letters' size: how tall digits are.
constexpr double kDigitHeight = 0.75;

std::string TextOf(double value) { return fmt::format("{:.3g}", value); }

}  // namespace

BarLabels::BarLabels(const Canvas& canvas, std::span<const double> values, double bar_width) : bar_width_(bar_width) {
  const auto widest = [&](double size) {
    double width = 0;
    for (const double value : values) width = std::max(width, canvas.TextWidth(TextOf(value), size));
    return width;
  };
  if (widest(kLargestLabel) <= bar_width) {
    style_ = Style::kLevel;
    size_ = kLargestLabel;
    height_ = kGap + kDigitHeight * size_;
    return;
  }
  size_ = std::min(kLargestLabel, bar_width / kDigitHeight);
  if (size_ < kSmallestLabel) return;
  style_ = Style::kUpwards;
  height_ = kGap + widest(size_);
}

void BarLabels::Write(Canvas& canvas, double value, double left, double top, const Ink& ink) const {
  const double middle = left + bar_width_ / 2;
  if (style_ == Style::kLevel) canvas.Text(TextOf(value), middle, top - kGap, size_, ink, Align::kMiddle);
  if (style_ == Style::kUpwards)
    canvas.Text(TextOf(value), middle + kDigitHeight * size_ / 2, top - kGap, size_, ink, Align::kLeft, false, true);
}

}  // namespace chequer
