#include "evaluate/frame_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <utility>

#include "evaluate/phase_score.h"

namespace chequer {
namespace {

/// A board of 6 × 6 cells of 10 px at a place in the image.
TrueMarker BoardAt(std::uint64_t id, double x_px, double inside = 1, double visible = 1) {
  TrueMarker board;
  board.id = id;
  board.variant = "secded";
  board.size = {6, 6};
  board.cell_px = 10;
  board.center_px = {x_px, 100};
  board.camera_from_marker.translation = {x_px / 1000, 0.1, 1};
  board.inside = inside;
  board.visible = visible;
  return board;
}

FoundMarker FoundAt(std::optional<std::uint64_t> id, double x_px) {
  FoundMarker marker;
  marker.id = id;
  marker.variant = "secded";
  marker.center_px = {x_px, 100};
  return marker;
}

FrameTruth TruthWith(std::vector<TrueMarker> boards) {
  FrameTruth truth;
  truth.markers = std::move(boards);
  return truth;
}

FrameScore Score(std::vector<FoundMarker> found, std::vector<TrueMarker> boards) {
  return ScoreFrame({.markers = std::move(found), .detect_ms = {}, .latency_ms = {}}, TruthWith(std::move(boards)));
}

TEST(FrameScore, CountsCarriedIdsApart) {
  FoundMarker carried = FoundAt(1, 101), right = FoundAt(2, 300);
  carried.carried = true;
  carried.camera_from_marker = right.camera_from_marker = RigidTransform{};
  const FrameScore score = Score({carried, right}, {BoardAt(1, 100), BoardAt(2, 300)});
  EXPECT_EQ(score.read, 2);
  EXPECT_EQ(score.carried, 1);
  ASSERT_EQ(score.errors.size(), 2u);
  EXPECT_TRUE(score.errors[0].carried);
  EXPECT_FALSE(score.errors[1].carried);
  const ScoredFrame frame{.phase = "hands", .time_s = 0, .score = score, .detect_ms = {}, .latency_ms = {}};
  const PhaseScore phase = ScoreAll(std::span(&frame, 1), "all");
  EXPECT_EQ(phase.position_mm.count, 1u);
  EXPECT_EQ(phase.carried_position_mm.count, 1u);
}

TEST(FrameScore, CountsEachKindOfDetection) {
  const FrameScore score =
      Score({FoundAt(1, 101),             // right
             FoundAt(1, 99),              // the same board once more
             FoundAt(3, 300),             // board 2's place
             FoundAt(std::nullopt, 500),  // no claim
             FoundAt(4, 700),             // right, but only a third of it is in the image
             FoundAt(2, 940)},            // 40 px from the only board about
            {BoardAt(1, 100), BoardAt(2, 300), BoardAt(3, 500), BoardAt(4, 700, 0.33, 0.33), BoardAt(5, 900, 1, 0.7)});
  EXPECT_EQ(score.expected, 4);
  EXPECT_EQ(score.read, 1);
  EXPECT_EQ(score.whole, 3);
  EXPECT_EQ(score.whole_read, 1);
  EXPECT_EQ(score.twice, 1);
  EXPECT_EQ(score.wrong, 1);
  EXPECT_EQ(score.undecided, 1);
  EXPECT_EQ(score.ghosts, 1);
  EXPECT_DOUBLE_EQ(score.Recall(), 0.25);
}

TEST(FrameScore, AnIdOfAnotherVariantIsWrong) {
  FoundMarker marker = FoundAt(1, 100);
  marker.variant = "golay";
  EXPECT_EQ(Score({marker}, {BoardAt(1, 100)}).wrong, 1);
  marker.variant.clear();
  EXPECT_EQ(Score({marker}, {BoardAt(1, 100)}).read, 1) << "results that do not say their variant";
}

TEST(FrameScore, AnIdThatIsReadOnTwoBoardsIsWrongOnOne) {
  const FrameScore score = Score({FoundAt(1, 100), FoundAt(1, 300)}, {BoardAt(1, 100), BoardAt(2, 300)});
  EXPECT_EQ(score.read, 1);
  EXPECT_EQ(score.wrong, 1);
  EXPECT_EQ(score.twice, 0);
}

TEST(FrameScore, TakesTheNearestOfTwoBoards) {
  // 25 px from board 1, within half its side; 20 from board 2.
  EXPECT_EQ(Score({FoundAt(2, 125)}, {BoardAt(1, 100), BoardAt(2, 145)}).read, 1);
}

TEST(FrameScore, NothingExpectedIsNothingMissed) { EXPECT_EQ(Score({}, {}).Recall(), 1); }

TEST(FrameScore, MeasuresErrorsAgainstTheirCovariance) {
  FoundMarker marker = FoundAt(1, 100);
  const TrueMarker board = BoardAt(1, 100);
  marker.camera_from_marker = board.camera_from_marker;
  marker.camera_from_marker->translation += Eigen::Vector3d(0.003, 0, -0.004);
  marker.camera_from_marker->rotation =
      RotationFromVector(Eigen::Vector3d(0, 0, -0.02)) * board.camera_from_marker.rotation;
  marker.covariance = Matrix6d::Identity() * 1e-6;
  marker.covariance->bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() * 4e-4;
  const FrameScore score = Score({marker}, {board});
  ASSERT_EQ(score.errors.size(), 1u);
  EXPECT_NEAR(score.errors[0].position_mm, 5, 1e-9);
  EXPECT_NEAR(score.errors[0].angle_deg, 0.02 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(*score.errors[0].position_over_covariance, 25.0 / 3, 1e-9);
  EXPECT_NEAR(*score.errors[0].rotation_over_covariance, 1.0 / 3, 1e-9);
  marker.covariance->setZero();
  EXPECT_FALSE(Score({marker}, {board}).errors[0].position_over_covariance.has_value());
}

}  // namespace
}  // namespace chequer
