#include "detect/memory/common_shift.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace chequer {
namespace {

/// How far it is looked for, in steps of first some, then one pixel.
constexpr int kReachPx = 16, kCoarsePx = 2;
/// Distance of the sampled points from the middle of their cell, cells. A wrong shift moves some of them to another
/// cell, so that the best shift is known to a fraction of a cell.
constexpr double kFromMiddle = 0.3;
/// Contrast of a shift over that of none: less is noise.
constexpr double kClearer = 1.2;
/// Shifts of nearly the best contrast: their mean is the middle of the plateau.
constexpr double kNearlyBest = 0.95;

/// A point that should be light, or dark.
struct Point {
  float x, y, sign;
};
constexpr std::size_t kPointsOfCell = 4;
using Points = std::array<Point, kMostAskedForShift * kMaxCells * kPointsOfCell>;

std::size_t PlacePoints(std::span<const AnchoredBoard> boards, std::size_t asked, const Lens& lens, Points& points) {
  std::size_t count = 0;
  const std::size_t step = std::max<std::size_t>(1, (boards.size() + asked - 1) / asked);
  for (std::size_t i = 0; i < boards.size(); i += step) {
    const AnchoredBoard& board = boards[i];
    const BoardGeometry geometry(board.plane_from_board);
    Eigen::Matrix2d pixel_by_plane;
    const Eigen::Vector2d middle = lens.ToImage(geometry.ToPlane({0, 0}), &pixel_by_plane);
    const Eigen::Matrix2d pixel_by_board = pixel_by_plane * geometry.PlaneByBoard({0, 0});
    for (int cell = 0; cell < board.size.rows * board.size.cols; ++cell) {
      const Eigen::Vector2d at = MiddleOfCell(board.size, cell);
      const float sign = IsDark(cell / board.size.cols, cell % board.size.cols) ? -1.0f : 1.0f;
      for (const double y : {-kFromMiddle, kFromMiddle})
        for (const double x : {-kFromMiddle, kFromMiddle}) {
          const Eigen::Vector2f pixel = (middle + pixel_by_board * (at + Eigen::Vector2d(x, y))).cast<float>();
          points[count++] = {pixel.x(), pixel.y(), sign};
        }
    }
  }
  return count;
}

/// Light of the light points over the dark ones.
float ContrastAt(std::span<const Point> points, Eigen::Vector2i shift, const LightReader& reader,
                 const LightReader::Rows& rows) {
  float sum = 0;
  for (const Point& point : points) {
    const int x = static_cast<int>(point.x + 0.5f) + shift.x(), y = static_cast<int>(point.y + 0.5f) + shift.y();
    if (x < 0 || y < 0 || x + 1 >= reader.width() || y >= reader.height()) continue;
    // Of a mosaic, one of them is green.
    const LightReader::Run run = rows.From(x, y);
    sum += point.sign * (run.is_mixed() ? run.Mixed(run.first) + run.Mixed(run.second)
                                        : run.table[*run.first] + run.table[*run.second]);
  }
  return sum;
}

}  // namespace

Eigen::Vector2d FindCommonShift(std::span<const AnchoredBoard> boards, std::size_t asked, const LightReader& reader,
                                const Lens& lens) {
  static_assert(kReachPx % kCoarsePx == 0);
  Points all;
  const std::span<const Point> points(all.data(), PlacePoints(boards, asked, lens, all));
  const LightReader::Rows rows = reader.AllRows();
  const auto contrast_at = [&](int x, int y) { return ContrastAt(points, {x, y}, reader, rows); };
  const float none = contrast_at(0, 0);
  float most = none;
  Eigen::Vector2i best(0, 0);
  // By all points: half of them take other shifts for the best where boards are blurred (of knocked boards of 7 px
  // cells, 2 to 8 % less were read).
  for (int y = -kReachPx; y <= kReachPx; y += kCoarsePx)
    for (int x = -kReachPx; x <= kReachPx; x += kCoarsePx) {
      const float contrast = contrast_at(x, y);
      if (contrast <= most) continue;
      most = contrast;
      best = {x, y};
    }
  if (most <= static_cast<float>(kClearer) * none) return Eigen::Vector2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int y = best.y() - 2 * kCoarsePx; y <= best.y() + 2 * kCoarsePx; ++y)
    for (int x = best.x() - 2 * kCoarsePx; x <= best.x() + 2 * kCoarsePx; ++x) {
      if (contrast_at(x, y) < static_cast<float>(kNearlyBest) * most) continue;
      sum += Eigen::Vector2d(x, y);
      ++count;
    }
  return sum / std::max(count, 1);
}

double SampledContrast(const AnchoredBoard& board) {
  if (board.light.size() == 0) return 0;
  float sum = 0;
  ForCells(board.size, [&](std::size_t cell, int row, int col) {
    const float light = board.light[cell][0] + board.light[cell][1];
    sum += IsDark(row, col) ? -light : light;
  });
  return double{sum} / static_cast<double>(board.light.size());
}

Eigen::Matrix3d Shifted(const Eigen::Matrix3d& plane_from_board, const Eigen::Vector2d& shift_px, const Lens& lens) {
  Eigen::Matrix2d pixel_by_plane;
  lens.ToImage((plane_from_board * Eigen::Vector3d(0, 0, 1)).hnormalized(), &pixel_by_plane);
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift.topRightCorner<2, 1>() = pixel_by_plane.inverse() * shift_px;
  const Eigen::Matrix3d shifted = shift * plane_from_board;
  return shifted / shifted(2, 2);
}

}  // namespace chequer
