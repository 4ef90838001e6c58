// Boards that moved while the image was exposed.
#include "detect/fit/motion_blur.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "detect/boards/motion_blur_view.h"
#include "detect/common/homography.h"
#include "support/pose_errors.h"
#include "support/scenes.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

constexpr double kMotionBlurredCellPx = 10, kWayPx = 12;

MarkerCode MotionBlurredCode() { return MarkerCode({6, 6}, Variant::kSecded); }

/// The image direction of the marker's columns.
double HeadingOf(const test::KnownFrame& frame) {
  const std::vector<Eigen::Vector2d> corners = test::InnerCorners(frame.scene.markers[0], frame.options.camera);
  const Eigen::Vector2d along = corners[4] - corners[0];
  return std::atan2(along.y(), along.x());
}

/// A marker that moved by kWayPx, turned against its rows by so many degrees.
test::KnownFrame MotionBlurredFrame(double degrees, std::uint64_t seed) {
  test::KnownFrame frame = test::OneMarker(MotionBlurredCode(), 1000 + seed, kMotionBlurredCellPx, seed);
  frame.options.motion_px = kWayPx;
  frame.options.motion_angle_rad = HeadingOf(frame) + degrees * std::numbers::pi / 180;
  return frame;
}

/// What is told of the frame's marker, whose place is known to a twentieth of a cell.
MotionBlurs MotionBlursOf(const test::KnownFrame& frame) {
  const Image image = frame.Draw();
  const std::array<float, 256> table = image.view().tone_curve().LinearTable();
  const std::vector<Eigen::Vector2d> corners = test::InnerCorners(frame.scene.markers[0], frame.options.camera);
  std::vector<PointPair> pairs;
  for (int i = 0; i < 25; ++i)
    pairs.push_back({CornerOnBoard({6, 6}, i / 5, i % 5),
                     corners[static_cast<std::size_t>(i)] + Eigen::Vector2d(0.05, -0.05) * kMotionBlurredCellPx});
  const LightReader reader(image.view(), table);
  return FindMotionBlurs(reader, Lens(), {6, 6}, BoardGeometry(*FitHomography(pairs)));
}

TEST(MotionBlur, TellsTheWayOfABoard) {
  for (const double degrees : {0.0, 7.0, 15.0, 25.0, 35.0, 45.0, 70.0}) {
    const test::KnownFrame frame = MotionBlurredFrame(degrees, 3);
    const double angle = frame.options.motion_angle_rad;
    const Eigen::Vector2d way(kWayPx * std::cos(angle), kWayPx * std::sin(angle));
    const MotionBlurs motion_blurs = MotionBlursOf(frame);
    // There and back are the same.
    double nearest = 1e9;
    for (std::size_t i = 0; i < motion_blurs.count; ++i)
      nearest = std::min({nearest, (motion_blurs.by_px[i] - way).norm(), (motion_blurs.by_px[i] + way).norm()});
    EXPECT_LT(nearest, 0.09 * kMotionBlurredCellPx) << degrees << " degrees";
    EXPECT_TRUE(motion_blurs.count == 1 || degrees < 10) << degrees << " degrees: " << motion_blurs.count;
  }
}

TEST(MotionBlur, TakesNoBlurForOne) {
  for (const double blur_px : {0.6, 1.5, 2.5, 3.0}) {
    test::KnownFrame frame = MotionBlurredFrame(20, 3);
    frame.options.motion_px = 0;
    frame.options.blur_sigma_px = blur_px;
    EXPECT_EQ(MotionBlursOf(frame).count, 0u) << blur_px << " px";
  }
}

/// A checkerboard turned by 45 degrees, of which the waves along x are so much weaker.
BytePlane Striped(double weaker, int side, double cell_px) {
  BytePlane plane;
  plane.Resize(side, side);
  const double middle = 0.5 * (side - 1), wave = std::numbers::sqrt2 * std::numbers::pi / cell_px;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      plane.row(y)[x] = static_cast<std::uint8_t>(
          128.5 + 50 * (std::cos(wave * (y - middle)) - weaker * std::cos(wave * (x - middle))));
  return plane;
}

TEST(MotionBlurView, StripesBecomeACheckerboard) {
  BytePlane view = Striped(0.2, 88, 8);
  const Eigen::Vector2f middle(43.5f, 43.5f);
  const Change before = ChangeAround(view, middle, 8);
  EXPECT_NEAR(before.share, 0.04, 0.02);
  EXPECT_NEAR(std::abs(before.least.x()), 1, 0.02);
  MotionBlurScratch scratch;
  EvenOutChange(8, view, scratch);
  EXPECT_GT(ChangeAround(view, middle, 8).share, 0.55f);
  EXPECT_GT(view.at(49, 44), view.at(44, 44) - 10) << "raised along the rows, not turned upside down";
  // What is even stays so.
  view = Striped(1, 88, 8);
  EXPECT_GT(ChangeAround(view, middle, 8).share, 0.9f);
  EvenOutChange(8, view, scratch);
  EXPECT_GT(ChangeAround(view, middle, 8).share, 0.5f);
}

TEST(MotionBlurredBoards, AreReadInsideTheirStripes) {
  int read = 0, sharpened = 0, frames = 0;
  double square_px = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const double degrees : {-20.0, 20.0}) {
      const test::KnownFrame frame = MotionBlurredFrame(degrees, seed);
      DetectorOptions options;
      options.families = {MarkerFamily{MotionBlurredCode(), 0.12, {}}};
      options.camera = frame.options.camera;
      std::vector<MarkerPose> markers;
      DetectTrace trace;
      Detector(options).Detect(frame.Draw().view(), markers, &trace);
      ++frames;
      for (const TracePlace& place : trace.places) sharpened += place.sharpened && place.boards == 1;
      ASSERT_LE(markers.size(), 1u);
      if (markers.empty() || !markers[0].id) continue;
      EXPECT_EQ(*markers[0].id, 1000 + seed);
      ++read;
      const std::vector<Eigen::Vector2d> truth = test::InnerCorners(frame.scene.markers[0], frame.options.camera);
      for (std::size_t i = 0; i < truth.size(); ++i)
        if (markers[0].corners[i].allFinite())
          square_px += (markers[0].corners[i].cast<double>() - truth[i]).squaredNorm() / 25;
    }
  EXPECT_GE(read, frames - 3);
  EXPECT_GE(sharpened, frames / 3) << "of some, the first look shows enough";
  EXPECT_LT(std::sqrt(square_px / std::max(read, 1)), 0.1) << "px; a twentieth of what the smear hides";
}

TEST(MotionBlurredBoards, ThatTurnHavePosesThatAreHonest) {
  // Each robot goes its own way, in turns; knocks move all of them by up to 12 px more while the shutter is open.
  const test::StreamFrames stream(
      "seed = 23\n[camera]\nsize = \"1280x720\"\nfocal_px = 1800\ndistance = 3.0\nfps = 60\nexposure_ms = 6.67\n"
      "[swarm]\nrobots = 16\nside = 0.1\nspeed = 0.8\n[[phase]]\nkind = \"calm\"\nframes = 3\n"
      "[[phase]]\nkind = \"knock\"\nmax_px = 12\nframes = 14\n");
  Detector detector(stream.Options());
  DetectorMemory memory;
  std::vector<MarkerPose> found;
  test::PoseErrors errors;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    detector.Detect(frame.image.view(), std::chrono::milliseconds(1000 + 17 * i), memory, found);
    for (const TrueMarker& truth : frame.truth.markers)
      for (const MarkerPose& marker : found)
        if (marker.id == truth.id && truth.motion_px > 7 && truth.motion_px < 12)
          errors.Add(truth.camera_from_marker, marker);
  }
  // As if all points of a board went one way, squared errors were 2.3.
  EXPECT_GE(errors.poses(), 50);
  RecordProperty("position", std::to_string(errors.position()));
  EXPECT_LT(errors.position(), 1.5) << errors.position();
  EXPECT_LT(errors.orientation(), 1.5) << errors.orientation();
}

TEST(MotionBlurredBoards, WithoutInksAreNone) {
  for (const double degrees : {10.0, 20.0, 30.0}) {
    test::KnownFrame frame = MotionBlurredFrame(degrees, 5);
    InkSet& inks = frame.scene.markers[0].inks;
    inks.blue = inks.black;
    inks.yellow = inks.white;
    DetectorOptions options;
    options.families = {MarkerFamily{MotionBlurredCode(), 0.12, {}}};
    EXPECT_TRUE(Detector(options).Detect(frame.Draw().view()).empty()) << degrees << " degrees";
  }
}

}  // namespace
}  // namespace chequer
