#include "simulate/print_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "simulate/board_rectangles.h"
#include "simulate/render.h"
#include "simulate/truth.h"
#include "support/scenes.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

SceneMarker Marker() {
  return test::MarkerOf(MarkerCode({6, 6}, Variant::kSecded), 17, FacingPose({0, 0, 1}, 0.2), 0.06);
}

/// What a print reflects, integrated over the paper, cells.
Eigen::Array4d Reflected(const SceneMarker& marker) {
  Eigen::Array4d sum = Eigen::Array4d::Zero();
  for (const Rectangle& r : BoardRectangles(marker))
    sum += (r.col1 - r.col0) * (r.row1 - r.row0) * r.weight.cast<double>();
  return sum;
}

TEST(Print, IsDrawnByTheSeedAndNoKnobChangesWhatAnotherIsFor) {
  const PrintQuality office = NamedPrint("office")->quality;
  SceneMarker first = Marker(), same = Marker(), other = Marker(), dirty = Marker();
  Print(office, 3, first);
  Print(office, 3, same);
  Print(office, 4, other);
  PrintQuality with_dirt = office;
  with_dirt.dirt = 0.05;
  Print(with_dirt, 3, dirty);
  EXPECT_EQ(first.print.scale, same.print.scale);
  EXPECT_NE(first.print.scale, other.print.scale);
  EXPECT_EQ(first.print.scale, dirty.print.scale);
  EXPECT_EQ(first.print.blue_shift_m, dirty.print.blue_shift_m);
  EXPECT_TRUE(first.occluders.empty());
  EXPECT_FALSE(dirty.occluders.empty());
}

TEST(Print, DeviatesAsItSays) {
  PrintQuality quality;
  quality.scale = {1.01, 1};
  quality.scale_deviation = 0.002;
  quality.register_m = 1e-4;
  double scale_square = 0, shift_square = 0, mean = 0;
  constexpr int kPrints = 400;
  for (std::uint64_t seed = 0; seed < kPrints; ++seed) {
    SceneMarker marker = Marker();
    Print(quality, seed, marker);
    mean += marker.print.scale.x() / kPrints;
    scale_square += (marker.print.scale - quality.scale).squaredNorm() / (2 * kPrints);
    shift_square +=
        (marker.print.blue_shift_m.squaredNorm() + marker.print.yellow_shift_m.squaredNorm()) / (4 * kPrints);
  }
  EXPECT_NEAR(mean, 1.01, 0.0005);
  EXPECT_NEAR(std::sqrt(scale_square), 0.002, 0.0002);
  EXPECT_NEAR(std::sqrt(shift_square), 1e-4, 1e-5);
}

TEST(Print, GlossAddsALampsLightToPaperAndInkAlike) {
  PrintQuality quality;
  quality.gloss = 1.5;
  SceneMarker marker = Marker();
  Print(quality, 3, marker);
  EXPECT_EQ(marker.highlight.strength, 1.5);
  marker.highlight.at = {0.5, 0.5};
  marker.highlight.sigma = 0.25;
  SceneMarker matt = marker;
  matt.highlight.strength = 0;
  RenderOptions options;
  options.camera = test::PlainCamera();
  const LinearImage glossy = RenderLight({{marker}, {}}, options), plain = RenderLight({{matt}, {}}, options);
  const auto added = [&](const Eigen::Vector2d& cell) {
    const Eigen::Vector2d pixel =
        options.camera.Project(marker.camera_from_marker * marker.PointAt(cell.x(), cell.y()));
    const int x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
    return static_cast<double>(glossy.Pixel(x, y)[1] - plain.Pixel(x, y)[1]);
  };
  // The middle, and a standard deviation away along a row and along a column: over light and dark cells.
  const double white = static_cast<double>(marker.inks.white.y());
  EXPECT_NEAR(added({3, 3}), 1.5 * white, 0.02);
  EXPECT_NEAR(added({4.5, 3}), 1.5 * white * std::exp(-0.5), 0.03);
  EXPECT_NEAR(added({3, 1.5}), 1.5 * white * std::exp(-0.5), 0.03);
  EXPECT_NEAR(added({-2, 3}), 0, 1e-6) << "beside the print";
  quality.gloss = 6;
  EXPECT_THAT(quality.Check(), HasSubstr("gloss must be from 0 to 5"));
}

TEST(Print, BendsEachPrintItsOwnWayOrAsItIsSaid) {
  PrintQuality quality;
  quality.bend_radius_m = -0.5;
  SceneMarker first = Marker(), same = Marker(), other = Marker(), said = Marker();
  Print(quality, 3, first);
  Print(quality, 3, same);
  Print(quality, 4, other);
  quality.bend_angle_rad = 1.5;
  Print(quality, 3, said);
  for (const SceneMarker* marker : {&first, &other, &said}) EXPECT_EQ(marker->bend_per_m, -2);
  EXPECT_EQ(first.bend_angle_rad, same.bend_angle_rad);
  EXPECT_NE(first.bend_angle_rad, other.bend_angle_rad);
  EXPECT_EQ(said.bend_angle_rad, 1.5);
  // Hollow: its rim is nearer to the viewer than its middle.
  EXPECT_GT(said.PointAt(3, 0).z(), 0.0005);
  EXPECT_EQ(said.PointAt(3, 3).z(), 0);
  quality.bend_radius_m = 0.001;
  EXPECT_THAT(quality.Check(), HasSubstr("0.01 to 1000"));
}

TEST(Print, LeavesTheTruthWhatWasMeant) {
  SceneMarker marker = Marker();
  const CameraModel camera = test::PlainCamera();
  const TrueMarker meant = Describe(marker, camera);
  PrintQuality quality = NamedPrint("inkjet-worn")->quality;
  quality.scale = {1.02, 0.99};
  Print(quality, 5, marker);
  const TrueMarker printed = Describe(marker, camera);
  EXPECT_EQ(printed.side_m, meant.side_m);
  EXPECT_EQ(printed.camera_from_marker.translation, meant.camera_from_marker.translation);
  EXPECT_LT((printed.center_px - meant.center_px).norm(), 1e-9);
}

TEST(Print, ScalesWidthAndHeightOnTheirOwn) {
  SceneMarker marker = Marker();
  marker.print.scale = {1.02, 0.99};
  EXPECT_LT((marker.PointAt(6, 6) - Eigen::Vector3d(0.03 * 1.02, -0.03 * 0.99, 0)).norm(), 1e-12);
}

TEST(Print, OverprintsMultiplyAndGapsShowPaper) {
  SceneMarker marker = Marker();
  marker.inks = *NamedInks("ideal");
  const Eigen::Array4d in_register = Reflected(marker);
  // As little as nothing: the same print by the other way.
  marker.print.yellow_shift_m = {1e-9, 0};
  EXPECT_TRUE(Reflected(marker).isApprox(in_register, 1e-6)) << Reflected(marker) << " " << in_register;
  // Yellow moves a tenth of a cell to the right: over black or blue, which it leaves nothing of. Where it was, paper.
  marker.print.yellow_shift_m = {0.001, 0};
  const Eigen::Array4d shifted = Reflected(marker);
  EXPECT_NEAR(shifted[3], in_register[3], 1e-6) << "the paper is covered once";
  EXPECT_NEAR(shifted[0], in_register[0], 1e-6) << "red: yellow is as white, and over dark ink nothing";
  EXPECT_GT(shifted[2], in_register[2] - 0.9) << "blue ink loses where yellow covers it, paper gains";
  EXPECT_NE(shifted[2], in_register[2]);
}

TEST(Print, KindsAreKnownByName) {
  EXPECT_FALSE(NamedPrint("lase"));
  for (const char* name : {"ideal", "office", "laser", "inkjet", "inkjet-worn"}) {
    ASSERT_TRUE(NamedPrint(name)) << name;
    EXPECT_EQ(NamedPrint(name)->quality.Check(), "") << name;
    EXPECT_TRUE(NamedInks(NamedPrint(name)->ink)) << name;
    EXPECT_THAT(PrintKindNames(), HasSubstr(name));
  }
  EXPECT_EQ(NamedPrint("ideal")->quality, PrintQuality{});
}

}  // namespace
}  // namespace chequer
