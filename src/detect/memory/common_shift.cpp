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
/// Shifts of nearly the best contrast: their mean is the middle of the plateau. Where none lies on it, boards lie
/// elsewhere.
constexpr double kNearlyBest = 0.95;

/// Shifts whose contrast is asked for, along each axis from −kMost on: around each of the steps, too.
constexpr int kMost = kReachPx + 2 * kCoarsePx, kShifts = 2 * kMost + 1;
/// Of a whole number of vectors.
constexpr int kRow = (kShifts + 3) / 4 * 4;

/// A point that should be light, or dark.
struct Point {
  int x, y;
  float sign;
};
using Points = std::array<Point, 4 * kMaxCells>;

/// Those that some shift takes into the image.
std::span<const Point> PlacePoints(const AnchoredBoard& board, const LightReader& reader, const Lens& lens,
                                   Points& points) {
  const BoardGeometry geometry(board.plane_from_board);
  Eigen::Matrix2d pixel_by_plane;
  const Eigen::Vector2d middle = lens.ToImage(geometry.ToPlane({0, 0}), &pixel_by_plane);
  const Eigen::Matrix2d pixel_by_board = pixel_by_plane * geometry.PlaneByBoard({0, 0});
  std::size_t count = 0;
  for (int cell = 0; cell < board.size.rows * board.size.cols; ++cell) {
    const Eigen::Vector2d at = MiddleOfCell(board.size, cell);
    const float sign = IsDark(cell / board.size.cols, cell % board.size.cols) ? -1.0f : 1.0f;
    for (const double y : {-kFromMiddle, kFromMiddle})
      for (const double x : {-kFromMiddle, kFromMiddle}) {
        const Eigen::Vector2d pixel = middle + pixel_by_board * (at + Eigen::Vector2d(x, y));
        const auto near = [](double at_px, int size) { return at_px > -kMost && at_px < size + kMost - 1; };
        if (near(pixel.x(), reader.width()) && near(pixel.y(), reader.height()))
          points[count++] = {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())), sign};
      }
  }
  return std::span(points).first(count);
}

/// Light of the light points over the dark ones, of every shift. Each row of pixels is read once, and added to the
/// shifts that take points there.
class ShiftContrasts {
 public:
  /// @param row workspace
  ShiftContrasts(const LightReader& reader, std::vector<float>& row)
      : reader_(reader), rows_(reader.AllRows()), row_(row) {}

  void Add(std::span<const Point> points) {
    if (points.empty()) return;
    const auto [left, right] = std::ranges::minmax(points, {}, &Point::x);
    const auto [top, bottom] = std::ranges::minmax(points, {}, &Point::y);
    const int first = left.x - kMost;
    row_.assign(static_cast<std::size_t>(right.x - first + kMost + kRow - kShifts + 2), 0.0f);
    for (int y = std::max(top.y - kMost, 0); y <= std::min(bottom.y + kMost, reader_.height() - 1); ++y) {
      Read(y, first);
      for (const Point& point : points) {
        const int shift = y - point.y + kMost;
        if (shift < 0 || shift >= kShifts) continue;
        contrasts_.col(shift) += point.sign * Eigen::Map<const Shifts>(row_.data() + (point.x - kMost - first));
      }
    }
  }
  float At(int x, int y) const { return contrasts_(x + kMost, y + kMost); }

 private:
  using Shifts = Eigen::Array<float, kRow, 1>;
  using Contrasts = Eigen::Array<float, kRow, kShifts>;

  /// The light of two neighbours each, of which one is green in a mosaic; none beyond the image.
  void Read(int y, int first) {
    const int size = static_cast<int>(row_.size()), from = std::max(-first, 0),
              past = std::min(reader_.width() - first, size);
    LightReader::Run run = rows_.From(first + from, y);
    for (int i = from; i < past; i += 2, run.first += run.step, run.second += run.step) {
      row_[static_cast<std::size_t>(i)] = run.is_mixed() ? run.Mixed(run.first) : run.table[*run.first];
      if (i + 1 < past)
        row_[static_cast<std::size_t>(i + 1)] = run.is_mixed() ? run.Mixed(run.second) : run.table[*run.second];
    }
    for (int i = from; i + 1 < past; ++i) row_[static_cast<std::size_t>(i)] += row_[static_cast<std::size_t>(i + 1)];
    row_[static_cast<std::size_t>(past - 1)] = 0;
  }

  const LightReader& reader_;
  const LightReader::Rows rows_;
  std::vector<float>& row_;
  Contrasts contrasts_ = Contrasts::Zero();  ///< by shifts along x and y
};

}  // namespace

Eigen::Vector2d FindCommonShift(std::span<const AnchoredBoard> boards, std::size_t asked, const LightReader& reader,
                                const Lens& lens, std::vector<float>& row) {
  static_assert(kReachPx % kCoarsePx == 0);
  ShiftContrasts contrasts(reader, row);
  const std::size_t step = std::max<std::size_t>(1, (boards.size() + asked - 1) / asked);
  Points points;
  for (std::size_t i = 0; i < boards.size(); i += step) {
    contrasts.Add(PlacePoints(boards[i], reader, lens, points));
  }
  const float none = contrasts.At(0, 0);
  float most = none;
  Eigen::Vector2i best(0, 0);
  for (int y = -kReachPx; y <= kReachPx; y += kCoarsePx)
    for (int x = -kReachPx; x <= kReachPx; x += kCoarsePx) {
      const float contrast = contrasts.At(x, y);
      if (contrast <= most) continue;
      most = contrast;
      best = {x, y};
    }
  if (none >= static_cast<float>(kNearlyBest) * most) return Eigen::Vector2d::Zero();
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (int y = best.y() - 2 * kCoarsePx; y <= best.y() + 2 * kCoarsePx; ++y)
    for (int x = best.x() - 2 * kCoarsePx; x <= best.x() + 2 * kCoarsePx; ++x) {
      if (contrasts.At(x, y) < static_cast<float>(kNearlyBest) * most) continue;
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
