#include "simulate/background.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "simulate/clutter.h"
#include "simulate/random.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

constexpr BackgroundKind kProcedural[] = {BackgroundKind::kNoise, BackgroundKind::kChess, BackgroundKind::kText,
                                          BackgroundKind::kTiles, BackgroundKind::kWood,  BackgroundKind::kBlobs,
                                          BackgroundKind::kMixed};

Background Of(BackgroundKind kind, std::uint64_t seed) {
  Background background;
  background.kind = kind;
  background.seed = seed;
  return background;
}

TEST(DrawBackground, ProceduralKindsHangOnTheSeedAlone) {
  for (const BackgroundKind kind : kProcedural) {
    const LinearImage once = DrawBackground(Of(kind, 11), 320, 240);
    EXPECT_EQ(once.rgb, DrawBackground(Of(kind, 11), 320, 240).rgb) << BackgroundName(kind);
    EXPECT_NE(once.rgb, DrawBackground(Of(kind, 12), 320, 240).rgb) << BackgroundName(kind);
  }
}

TEST(DrawBackground, ProceduralKindsAreReflectancesWithStructure) {
  for (const BackgroundKind kind : kProcedural)
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const LinearImage image = DrawBackground(Of(kind, seed), 320, 240);
      const auto [low, high] = std::minmax_element(image.rgb.begin(), image.rgb.end());
      EXPECT_GE(*low, 0) << BackgroundName(kind);
      EXPECT_LE(*high, 0.9f) << BackgroundName(kind);
      EXPECT_GT(*high - *low, 0.03f) << BackgroundName(kind) << " seed " << seed;
    }
}

TEST(DrawBackground, AnySizeIsDrawn) {
  for (const BackgroundKind kind : kProcedural)
    for (const auto& [width, height] : {std::pair{1, 1}, {7, 300}, {500, 3}})
      EXPECT_EQ(DrawBackground(Of(kind, 1), width, height).rgb.size(), static_cast<std::size_t>(3 * width * height));
}

TEST(DrawBackground, PlainIsItsColour) {
  Background background;
  background.colour = {0.1f, 0.2f, 0.3f};
  const LinearImage image = DrawBackground(background, 4, 3);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(image.Pixel(3, 2)[c], background.colour[c]);
}

TEST(DrawBackground, ImageFillsTheFrameInLinearLight) {
  const test::TemporaryDirectory folder;
  Background background{.kind = BackgroundKind::kImage, .file = (folder / "floor.png").string()};
  cv::imwrite(background.file, cv::Mat(30, 60, CV_8UC3, cv::Scalar(0, 188, 255)));
  const LinearImage image = DrawBackground(background, 50, 40);
  EXPECT_EQ(image.width, 50);
  EXPECT_EQ(image.height, 40);
  EXPECT_NEAR(image.Pixel(49, 39)[0], 0.9, 1e-4);
  EXPECT_NEAR(image.Pixel(0, 0)[1], 0.9 * 0.503, 2e-3);  // 188 is half of the light
  EXPECT_NEAR(image.Pixel(20, 20)[2], 0, 1e-6);
}

TEST(DrawBackground, GreyImageIsGrey) {
  const test::TemporaryDirectory folder;
  Background background{.kind = BackgroundKind::kImage, .file = (folder / "grey.png").string()};
  cv::imwrite(background.file, cv::Mat(30, 60, CV_8UC1, cv::Scalar(188)));
  const LinearImage image = DrawBackground(background, 50, 40);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.Pixel(20, 20)[c], 0.9 * 0.503, 2e-3);
}

std::string ErrorOf(const Background& background) {
  return test::ErrorOf([&] { DrawBackground(background, 10, 10); });
}

TEST(DrawBackground, UnreadableImageIsNamed) {
  const test::TemporaryDirectory folder;
  Background background{.kind = BackgroundKind::kImage, .file = (folder / "floor.png").string()};
  EXPECT_THAT(ErrorOf(background), ::testing::HasSubstr(background.file));
  cv::imwrite(background.file, cv::Mat(30, 60, CV_8UC3, cv::Scalar(0, 188, 255)));
  std::filesystem::resize_file(background.file, std::filesystem::file_size(background.file) - 20);
  EXPECT_THAT(ErrorOf(background),
              ::testing::AllOf(::testing::HasSubstr(background.file), ::testing::HasSubstr("truncated")));
}

TEST(BackgroundName, RoundTrips) {
  for (const BackgroundKind kind : kProcedural) {
    EXPECT_EQ(ParseBackground(BackgroundName(kind)), kind);
    EXPECT_THAT(BackgroundNames(), ::testing::HasSubstr(std::string(BackgroundName(kind))));
  }
  EXPECT_FALSE(ParseBackground("lava").has_value());
}

// The arguments of a call are worked out in an order of the compiler's own: with two that draw, clang gave other frames
// than g++. Colours rounded, as processors may differ in the last digit.
TEST(Clutter, IsTheSameFromEveryCompiler) {
  const std::vector<std::pair<BackgroundKind, cv::Scalar>> means{
      {BackgroundKind::kNoise, {182, 98, 125}}, {BackgroundKind::kChess, {64, 68, 79}},
      {BackgroundKind::kText, {95, 95, 94}},    {BackgroundKind::kTiles, {167, 129, 204}},
      {BackgroundKind::kWood, {52, 105, 127}},  {BackgroundKind::kBlobs, {122, 123, 122}},
      {BackgroundKind::kMixed, {194, 188, 107}}};
  for (const auto& [kind, mean] : means) {
    cv::Mat image(96, 96, CV_8UC3, cv::Scalar::all(0));
    Random random(7);
    DrawClutter(kind, image, random);
    EXPECT_LT(cv::norm(cv::mean(image) - mean), 1.5) << "kind " << static_cast<int>(kind) << ": " << cv::mean(image);
  }
}

}  // namespace
}  // namespace chequer
