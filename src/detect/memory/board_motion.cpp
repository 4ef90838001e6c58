#include "detect/memory/board_motion.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

namespace chequer {
namespace {

/// Predictions reach no farther ahead than so many times the way they were taken from.
constexpr double kMostAhead = 4;

/// A homography by the board's middle: its place, its derivative there, and its third row.
struct AroundMiddle {
  explicit AroundMiddle(const Eigen::Matrix3d& plane_from_board)
      : place(plane_from_board.topRightCorner<2, 1>()),
        third(plane_from_board.bottomLeftCorner<1, 2>()),
        plane_by_board(plane_from_board.topLeftCorner<2, 2>() - place * third) {}

  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  Eigen::RowVector2d third = Eigen::RowVector2d::Zero();
  Eigen::Matrix2d plane_by_board = Eigen::Matrix2d::Zero();
};

double AngleOf(const Eigen::Matrix2d& turn) { return std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1)); }

template <class Choice>
Choice LeastOff(std::span<const double> off) {
  return static_cast<Choice>(std::min_element(off.begin(), off.end()) - off.begin());
}

/// What lies `share` of an interval ahead.
class Ahead {
 public:
  Ahead(const BoardMotion& motion, const Eigen::Matrix3d& now, double ahead_s)
      : motion_(motion),
        share_(std::min(ahead_s / motion.before_s, kMostAhead)),
        now_(now),
        before_(motion.before),
        turn_(now_.plane_by_board * before_.plane_by_board.inverse()) {}

  Eigen::Vector2d Place(BoardMotion::Way way) const {
    Eigen::Vector2d step = share_ * (now_.place - before_.place);
    if (way == BoardMotion::kTurning) step = Eigen::Rotation2Dd(share_ * AngleOf(turn_)) * step;
    if (way == BoardMotion::kChanging) step += share_ * share_ * motion_.drift;
    return now_.place + step;
  }
  /// It turns by the same angle again, rather than moving along the same chord: (1 + t)^share, to the square of t,
  /// which is exact a whole interval ahead.
  Eigen::Matrix2d PlaneByBoard(BoardMotion::Turn turn) const {
    const Eigen::Matrix2d t = turn_ - Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d turned =
        now_.plane_by_board + share_ * (t + 0.5 * (share_ - 1) * t * t) * now_.plane_by_board;
    if (turn == BoardMotion::kTurnsAsBefore) return turned;
    return Eigen::Rotation2Dd(share_ * share_ * motion_.spin) * turned;
  }
  const Eigen::RowVector2d& third() const { return now_.third; }

 private:
  const BoardMotion& motion_;
  double share_;
  AroundMiddle now_, before_;
  Eigen::Matrix2d turn_ = Eigen::Matrix2d::Identity();
};

}  // namespace

double TurnBetween(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to) {
  return AngleOf(AroundMiddle(to).plane_by_board * AroundMiddle(from).plane_by_board.inverse());
}

Eigen::Matrix3d BoardMotion::Predict(const Eigen::Matrix3d& now, double ahead_s) const {
  if (before_s <= 0) return now;
  const Ahead ahead(*this, now, ahead_s);
  const Eigen::Vector2d place = ahead.Place(LeastOff<Way>(off));
  Eigen::Matrix3d predicted = now;
  predicted.topRightCorner<2, 1>() = place;
  predicted.topLeftCorner<2, 2>() = ahead.PlaneByBoard(LeastOff<Turn>(turned_off)) + place * ahead.third();
  return predicted;
}

void BoardMotion::Learn(const BoardMotion& last, const Eigen::Matrix3d& now, double ahead_s,
                        const Eigen::Matrix3d& found) {
  if (last.before_s <= 0) return;
  const Ahead ahead(last, now, ahead_s);
  const AroundMiddle there(found);
  drift = there.place - ahead.Place(kAsBefore);
  const auto turned = [&](Turn turn) { return AngleOf(there.plane_by_board * ahead.PlaneByBoard(turn).inverse()); };
  spin = turned(kTurnsAsBefore);
  for (const Way way : {kAsBefore, kTurning, kChanging})
    off[way] = kOffKept * last.off[way] + (there.place - ahead.Place(way)).squaredNorm();
  for (const Turn turn : {kTurnsAsBefore, kTurnChanges})
    turned_off[turn] = kOffKept * last.turned_off[turn] + std::pow(turned(turn), 2);
}

}  // namespace chequer
