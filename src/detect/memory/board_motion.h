#pragma once

#include <Eigen/Core>
#include <array>

namespace chequer {

/// How a board goes on, as its last frames tell. Of several ways of going on, the one holds that led least far off
/// lately: a robot on wheels turns its way with itself, one that slides does not, and what a robot does between two
/// speeds goes on changing. Where nothing changes, the plainest is the best: each difference that a prediction rests on
/// adds the errors of one more pose.
struct BoardMotion {
  /// Its centre moves on as before; as before, turned by as much as the board turns; as before, and faster or slower by
  /// as much as it was lately.
  enum Way { kAsBefore, kTurning, kChanging, kWays };
  /// The board turns as before, or faster or slower by as much as it did lately.
  enum Turn { kTurnsAsBefore, kTurnChanges, kTurns };

  /// The place one frame ago; `before_s` earlier; 0: not known.
  Eigen::Matrix3d before = Eigen::Matrix3d::Identity();
  double before_s = 0;
  /// How much farther its centre went than in the time before that, plane units.
  Eigen::Vector2d drift = Eigen::Vector2d::Zero();
  double spin = 0;  ///< and how much farther it turned, rad
  /// What a frame's error counts a frame later (a guess).
  static constexpr double kOffKept = 0.5;
  /// How far each way led off lately: squares, plane units, a frame's counting kOffKept of the next one's. And each
  /// turn.
  std::array<double, kWays> off{};
  std::array<double, kTurns> turned_off{};

  /// The mean of such a sum.
  static double MeanOf(double off_square) { return (1 - kOffKept) * off_square; }

  /// Where a board that lies at `now` will lie `ahead_s` later; it goes on growing as before.
  Eigen::Matrix3d Predict(const Eigen::Matrix3d& now, double ahead_s) const;
  /// What `last` becomes with a place that was found `ahead_s` after it. @param last the motion until `now`.
  void Learn(const BoardMotion& last, const Eigen::Matrix3d& now, double ahead_s, const Eigen::Matrix3d& found);
};

/// By which angle a board lies turned from another place of it, rad.
double TurnBetween(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

}  // namespace chequer
