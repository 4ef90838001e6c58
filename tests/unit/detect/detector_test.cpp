#include "chequer/detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "simulate/stress.h"
#include "support/scenes.h"

namespace chequer {
namespace {

const MarkerCode kSecded({6, 6}, Variant::kSecded);

Detector DetectorFor(const test::KnownFrame& frame, const MarkerCode& code = kSecded) {
  DetectorOptions options;
  options.families = {
      {.code = code, .side_m = frame.scene.markers.empty() ? 0.12 : frame.scene.markers[0].side_m, .roster = {}}};
  options.camera = frame.options.camera;
  return Detector(options);
}

/// Expects exactly that marker, at its pose to within `sigmas` of its own covariance.
void ExpectRead(const test::KnownFrame& frame, std::uint64_t id, const MarkerCode& code = kSecded, double sigmas = 6) {
  SCOPED_TRACE(frame.name + ", seed " + std::to_string(frame.seed));
  Detector detector = DetectorFor(frame, code);
  const Image image = frame.Draw();
  const std::vector<MarkerPose> found = detector.Detect(image.view());
  ASSERT_EQ(found.size(), 1u) << "corners " << detector.stats().corners << ", grids " << detector.stats().grids
                              << ", boards " << detector.stats().boards;
  ASSERT_TRUE(found[0].id.has_value());
  EXPECT_EQ(*found[0].id, id);
  ASSERT_TRUE(found[0].has_pose);
  const RigidTransform& truth = frame.scene.markers[0].camera_from_marker;
  const Eigen::Vector3d error = truth.translation - found[0].camera_from_marker.translation;
  const Eigen::Vector3d turn = VectorFromRotation(truth.rotation * found[0].camera_from_marker.rotation.conjugate());
  EXPECT_LT(error.dot(found[0].covariance.topLeftCorner<3, 3>().inverse() * error), sigmas * sigmas)
      << "position off by " << error.transpose() << " m";
  EXPECT_LT(turn.dot(found[0].covariance.bottomRightCorner<3, 3>().inverse() * turn), sigmas * sigmas)
      << "rotation off by " << turn.transpose() << " rad";
  EXPECT_LT(error.norm(), 0.01 * truth.translation.norm());
}

TEST(Detector, ReadsEveryPixelFormat) {
  for (const PixelFormat format :
       {PixelFormat::kBgr8, PixelFormat::kRgb8, PixelFormat::kBayerRg8, PixelFormat::kBayerGb8, PixelFormat::kBayerGr8,
        PixelFormat::kBayerBg8, PixelFormat::kYuyv, PixelFormat::kUyvy, PixelFormat::kNv12, PixelFormat::kYuv420p,
        PixelFormat::kYuv422p, PixelFormat::kYuv444p}) {
    test::KnownFrame frame = test::OneMarker(kSecded, 1234, 12, 3);
    frame.options.format = format;
    frame.name = PixelFormatName(format);
    // Demosaiced luma has correlated noise, which the covariance does not know of.
    ExpectRead(frame, 1234, kSecded, IsYuv(format) ? 20 : 6);
  }
}

TEST(Detector, ReadsCellsFromFivePixelsUp) {
  for (const double cell_px : {5.0, 6.0, 8.0, 12.0, 20.0, 40.0})
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      test::KnownFrame frame = test::OneMarker(kSecded, 700 + seed, cell_px, seed);
      frame.name = std::to_string(cell_px) + " px";
      ExpectRead(frame, 700 + seed);
    }
}

TEST(Detector, ReadsEveryVariantAndSize) {
  for (const MarkerCode& code :
       {MarkerCode({6, 6}, Variant::kUnconstrained), MarkerCode({6, 6}, Variant::kSaturationConstrained),
        MarkerCode({6, 6}, Variant::kColorConstrained), MarkerCode({6, 6}, Variant::kReedMuller),
        MarkerCode({6, 6}, Variant::kNordstromRobinson), MarkerCode({8, 8}, Variant::kGolay),
        MarkerCode({8, 8}, Variant::kSecded), MarkerCode({5, 5}, Variant::kUnconstrained),
        MarkerCode({4, 6}, Variant::kUnconstrained), MarkerCode({7, 6}, Variant::kSecded)}) {
    test::KnownFrame frame = test::OneMarker(code, code.max_id() / 3, 11, 9);
    frame.name = std::string(VariantName(code.variant())) + " " + ToString(code.size());
    ExpectRead(frame, code.max_id() / 3, code);
  }
}

TEST(Detector, CornersAreWhereTheyAre) {
  test::KnownFrame frame = test::OneMarker(kSecded, 99, 12, 4);
  Detector detector = DetectorFor(frame);
  const Image image = frame.Draw();
  const std::vector<MarkerPose> found = detector.Detect(image.view());
  ASSERT_EQ(found.size(), 1u);
  const std::vector<Eigen::Vector2d> truth = test::InnerCorners(frame.scene.markers[0], frame.options.camera);
  EXPECT_EQ(found[0].corners_used, 25);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_LT((found[0].corners[i].cast<double>() - truth[i]).norm(), 0.05) << "corner " << i;
}

TEST(Detector, WithoutACalibrationThereIsNoPoseButTheRest) {
  const test::KnownFrame frame = test::OneMarker(kSecded, 321, 12, 4);
  Detector detector(DetectorOptions{});
  const Image image = frame.Draw();
  const std::vector<MarkerPose> found = detector.Detect(image.view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].id, 321u);
  EXPECT_FALSE(found[0].has_pose);
  EXPECT_LT((found[0].center_px - CenterPx(frame.scene.markers[0], frame.options.camera)).norm(), 0.05);
}

/// Of markers in raw frames, one each, squared errors over what their covariances expect: 1 if those are honest.
struct Honesty {
  double position = 0, rotation = 0;
  int count = 0;
};

Honesty HonestyOver(int frames, const std::function<void(Image&)>& change) {
  Honesty honesty;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(frames); ++seed) {
    test::KnownFrame frame = test::OneMarker(kSecded, seed, 10, seed, 0.3);
    frame.options.format = PixelFormat::kBayerRg8;
    Detector detector = DetectorFor(frame);
    Image image = frame.Draw();
    change(image);
    for (const MarkerPose& marker : detector.Detect(image.view())) {
      const RigidTransform& truth = frame.scene.markers[0].camera_from_marker;
      const Eigen::Vector3d error = truth.translation - marker.camera_from_marker.translation;
      const Eigen::Vector3d turn = VectorFromRotation(truth.rotation * marker.camera_from_marker.rotation.conjugate());
      honesty.position += error.dot(marker.covariance.topLeftCorner<3, 3>().inverse() * error);
      honesty.rotation += turn.dot(marker.covariance.bottomRightCorner<3, 3>().inverse() * turn);
      ++honesty.count;
    }
  }
  honesty.position /= 3 * honesty.count;
  honesty.rotation /= 3 * honesty.count;
  return honesty;
}

TEST(Detector, CovarianceIsHonest) {
  const Honesty honesty = HonestyOver(60, [](Image&) {});
  ASSERT_EQ(honesty.count, 60);
  EXPECT_GT(honesty.position, 0.6);
  EXPECT_LT(honesty.position, 1.5);
  EXPECT_GT(honesty.rotation, 0.6);
  EXPECT_LT(honesty.rotation, 1.5);
}

TEST(Detector, CovarianceIsHonestAboutBoardsThatAreNotFlat) {
  // Moves every row of pixels along itself by up to 0.1 px, in waves of the length of a cell and a half.
  const Honesty honesty = HonestyOver(60, [](Image& image) {
    std::vector<std::uint8_t> row(static_cast<std::size_t>(image.width()));
    for (int y = 0; y < image.height(); ++y) {
      const double shift = 0.1 * std::sin(2 * std::numbers::pi * y / 15);
      std::uint8_t* pixels = image.bytes().data() + static_cast<std::size_t>(y) * row.size();
      std::copy_n(pixels, row.size(), row.begin());
      // Samples of a mosaic's colour are two pixels apart.
      for (std::size_t x = 2; x + 2 < row.size(); ++x)
        pixels[x] = static_cast<std::uint8_t>(std::clamp(row[x] + shift * (row[x + 2] - row[x - 2]) / 4, 0.0, 255.0));
    }
  });
  ASSERT_EQ(honesty.count, 60);
  EXPECT_LT(honesty.position, 1.5);
  EXPECT_LT(honesty.rotation, 1.5);
}

TEST(Detector, RefusesMirrorImages) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::KnownFrame frame = test::OneMarker(kSecded, 40 + seed, 14, seed);
    frame.scene.markers[0].mirrored = true;
    Detector detector = DetectorFor(frame);
    const Image image = frame.Draw();
    EXPECT_TRUE(detector.Detect(image.view()).empty()) << "seed " << seed;
  }
}

TEST(Detector, FindsNothingInClutter) {
  for (const test::KnownFrame& frame : test::ClutterFrames(28, 5)) {
    Detector detector = DetectorFor(frame);
    const Image image = frame.Draw();
    EXPECT_TRUE(detector.Detect(image.view()).empty()) << frame.name;
  }
}

TEST(Detector, NeverThrowsOnAnyImage) {
  std::mt19937 random(17);
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i)
    for (const auto& [width, height] : {std::pair{2, 2}, {16, 16}, {34, 18}, {200, 8}, {258, 130}}) {
      Image image(static_cast<PixelFormat>(i), width, height);
      for (std::uint8_t& byte : image.bytes()) byte = static_cast<std::uint8_t>(random());
      Detector detector(DetectorOptions{});
      EXPECT_NO_THROW({
        EXPECT_TRUE(detector.Detect(image.view()).empty())
            << PixelFormatName(image.format()) << " " << width << "x" << height;
      });
    }
  Detector detector(DetectorOptions{});
  EXPECT_TRUE(detector.Detect(ImageView()).empty());
}

TEST(Detector, APartOfALargerBoardIsNoMarker) {
  const MarkerCode large({10, 10}, Variant::kSecded), small({6, 7}, Variant::kSecded);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const test::KnownFrame frame = test::OneMarker(large, 0x1234'5678'9abc + 7919 * seed, 12, seed);
    const std::vector<MarkerPose> found = DetectorFor(frame, small).Detect(frame.Draw().view());
    for (const MarkerPose& marker : found)
      EXPECT_FALSE(marker.id.has_value()) << "id " << *marker.id << " in a 10x10 board, seed " << seed;
  }
}

TEST(Detector, ACoveredSideLeavesThePoseExact) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const test::KnownFrame frame = test::OneMarker(kSecded, 900 + seed, 16, seed);
    Image image = frame.Draw();
    // Grey over everything to the left of the corners' second column.
    const std::vector<Eigen::Vector2d> corners = test::InnerCorners(frame.scene.markers[0], frame.options.camera);
    const Eigen::Vector2d top = corners[0], down = (corners[20] - corners[0]).normalized(), right(down.y(), -down.x());
    const ImageView view = image.view();
    const int bytes = frame.options.format == PixelFormat::kBgr8 ? 3 : 1;
    for (int y = 0; y < view.height(); ++y)
      for (int x = 0; x < view.width(); ++x) {
        const double across = (Eigen::Vector2d(x, y) - top).dot(right);
        const double along = (Eigen::Vector2d(x, y) - top).dot(down);
        if (across > 3 || across < -40 || along < -60 || along > 160) continue;
        std::fill_n(const_cast<std::uint8_t*>(view.row(y)) + bytes * x, bytes, std::uint8_t{110});
      }
    const std::vector<MarkerPose> found = DetectorFor(frame).Detect(view);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].Has(Warning::kPartlyHidden));
    EXPECT_LE(found[0].corners_used, 20);
    EXPECT_GE(found[0].corners_used, 15);
    EXPECT_EQ(found[0].id.value_or(900 + seed), 900 + seed);
    const RigidTransform& truth = frame.scene.markers[0].camera_from_marker;
    const Eigen::Vector3d error = truth.translation - found[0].camera_from_marker.translation;
    EXPECT_LT(error.norm(), 0.005 * truth.translation.norm());
    const Eigen::Vector3d turn = VectorFromRotation(truth.rotation * found[0].camera_from_marker.rotation.conjugate());
    EXPECT_LT(turn.norm(), 0.02);
  }
}

TEST(Detector, WhatLiesOverABoardMakesNoWrongId) {
  // Of these, some were read wrongly: patches of the cover that look like cells, and boards that were taken to lie two
  // lines off, turned by half a turn.
  for (const std::uint64_t seed : std::array<std::uint64_t, 4>{1006, 1018, 1022, 1039})
    for (const StressCase& stress : StressCases(kSecded, seed)) {
      if (!stress.tag.starts_with("occluded")) continue;
      SCOPED_TRACE(stress.tag + ", seed " + std::to_string(seed));
      const SceneMarker& marker = stress.scene.markers[0];
      DetectorOptions options;
      options.families = {{.code = kSecded, .side_m = marker.side_m, .roster = {}}};
      options.camera = stress.options.camera;
      const Image image = Render(stress.scene, stress.options, seed - 1000);
      Detector detector(options);
      for (const MarkerPose& found : detector.Detect(image.view()))
        EXPECT_EQ(found.id.value_or(marker.board.id), marker.board.id);
    }
}

TEST(Detector, ARosterKeepsOthersOut) {
  const test::KnownFrame frame = test::OneMarker(kSecded, 500, 12, 4);
  const Image image = frame.Draw();
  for (const auto& [roster, expected] :
       {std::pair{std::vector<std::uint64_t>{3, 500}, true}, {std::vector<std::uint64_t>{3, 4}, false}}) {
    DetectorOptions options;
    options.families = {{.code = kSecded, .side_m = 0.12, .roster = roster}};
    Detector detector(options);
    const std::vector<MarkerPose> found = detector.Detect(image.view());
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].id.has_value(), expected);
    EXPECT_EQ(found[0].Has(Warning::kIdUndecided), !expected);
  }
}

TEST(Detector, FamiliesOfOneSizeKeepTheirOwnSides) {
  const MarkerCode unconstrained({6, 6}, Variant::kUnconstrained);
  const test::KnownFrame frame = test::OneMarker(kSecded, 77, 12, 4);
  DetectorOptions options;
  options.families = {{.code = unconstrained, .side_m = 0.05, .roster = {1, 2}},
                      {.code = kSecded, .side_m = frame.scene.markers[0].side_m, .roster = {}}};
  options.camera = frame.options.camera;
  const std::vector<MarkerPose> found = Detector(options).Detect(frame.Draw().view());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].family, 1);
  EXPECT_EQ(found[0].id, std::optional<std::uint64_t>(77));
  const Eigen::Vector3d truth = frame.scene.markers[0].camera_from_marker.translation;
  EXPECT_LT((found[0].camera_from_marker.translation - truth).norm(), 0.01 * truth.norm());
}

TEST(Detector, ThreadsChangeNothingButTheTime) {
  test::KnownFrame frame = test::OneMarker(kSecded, 1, 9, 5);
  for (int i = 1; i < 12; ++i) {
    RigidTransform pose = frame.scene.markers[0].camera_from_marker;
    pose.translation.x() += 0.22 * (i % 4 - 1.5);
    pose.translation.y() += 0.22 * (i / 4 - 1);
    frame.scene.markers.push_back(test::MarkerOf(kSecded, 1 + static_cast<std::uint64_t>(i), pose));
  }
  frame.scene.markers.erase(frame.scene.markers.begin());
  const Image image = frame.Draw();
  DetectorOptions options;
  options.families = {{.code = kSecded, .side_m = 0.12, .roster = {}}};
  options.camera = frame.options.camera;
  const std::vector<MarkerPose> alone = Detector(options).Detect(image.view());
  ASSERT_GE(alone.size(), 6u);
  options.threads = 3;
  Detector detector(options);
  for (int run = 0; run < 3; ++run) {
    const std::vector<MarkerPose> together = detector.Detect(image.view());
    ASSERT_EQ(together.size(), alone.size());
    for (std::size_t i = 0; i < alone.size(); ++i) {
      EXPECT_EQ(together[i].id, alone[i].id);
      EXPECT_EQ(together[i].camera_from_marker.translation, alone[i].camera_from_marker.translation);
    }
  }
}

TEST(Detector, SaysWhatIsWrongWithOptions) {
  DetectorOptions options;
  options.camera = test::PlainCamera();
  options.families[0].side_m = -1;
  EXPECT_THAT(options.Check(), testing::HasSubstr("side"));
  EXPECT_THROW(Detector{options}, std::runtime_error);
  options.families.clear();
  EXPECT_THAT(options.Check(), testing::HasSubstr("family"));
}

}  // namespace
}  // namespace chequer
