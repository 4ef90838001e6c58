#include "detect/pose/rolling_shutter.h"

#include "detect/common/widened.h"
#include "detect/pose/homography_moves.h"

namespace chequer {
namespace {

/// A way that changes from frame to frame as it never did: the parabola's derivative at its end is off by a third of
/// how far the parabola misses the place, over the time of a frame (of the cubic that goes through it).
constexpr double kSpeedByMiss = 1.0 / 3;
/// Of a board that was seen once before: it may have begun to move, or to brake, in between (a guess).
constexpr double kSpeedOfTwoPlaces = 0.5;
/// Of one that was not seen before, while a frame's rows are read: cells, and rad (guesses).
constexpr double kSpeedOfOnePlace = 1, kSpinOfOnePlace = 0.1;

/// On a side of most boards.
constexpr int kCorners = 5;

/// A board's points, and the times when they were there.
class Path {
 public:
  Path(const BoardGeometry& now, const RecentPlaces& places, const Lens& lens)
      : now_(now), last_(places.last), before_(places.before), lens_(lens), middle_row_(RowOf(now, {0, 0})) {
    if (places.last_s == 0) return;
    const double last_row = RowOf(last_, {0, 0});
    last_s_ = places.last_s + lens.row_s() * (middle_row_ - last_row);
    if (places.before_s > 0) before_s_ = places.before_s + lens.row_s() * (last_row - RowOf(before_, {0, 0}));
  }

  bool has_two_places() const { return last_s_ > 0; }
  bool has_three_places() const { return before_s_ > 0; }
  double last_s() const { return last_s_; }
  double Cell() const { return now_.CellSide(); }

  /// By which a point moves for each rad that the board turns about its middle.
  Eigen::Vector2d Turning(const Eigen::Vector2d& board) const {
    const Eigen::Vector2d arm = now_.ToPlane(board) - now_.ToPlane({0, 0});
    return {-arm.y(), arm.x()};
  }

  /// By how much later than the middle a point is exposed.
  double LaterS(const Eigen::Vector2d& board) const { return lens_.row_s() * (RowOf(now_, board) - middle_row_); }
  /// Plane units a second.
  Eigen::Vector2d Velocity(const Eigen::Vector2d& board) const {
    if (!has_two_places()) return {0, 0};
    const Eigen::Vector2d last = last_.ToPlane(board), mean = (now_.ToPlane(board) - last) / last_s_;
    if (!has_three_places()) return mean;
    const Eigen::Vector2d mean_before = (last - before_.ToPlane(board)) / before_s_;
    return mean + last_s_ / (last_s_ + before_s_) * (mean - mean_before);
  }

 private:
  double RowOf(const BoardGeometry& geometry, const Eigen::Vector2d& board) const {
    return lens_.ToImage(geometry.ToPlane(board)).y();
  }

  BoardGeometry now_, last_, before_;
  const Lens& lens_;
  double middle_row_ = 0, last_s_ = 0, before_s_ = 0;
};

/// How surely a board's motion is known, a standard deviation.
struct Doubt {
  double speed = 0;  ///< right, and down: plane units a second
  double spin = 0;   ///< rad/s
};

Doubt DoubtOf(const Path& path, const RecentPlaces& places, const Lens& lens) {
  if (path.has_three_places())
    return {kSpeedByMiss * places.off / path.last_s(), kSpeedByMiss * places.turned_off / path.last_s()};
  if (!path.has_two_places())
    return {kSpeedOfOnePlace * path.Cell() / lens.rows_read_s(), kSpinOfOnePlace / lens.rows_read_s()};
  const Eigen::Vector2d middle(0, 0), right(1, 0);
  return {kSpeedOfTwoPlaces * path.Velocity(middle).norm(),
          kSpeedOfTwoPlaces * (path.Velocity(right) - path.Velocity(middle)).norm() / path.Turning(right).norm()};
}

}  // namespace

void UndoRollingShutter(const RecentPlaces& places, MarkerSize size, const Lens& lens, BoardMeasurement& measured) {
  BoardGeometry geometry(measured.plane_from_board);
  const Path path(geometry, places, lens);
  const Doubt doubt = DoubtOf(path, places, lens);
  // The way that is undone, and one standard deviation of it right, down, and turning.
  const auto by_moves = HomographyByMoves<4, kCorners>(geometry, size, [&](const Eigen::Vector2d& board) {
    Eigen::Matrix<double, 2, 4> moves;
    moves << -path.Velocity(board), Eigen::Matrix2d::Identity() * doubt.speed, path.Turning(board) * doubt.spin;
    return Eigen::Matrix<double, 2, 4>(path.LaterS(board) * moves);
  });
  geometry.Add(by_moves.col(0));
  measured.plane_from_board = geometry.plane_from_board();
  measured.information = Widened(measured.information, Eigen::Matrix<double, 8, 3>(by_moves.rightCols<3>()));
}

}  // namespace chequer
