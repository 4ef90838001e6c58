#include "lens/view_collector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "lens/edge_width.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

/// A board of 5 x 5 points about a place in an image of 1200 x 800.
LensView At(double x, double y, double edge_px = 2, double squeezed = 1) {
  LensView view;
  view.edge_px = edge_px;
  for (int i = 0; i < 25; ++i)
    view.points.push_back(
        {0, {0.01 * (i % 5), -0.01 * (i / 5)}, {x + 20 * squeezed * (i % 5 - 2), y + 20.0 * (i / 5 - 2)}});
  return view;
}

ViewCollector Collector(bool keep_all = false) {
  return ViewCollector({.width = 1200, .height = 800, .max_views = 20, .keep_all = keep_all});
}

ViewVerdict Offer(ViewCollector& collector, LensView view) {
  return collector.Offer(std::move(view), [] { return Image(); });
}

TEST(ViewCollector, TakesWhatIsNewAndSharp) {
  ViewCollector collector = Collector();
  EXPECT_EQ(Offer(collector, At(200, 200)), ViewVerdict::kTaken);
  EXPECT_EQ(Offer(collector, At(210, 205)), ViewVerdict::kAlike);
  EXPECT_EQ(Offer(collector, At(400, 200)), ViewVerdict::kTaken);
  EXPECT_EQ(Offer(collector, At(600, 200, 5)), ViewVerdict::kBlurred);
  EXPECT_EQ(Offer(collector, LensView()), ViewVerdict::kNothingSeen);
  EXPECT_EQ(collector.views().size(), 2u);
  EXPECT_EQ(collector.reloads().size(), 2u);
  EXPECT_EQ(collector.offered(), 5u);
  ViewCollector all = Collector(true);
  Offer(all, At(200, 200));
  EXPECT_EQ(Offer(all, At(200, 200, 9)), ViewVerdict::kTaken);
}

TEST(ViewCollector, TakesAnotherTiltInTheSamePlace) {
  ViewCollector collector = Collector();
  EXPECT_EQ(Offer(collector, At(200, 200)), ViewVerdict::kTaken);
  EXPECT_EQ(Offer(collector, At(205, 200, 2, 0.97)), ViewVerdict::kAlike);
  EXPECT_EQ(collector.alike(), 1u);
  EXPECT_EQ(Offer(collector, At(200, 200, 2, 0.9)), ViewVerdict::kTaken);
  EXPECT_EQ(Offer(collector, At(200, 200, 2, 0.8)), ViewVerdict::kTaken);
}

TEST(ViewCollector, TakesNoMoreThanItIsToldTo) {
  ViewCollector collector = Collector();
  for (int i = 0; i < 40; ++i) Offer(collector, At(50 + 25.0 * i, 50 + 17.0 * i));
  EXPECT_LE(collector.views().size(), 20u);
}

TEST(ViewCollector, SaysWhereToHoldTheTargetAndHow) {
  ViewCollector collector = Collector();
  EXPECT_THAT(collector.Hint(ViewVerdict::kNothingSeen), HasSubstr("not seen"));
  EXPECT_THAT(collector.Hint(ViewVerdict::kBlurred), HasSubstr("still"));
  ViewCollector wide({.width = 1200, .height = 800, .max_views = 2000});
  for (int pass = 0; pass < 2; ++pass)
    for (int x = 50; x < 1200; x += 60)
      for (int y = 50; y < 800; y += 60)
        if (x > 500 || y > 300) Offer(wide, At(x + 29.0 * pass, y + 29.0 * pass));
  EXPECT_EQ(wide.Hint(ViewVerdict::kTaken), "hold it into the top left");
  for (int pass = 0; pass < 2; ++pass)
    for (int x = 50; x <= 500; x += 60)
      for (int y = 50; y <= 300; y += 60) Offer(wide, At(x + 29.0 * pass, y + 29.0 * pass));
  EXPECT_GT(wide.coverage().Share(), 0.9);
  EXPECT_THAT(wide.Hint(ViewVerdict::kTaken), HasSubstr("tilt"));
  ViewCollector tilted({.width = 1200, .height = 800, .max_views = 2000, .keep_all = true});
  for (int x = 50; x < 1200; x += 60)
    for (int y = 50; y < 800; y += 60)
      for (int pass = 0; pass < 2; ++pass) Offer(tilted, At(x, y));
  EXPECT_EQ(tilted.tilted(), 0);
  for (int i = 0; i < 8; ++i) Offer(tilted, At(100 + 120.0 * i, 400, 2, 0.8));
  EXPECT_EQ(tilted.tilted(), 8);
  EXPECT_EQ(tilted.Hint(ViewVerdict::kTaken), "enough");
}

TEST(Coverage, DrawsCountsAsText) {
  Coverage coverage(1200, 800);
  coverage.Add(At(50, 50));
  coverage.Add(At(50, 50));
  for (int i = 0; i < 12; ++i) coverage.Add(At(1150, 750));
  const std::string picture = coverage.Picture();
  EXPECT_EQ(picture.substr(0, 4), "2 . ");
  EXPECT_EQ(picture.substr(picture.size() - 4), ". +\n");
}

TEST(EdgeWidth, GrowsWithBlur) {
  double last = 0;
  for (const double sigma : {0.7, 1.5, 3.0}) {
    DetectionPlane plane;
    plane.plane.Resize(200, 200);
    // A chessboard of cells of 40 px, its edges blurred.
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x) {
        const auto wave = [&](int at) {
          return std::erf((std::abs((at + 20) % 80 - 40) - 20) / (std::sqrt(2.0) * sigma));
        };
        plane.plane.row(y)[x] = static_cast<std::uint8_t>(128 + 100 * wave(x) * wave(y));
      }
    std::vector<std::optional<Eigen::Vector2d>> corners;
    for (int i = 0; i < 16; ++i) corners.push_back(Eigen::Vector2d(40 + 40 * (i % 4), 40 + 40 * (i / 4)));
    const double width = EdgeWidthPx(plane, corners, 4, 4);
    // Contrast over slope of an error function: sigma times the root of 2 pi, wider by up to a pixel of sampling.
    EXPECT_NEAR(width, std::sqrt(2 * M_PI) * sigma, 0.7);
    EXPECT_GT(width, last);
    last = width;
    corners.assign(16, std::nullopt);
    EXPECT_EQ(EdgeWidthPx(plane, corners, 4, 4), 0);
  }
}

}  // namespace
}  // namespace chequer
