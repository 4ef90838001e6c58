#include "tools/bar_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/image_file.h"
#include "capture/png.h"

namespace chequer {
namespace {

using Style = BarLabels::Style;

constexpr int kWidth = 420, kHeight = 200;
constexpr double kTop = 120;  ///< where the bars begin

/// RMSE and MAE, as of tracks near and far.
std::vector<double> ValuesOf(int runs) {
  std::vector<double> values;
  for (int i = 0; i < 2 * runs; ++i) values.push_back(0.0123 * (i + 1));
  return values;
}

double BarWidth(int runs) { return std::min(0.36 * 410 / runs, 48.0); }

/// The pixels that are not white.
struct Extent {
  int left = kWidth, right = -1, top = kHeight, bottom = -1;
};

Extent InkOf(const Image& picture) {
  Extent extent;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const std::uint8_t* pixel = &picture.bytes()[static_cast<std::size_t>(3 * (y * picture.width() + x))];
      if (pixel[0] > 250 && pixel[1] > 250 && pixel[2] > 250) continue;
      extent.left = std::min(extent.left, x);
      extent.right = std::max(extent.right, x);
      extent.top = std::min(extent.top, y);
      extent.bottom = std::max(extent.bottom, y);
    }
  return extent;
}

TEST(BarLabels, StayOverTheirOwnBars) {
  for (const int runs : {1, 2, 3, 4, 6, 8, 12, 16}) {
    const std::vector<double> values = ValuesOf(runs);
    const double bar = BarWidth(runs), left = 100;
    for (const double value : values) {
      Canvas canvas = Canvas::Png(kWidth, kHeight);
      const BarLabels labels(canvas, values, bar);
      ASSERT_NE(labels.style(), Style::kNone) << runs << " runs";
      labels.Write(canvas, value, left, kTop, {});
      const Extent ink = InkOf(ImageFromPng(canvas.Finish()));
      ASSERT_GE(ink.right, 0) << runs << " runs: " << value << " is not written";
      // Bars are 2 apart, so that what keeps to a bar and a pixel beside it meets nothing of its neighbours'.
      EXPECT_GE(ink.left, left - 1) << runs << " runs: " << value;
      EXPECT_LE(ink.right + 1, left + bar + 1) << runs << " runs: " << value;
      EXPECT_LT(ink.bottom, kTop) << runs << " runs: " << value;
      EXPECT_GE(ink.top, kTop - labels.height() - 1) << runs << " runs: " << value;
    }
  }
}

TEST(BarLabels, TurnUpwardsAsBarsBecomeNarrow) {
  const Canvas canvas = Canvas::Png(kWidth, kHeight);
  const auto style = [&](int runs) { return BarLabels(canvas, ValuesOf(runs), BarWidth(runs)).style(); };
  EXPECT_EQ(style(2), Style::kLevel);
  EXPECT_EQ(style(8), Style::kUpwards);
  EXPECT_EQ(style(60), Style::kNone);
}

TEST(BarLabels, WhereNoneFitNothingIsWritten) {
  Canvas canvas = Canvas::Png(kWidth, kHeight);
  const BarLabels labels(canvas, ValuesOf(60), BarWidth(60));
  EXPECT_EQ(labels.height(), 0);
  labels.Write(canvas, 0.5, 100, kTop, {});
  EXPECT_EQ(InkOf(ImageFromPng(canvas.Finish())).right, -1);
}

}  // namespace
}  // namespace chequer
