#include "detect/pose/rolling_shutter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "detect/common/homography.h"
#include "support/board_places.h"
#include "support/dense.h"
#include "support/pose_errors.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

const CameraModel kShutterCamera{.width = 640,
                                 .height = 480,
                                 .fx = 600,
                                 .fy = 600,
                                 .cx = 319.5,
                                 .cy = 239.5,
                                 .kind = CameraModel::Kind::kBrownConrady,
                                 .distortion = {-0.1, 0.02, 0, 0, 0},
                                 .rows_read_ms = 30};
constexpr MarkerSize kDriverSize{6, 6};
constexpr double kCellM = 0.1 / 6;

/// A board that drives on a curve, seen by kShutterCamera.
struct Driver {
  Eigen::Vector2d speed_m_s{0.3, 0.2}, acceleration_m_s2{0, 0};
  double spin_rad_s = 0.5;

  RigidTransform At(double time_s) const {
    const Eigen::Vector2d place = time_s * speed_m_s + 0.5 * time_s * time_s * acceleration_m_s2;
    return {RotationFromVector({0, 0, 0.6 + spin_rad_s * time_s}) * RotationFromVector({0.3, 0.2, 0}),
            {0.1 + place.x(), -0.05 + place.y(), 1}};
  }

  /// Where the shutter shows it whose first row is exposed at `first_row_s`: by its corners.
  BoardGeometry Seen(double first_row_s, const Lens& lens) const {
    std::vector<PointPair> corners;
    for (int row = -2; row <= 2; ++row)
      for (int col = -2; col <= 2; ++col) {
        const Eigen::Vector2d board(col, row);
        const double then_s = ExposedS(board, first_row_s, lens);
        corners.push_back({board, *lens.ToPlane(PixelAt(board, then_s))});
      }
    return BoardGeometry(*FitHomography(corners));
  }
  /// Where it is when the row of its middle is exposed.
  BoardGeometry True(double first_row_s, const Lens& lens) const {
    return test::PlaceOf(At(ExposedS({0, 0}, first_row_s, lens)), {kCellM, kCellM}, lens.focal());
  }

 private:
  Eigen::Vector2d PixelAt(const Eigen::Vector2d& board, double time_s) const {
    return kShutterCamera.Project(At(time_s) * Eigen::Vector3d(board.x() * kCellM, board.y() * kCellM, 0));
  }
  /// When the row of a board point is exposed.
  double ExposedS(const Eigen::Vector2d& board, double first_row_s, const Lens& lens) const {
    double then_s = first_row_s;
    for (int round = 0; round < 20; ++round) then_s = first_row_s + PixelAt(board, then_s).y() * lens.row_s();
    return then_s;
  }
};

/// Largest distance between corners of two places, px.
double FarthestOff(const BoardGeometry& a, const BoardGeometry& b) {
  double most = 0;
  for (const double x : {-2, 0, 2})
    for (const double y : {-2, 0, 2}) most = std::max(most, (a.ToPlane({x, y}) - b.ToPlane({x, y})).norm());
  return most;
}

constexpr double kDriverFrameS = 1.0 / 30;

/// What the detector makes of three frames of a driver.
BoardMeasurement Undone(const Driver& driver, double before_s, double off) {
  const Lens lens(kShutterCamera);
  BoardMeasurement measured;
  measured.plane_from_board = driver.Seen(0, lens).plane_from_board();
  measured.information.setIdentity();
  measured.information *= 1e6;
  UndoRollingShutter({.last = driver.Seen(-kDriverFrameS, lens).plane_from_board(),
                      .last_s = kDriverFrameS,
                      .before = driver.Seen(-kDriverFrameS - before_s, lens).plane_from_board(),
                      .before_s = before_s,
                      .off = off},
                     kDriverSize, lens, measured);
  return measured;
}

TEST(RollingShutterUndone, LeavesABoardThatDrivesWhereItIsWhenItsMiddleIsExposed) {
  const Lens lens(kShutterCamera);
  for (const Driver& driver : {Driver{}, Driver{.speed_m_s = {-0.5, 0.1}, .acceleration_m_s2 = {3, 2}},
                               Driver{.speed_m_s = {0, 0}, .spin_rad_s = 3}}) {
    const BoardGeometry truth = driver.True(0, lens);
    EXPECT_GT(FarthestOff(driver.Seen(0, lens), truth), 0.05);
    EXPECT_LT(FarthestOff(BoardGeometry(Undone(driver, kDriverFrameS, 0).plane_from_board), truth), 0.02);
    EXPECT_LT(FarthestOff(BoardGeometry(Undone(driver, 2 * kDriverFrameS, 0).plane_from_board), truth), 0.02)
        << "a frame was lost";
  }
}

TEST(RollingShutterUndone, ChangesNothingOfABoardThatStands) {
  const Lens lens(kShutterCamera);
  const Driver driver{.speed_m_s = {0, 0}, .spin_rad_s = 0};
  EXPECT_LT(FarthestOff(BoardGeometry(Undone(driver, kDriverFrameS, 0).plane_from_board), driver.True(0, lens)), 1e-9);
}

TEST(RollingShutterUndone, TellsHowSurelyTheSpeedIsKnown) {
  const auto variance = [](const BoardMeasurement& measured) { return test::Inverse(measured.information)(1, 1); };
  const Driver driver;
  const double sure = variance(Undone(driver, kDriverFrameS, 0));
  EXPECT_NEAR(sure, 1e-6, 1e-12);
  EXPECT_GT(variance(Undone(driver, kDriverFrameS, 1)), 1.5 * sure) << "it goes on as it never did";
  EXPECT_GT(variance(Undone(driver, 0, 0)), 10 * sure) << "its speed may have changed since it was first seen";
  const Lens lens(kShutterCamera);
  BoardMeasurement seen_once;
  seen_once.plane_from_board = driver.Seen(0, lens).plane_from_board();
  seen_once.information = 1e6 * BoardGeometry::Information::Identity();
  const Eigen::Matrix3d before = seen_once.plane_from_board;
  UndoRollingShutter({}, kDriverSize, lens, seen_once);
  EXPECT_TRUE(seen_once.plane_from_board.isApprox(before)) << "where it goes is not known";
  EXPECT_GT(variance(seen_once), 10 * sure);
}

/// Of boards that drive before a rolling shutter, from their first frame on.
/// @param known whether the calibration says that it is one.
test::PoseErrors ErrorsOf(const test::StreamFrames& frames, bool known) {
  DetectorOptions options = frames.Options();
  if (!known) options.camera->rows_read_ms = 0;
  Detector detector(options);
  DetectorMemory memory;
  test::PoseErrors errors;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const test::StreamFrame frame = frames.Frame(i);
    std::vector<MarkerPose> markers;
    detector.Detect(frame.image.view(), std::chrono::nanoseconds(std::llround(1e9 * frame.truth.time_s.value())),
                    memory, markers);
    errors.AddDifferences(markers, frame.truth.markers);
  }
  return errors;
}

TEST(RollingShutterOfAStream, PosesAreHonestOfRobotsThatDrive) {
  const test::StreamFrames frames(R"(
seed = 11
[camera]
size = "640x480"
focal_px = 900
distance = 1.5
fps = 30
exposure_ms = 3
rows_read_ms = 28
[swarm]
robots = 6
size = "6x6"
variant = "secded"
side = 0.1
speed = 0.4
acceleration = 2
[[phase]]
kind = "calm"
frames = 40
)");
  const test::PoseErrors undone = ErrorsOf(frames, true), left = ErrorsOf(frames, false);
  EXPECT_GE(undone.poses(), 6 * 40 * 19 / 20);
  for (const double mean : {undone.position(), undone.orientation()}) {
    EXPECT_GT(mean, 0.3);
    EXPECT_LT(mean, 1.5);
  }
  EXPECT_GT(left.position(), 20) << "there is something to undo";
}

}  // namespace
}  // namespace chequer
