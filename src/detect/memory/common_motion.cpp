#include "detect/memory/common_motion.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// What a board's way, turn and place say of the camera's, plane units and rad: its fit is better, but robots gain and
/// lose speed (a guess).
constexpr double kWayPx = 0.1, kTurn = 0.005, kOffPx = 0.2;
/// What is known before: how long the shutter is open, over the time between two frames; by how much cameras turn about
/// their axis meanwhile, and from one frame to the next, rad; how far off the shift is that was found, px (guesses).
constexpr double kOpen = 0.5, kTurnWhileOpen = 0.01, kTurnSinceLast = 0.003, kShiftPx = 3;
/// Of so many boards it is tried whether each went there or back; the first went there.
constexpr std::size_t kTried = 4;
/// The most that may be left, RMS of deviations (a guess).
constexpr double kMostLeft = 8;

/// Least squares.
template <int kUnknowns>
struct Squares {
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;

  Eigen::Matrix<double, kUnknowns, kUnknowns> normal = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Vector gradient = Vector::Zero();

  void Expect(int unknown, double deviation) { normal(unknown, unknown) += 1 / (deviation * deviation); }
  void Add(const Vector& by, double value, double deviation) {
    normal += by * by.transpose() / (deviation * deviation);
    gradient += by * (value / (deviation * deviation));
  }
  Vector Solve() const { return SmallCholesky<kUnknowns>(normal).Solve(gradient); }
};

void Reverse(MovedBoard& board) {
  board.way = -board.way;
  board.turn = -board.turn;
}

}  // namespace

CameraTurn::ByTurn CameraTurn::ByTurnAt(const Eigen::Vector2d& place) const {
  ByTurn rows;
  // A camera that turns to a side moves what lies there farther.
  rows << Eigen::Matrix2d::Identity() + per_focal_square_ * place * place.transpose(),
      Eigen::Vector2d(-place.y(), place.x());
  return rows;
}

CameraTurn FindTurn(std::span<const MovedBoard> boards, const Lens& lens) {
  CameraTurn turn(lens);
  Squares<3> squares;
  for (int axis = 0; axis < 2; ++axis) squares.Expect(axis, kShiftPx);
  squares.Expect(2, kTurnSinceLast);
  for (const MovedBoard& board : boards) {
    const CameraTurn::ByTurn rows = turn.ByTurnAt(board.place);
    for (int axis = 0; axis < 2; ++axis) squares.Add(rows.row(axis), board.off[axis], kOffPx);
  }
  turn.by = squares.Solve();
  return turn;
}

void CommonMotion::Solve(std::span<const MovedBoard> boards) {
  Squares<4> squares;
  squares.Expect(3, kOpen);
  squares.Expect(2, kTurnWhileOpen);
  for (const MovedBoard& board : boards) {
    const CameraTurn::ByTurn rows = while_open_.ByTurnAt(board.place);
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Vector4d by;
      by << rows.row(axis).transpose(), board.own_way[axis];
      squares.Add(by, board.way[axis], kWayPx);
    }
    squares.Add({0, 0, 1, board.own_turn}, board.turn, kTurn);
  }
  const Eigen::Vector4d solved = squares.Solve();
  while_open_.by = solved.head<3>();
  open_ = solved[3];
}

double CommonMotion::OffSquare(const MovedBoard& board) const {
  const MovedBoard likely = Of(board);
  const double turn = (board.turn - likely.turn) / kTurn;
  return (board.way - likely.way).squaredNorm() / (kWayPx * kWayPx) + turn * turn;
}

MovedBoard CommonMotion::Of(const MovedBoard& board) const {
  MovedBoard moved = board;
  moved.way = while_open_.At(board.place) + open_ * board.own_way;
  moved.turn = while_open_.by[2] + open_ * board.own_turn;
  moved.off = since_last_.At(board.place);
  return moved;
}

std::optional<CommonMotion> CommonMotion::Find(std::span<MovedBoard> boards, const Lens& lens) {
  if (boards.empty()) return std::nullopt;
  CommonMotion motion(lens);
  const auto left_of = [&](std::span<const MovedBoard> some) {
    double sum = 0;
    for (const MovedBoard& board : some) sum += motion.OffSquare(board);
    return sum;
  };
  const std::span<MovedBoard> tried = boards.first(std::min(boards.size(), kTried));
  // Each bit reverses a board.
  const auto reverse = [&](std::size_t bits) {
    for (std::size_t i = 1; i < tried.size(); ++i)
      if (bits >> (i - 1) & 1) Reverse(tried[i]);
  };
  std::size_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t bits = 0; bits < std::size_t{1} << (tried.size() - 1); ++bits) {
    reverse(bits);
    motion.Solve(tried);
    if (const double left = left_of(tried); left < least) least = left, best = bits;
    reverse(bits);
  }
  reverse(best);
  motion.Solve(tried);
  for (MovedBoard& board : boards.subspan(tried.size())) {
    MovedBoard reversed = board;
    Reverse(reversed);
    if (motion.OffSquare(reversed) < motion.OffSquare(board)) board = reversed;
  }
  motion.Solve(boards);
  if (left_of(boards) > 3 * kMostLeft * kMostLeft * static_cast<double>(boards.size())) return std::nullopt;
  motion.since_last_ = FindTurn(boards, lens);
  return motion;
}

}  // namespace chequer
