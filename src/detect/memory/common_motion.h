#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "detect/common/board_geometry.h"

namespace chequer {

/// A board that was expected in an image and fitted there.
struct MovedBoard {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< where it was expected, plane units
  /// How far it was expected to go by itself since the last frame, and to turn: plane units, rad.
  Eigen::Vector2d own_way = Eigen::Vector2d::Zero();
  double own_turn = 0;
  /// How far it went while the shutter was open, and turned: plane units, rad. There and back are the same.
  Eigen::Vector2d way = Eigen::Vector2d::Zero();
  double turn = 0;
  Eigen::Vector2d off = Eigen::Vector2d::Zero();  ///< of where it was expected, plane units
};

/// A camera that turns a little, by how it moves points of the plane.
class CameraTurn {
 public:
  using ByTurn = Eigen::Matrix<double, 2, 3>;

  explicit CameraTurn(const Lens& lens)
      : per_focal_square_(lens.calibrated() ? 1 / (lens.focal() * lens.focal()) : 0) {}

  /// By the way along x and y in the plane's middle, plane units, and by the turn about the axis, rad.
  ByTurn ByTurnAt(const Eigen::Vector2d& place) const;
  Eigen::Vector2d At(const Eigen::Vector2d& place) const { return ByTurnAt(place) * by; }

  Eigen::Vector3d by = Eigen::Vector3d::Zero();

 private:
  double per_focal_square_;  ///< 0 without a calibration
};

/// How the camera turned since the last frame, by where boards lie that were expected elsewhere.
CameraTurn FindTurn(std::span<const MovedBoard> boards, const Lens& lens);

/// How boards moved while the shutter was open, of a camera that was knocked: each goes where the camera takes it, and
/// where it goes by itself, for the time that the shutter is open, which the boards show too. Fits of the others that
/// start from there take fewer steps.
class CommonMotion {
 public:
  /// Nothing where the boards do not move alike. May reverse `way` and `turn` of each, so that they do.
  static std::optional<CommonMotion> Find(std::span<MovedBoard> boards, const Lens& lens);

  /// How a board is likely to have moved of which the place and the own motion are known.
  MovedBoard Of(const MovedBoard& board) const;

 private:
  explicit CommonMotion(const Lens& lens) : while_open_(lens), since_last_(lens) {}
  void Solve(std::span<const MovedBoard> boards);
  /// The square of what a board is off, in deviations.
  double OffSquare(const MovedBoard& board) const;

  double open_ = 0;  ///< time that the shutter is open, over that between two frames
  CameraTurn while_open_, since_last_;
};

}  // namespace chequer
