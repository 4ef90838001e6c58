// How a knocked camera moved, as some boards show it.
#include "detect/memory/common_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "chequer/camera_model.h"

namespace chequer {
namespace {

constexpr double kFocalPx = 1800;

Lens LensOf() {
  CameraModel camera;
  camera.width = 1280, camera.height = 720;
  camera.fx = camera.fy = kFocalPx;
  camera.cx = 640, camera.cy = 360;
  return Lens(camera);
}

/// By turns about x, y and the axis, rad, to the first order.
Eigen::Vector2d TurnedBy(const Eigen::Vector3d& turn, const Eigen::Vector2d& place) {
  const Eigen::Vector3d ray(place.x(), place.y(), kFocalPx);
  return ((ray + turn.cross(ray)) / (ray + turn.cross(ray)).z() * kFocalPx - ray).head<2>();
}

/// Boards here and there, with motions of their own, seen by a camera that turned while the shutter was open for `open`
/// of the time between two frames, and before.
std::vector<MovedBoard> BoardsSeenBy(const Eigen::Vector3d& while_open, const Eigen::Vector3d& before, double open) {
  std::vector<MovedBoard> boards;
  for (int i = 0; i < 12; ++i) {
    MovedBoard& board = boards.emplace_back();
    const double angle = 2.4 * i;
    board.place = {550 * std::cos(angle) * i / 12, 330 * std::sin(angle) * i / 12};
    board.own_way = 5 * Eigen::Vector2d(std::cos(1.7 * i), std::sin(1.7 * i));
    board.own_turn = 0.05 * std::cos(0.9 * i);
    // There and back look the same.
    const double sign = i % 3 == 1 ? -1 : 1;
    board.way = sign * (TurnedBy(while_open, board.place) + open * board.own_way);
    board.turn = sign * (while_open.z() + open * board.own_turn);
    board.off = TurnedBy(before, board.place);
  }
  return boards;
}

TEST(CommonMotion, TellsOfSomeBoardsHowTheOthersMoved) {
  const Eigen::Vector3d while_open(0.003, -0.004, 0.002), before(0.0004, 0.0003, 0.001);
  const std::vector<MovedBoard> all = BoardsSeenBy(while_open, before, 0.4);
  for (const std::size_t shown : {std::size_t{3}, std::size_t{4}, std::size_t{7}}) {
    std::vector<MovedBoard> some(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(shown));
    const auto motion = CommonMotion::Find(some, LensOf());
    ASSERT_TRUE(motion) << shown;
    for (const MovedBoard& board : all) {
      const MovedBoard likely = motion->Of(board);
      const double sign = likely.way.dot(board.way) < 0 ? -1 : 1;
      EXPECT_LT((sign * likely.way - board.way).norm(), 0.15) << shown << " boards";
      EXPECT_NEAR(sign * likely.turn, board.turn, 0.003) << shown << " boards";
      EXPECT_LT((likely.off - board.off).norm(), 0.25) << shown << " boards";
    }
  }
}

// The first may have gone there or back, and where the camera hardly moves, the boards' own motions tell which.
TEST(CommonMotion, TellsWhichWentThereAndWhichBack) {
  std::vector<MovedBoard> boards = BoardsSeenBy({0.0002, 0.0001, 0}, Eigen::Vector3d::Zero(), 0.4);
  ASSERT_TRUE(CommonMotion::Find(boards, LensOf()));
  for (const MovedBoard& board : boards)
    EXPECT_GT(board.way.dot(board.own_way) * boards[0].way.dot(boards[0].own_way), 0);
}

TEST(CommonMotion, SaysNothingOfBoardsThatMoveEachTheirOwnWay) {
  std::vector<MovedBoard> boards = BoardsSeenBy(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), 0.4);
  for (std::size_t i = 0; i < boards.size(); ++i)
    boards[i].way = 6 * Eigen::Vector2d(std::cos(2.1 * static_cast<double>(i)), std::sin(2.1 * static_cast<double>(i)));
  EXPECT_FALSE(CommonMotion::Find(boards, LensOf()));
  EXPECT_FALSE(CommonMotion::Find({}, LensOf()));
}

TEST(CommonMotion, OneBoardSpeaksForAll) {
  std::vector<MovedBoard> one = BoardsSeenBy({0.003, -0.004, 0}, Eigen::Vector3d::Zero(), 0);
  one.resize(1);
  const auto motion = CommonMotion::Find(one, Lens());
  ASSERT_TRUE(motion);
  EXPECT_LT((motion->Of({.place = {100, 50}}).way - one[0].way).norm(), 0.3);
}

TEST(CameraTurn, IsFoundByWhereBoardsLie) {
  const Eigen::Vector3d before(0.0015, -0.002, 0.001);
  const CameraTurn turn = FindTurn(BoardsSeenBy(Eigen::Vector3d::Zero(), before, 0), LensOf());
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(0, 0), Eigen::Vector2d(600, -300), Eigen::Vector2d(-500, 200)})
    EXPECT_LT((turn.At(place) - TurnedBy(before, place)).norm(), 0.1);
}

}  // namespace
}  // namespace chequer
