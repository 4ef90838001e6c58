#include "detect/memory/common_shift.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace chequer {
namespace {

/// How far it is looked for, in steps of first some, then one pixel; and there, how far around the best one.
constexpr int kReachPx = 16, kCoarsePx = 2, kReachAroundPx = 4;
/// The same for a board by itself, which is not asked among others: in steps of a pixel; of larger cells, two.
constexpr int kOwnReach = 4;
constexpr double kLargeCellPx = 9;
/// Distance of the sampled points from the middle of their cell, cells. A wrong shift moves some of them to another
/// cell, so that the best shift is known to a fraction of a cell.
constexpr double kFromMiddle = 0.3;
/// Shifts of nearly the best contrast: their mean is the middle of the plateau. Where none lies on it, boards lie
/// elsewhere.
constexpr double kNearlyBest = 0.95;

/// A point that should be light, or dark: between the pixel and the next along its row, which are read together.
struct Point {
  int x, y;
  float sign;
};
using Points = std::array<Point, 4 * kMaxCells>;

/// Those that some shift takes into the image.
std::span<const Point> PlacePoints(const AnchoredBoard& board, const LightReader& reader, const Lens& lens,
                                   Points& points) {
  constexpr int kMost = kReachPx + kReachAroundPx;
  const BoardPoint middle(BoardGeometry(board.plane_from_board), lens);
  std::size_t count = 0;
  for (int cell = 0; cell < board.size.rows * board.size.cols; ++cell) {
    const Eigen::Vector2d at = MiddleOfCell(board.size, cell);
    const float sign = IsDark(cell / board.size.cols, cell % board.size.cols) ? -1.0f : 1.0f;
    for (const double y : {-kFromMiddle, kFromMiddle})
      for (const double x : {-kFromMiddle, kFromMiddle}) {
        const Eigen::Vector2d pixel = middle.pixel + middle.pixel_by_board * (at + Eigen::Vector2d(x, y));
        const auto near = [](double at_px, int size) { return at_px > -kMost && at_px < size + kMost - 1; };
        if (near(pixel.x(), reader.width()) && near(pixel.y(), reader.height()))
          points[count++] = {static_cast<int>(std::floor(pixel.x())), static_cast<int>(std::lround(pixel.y())), sign};
      }
  }
  return std::span(points).first(count);
}

/// Light of the light points over the dark ones, of the shifts around one, kReach steps of kStepPx along each axis.
template <int kReach, int kStepPx>
class ShiftContrasts {
 public:
  /// @param cells workspace
  ShiftContrasts(const LightReader& reader, const Eigen::Vector2i& middle_px, std::vector<float>& cells)
      : reader_(reader), rows_(reader.AllRows()), middle_px_(middle_px), cells_(cells) {}

  void Add(std::span<const Point> points) {
    if (points.empty()) return;
    const auto [left, right] = std::ranges::minmax(points, {}, &Point::x);
    const auto [top, bottom] = std::ranges::minmax(points, {}, &Point::y);
    const Eigen::Vector2i first = GridOf(left.x, top.y), last = GridOf(right.x, bottom.y);
    Read(first - Eigen::Vector2i::Constant(kReach), last + Eigen::Vector2i::Constant(kReach));
    for (const Point& point : points) {
      const Eigen::Vector2i at = GridOf(point.x, point.y) - first;
      const float* row = cells_.data() + at.y() * width_ + at.x();
      for (int shift = 0; shift <= 2 * kReach; ++shift, row += width_)
        contrasts_.col(shift) += point.sign * Eigen::Map<const Shifts>(row);
    }
  }
  /// @param shift_px one of those.
  float At(const Eigen::Vector2i& shift_px) const {
    const Eigen::Vector2i step = (shift_px - middle_px_) / kStepPx;
    return contrasts_(step.x() + kReach, step.y() + kReach);
  }
  /// That of the most contrast; in the middle, if none has more.
  Eigen::Vector2i Best() const {
    Eigen::Vector2i best = middle_px_;
    float most = At(best);
    ForEach([&](const Eigen::Vector2i& shift_px, float contrast) {
      if (contrast <= most) return;
      most = contrast;
      best = shift_px;
    });
    return best;
  }
  /// Calls act(shift in pixels, contrast) for each.
  template <class Act>
  void ForEach(Act&& act) const {
    for (int y = -kReach; y <= kReach; ++y)
      for (int x = -kReach; x <= kReach; ++x)
        act(Eigen::Vector2i(middle_px_ + kStepPx * Eigen::Vector2i(x, y)), contrasts_(x + kReach, y + kReach));
  }

 private:
  /// Of a whole number of vectors.
  static constexpr int kRow = (2 * kReach + 1 + 3) / 4 * 4;
  using Shifts = Eigen::Array<float, kRow, 1>;
  using Contrasts = Eigen::Array<float, kRow, 2 * kReach + 1>;

  /// Where the middle of the shifts takes a point, steps.
  Eigen::Vector2i GridOf(int x, int y) const {
    const auto steps = [&](int px) { return px >> (kStepPx - 1); };
    return {steps(x + middle_px_.x()), steps(y + middle_px_.y())};
  }

  /// The light of two neighbours at each step, of which one is green in a mosaic; none beyond the image.
  void Read(const Eigen::Vector2i& first, const Eigen::Vector2i& last) {
    width_ = last.x() - first.x() + kRow;
    cells_.assign(static_cast<std::size_t>((last.y() - first.y() + 1) * width_), 0.0f);
    const int from = std::max(-first.x(), 0),
              past = std::min(last.x() + 1, (reader_.width() - 2) / kStepPx + 1) - first.x();
    for (int row = 0; row <= last.y() - first.y(); ++row) {
      const int y = (first.y() + row) * kStepPx;
      if (y < 0 || y >= reader_.height() || from >= past) continue;
      const int x = (first.x() + from) * kStepPx;
      float* const to = cells_.data() + row * width_;
      if constexpr (kStepPx == 2) {
        ReadPairs(rows_.At(y).From(x), to, from, past, 1);
      } else {
        ReadPairs(rows_.At(y).From(x), to, from, past, 2);
        ReadPairs(rows_.At(y).From(x + 1), to, from + 1, past, 2);
      }
    }
  }
  static void ReadPairs(LightReader::Run run, float* to, int from, int past, int apart) {
    for (int i = from; i < past; i += apart, run.first += run.step, run.second += run.step)
      to[i] = run.is_mixed() ? run.Mixed(run.first) + run.Mixed(run.second)
                             : run.table[*run.first] + run.table[*run.second];
  }

  const LightReader& reader_;
  const LightReader::Rows rows_;
  const Eigen::Vector2i middle_px_ = Eigen::Vector2i::Zero();
  std::vector<float>& cells_;
  int width_ = 0;                            ///< of the cells
  Contrasts contrasts_ = Contrasts::Zero();  ///< by shifts along x and y
};

template <int kStepPx>
Eigen::Vector2d OwnShiftInStepsOf(const AnchoredBoard& board, const LightReader& reader, const Lens& lens,
                                  std::vector<float>& cells) {
  Points points;
  ShiftContrasts<kOwnReach, kStepPx> around(reader, {0, 0}, cells);
  around.Add(PlacePoints(board, reader, lens, points));
  const Eigen::Vector2i best = around.Best();
  const float most = around.At(best);
  if (around.At({0, 0}) >= static_cast<float>(kNearlyBest) * most || best.cwiseAbs().maxCoeff() == kOwnReach * kStepPx)
    return Eigen::Vector2d::Zero();
  Eigen::Vector2d shift = best.cast<double>();
  for (const int axis : {0, 1}) {
    const Eigen::Vector2i step = kStepPx * Eigen::Vector2i::Unit(axis);
    const double before = around.At(best - step), after = around.At(best + step), bend = before + after - 2.0 * most;
    if (bend < 0) shift[axis] += 0.5 * kStepPx * (before - after) / bend;
  }
  return shift;
}

}  // namespace

Eigen::Vector2d FindCommonShift(std::span<const AnchoredBoard> boards, std::size_t asked, const LightReader& reader,
                                const Lens& lens, std::vector<float>& cells) {
  static_assert(kReachPx % kCoarsePx == 0);
  const std::size_t step = std::max<std::size_t>(1, (boards.size() + asked - 1) / asked);
  Points points;
  const auto add_all = [&](auto& contrasts) {
    for (std::size_t i = 0; i < boards.size(); i += step) contrasts.Add(PlacePoints(boards[i], reader, lens, points));
  };
  ShiftContrasts<kReachPx / kCoarsePx, kCoarsePx> coarse(reader, {0, 0}, cells);
  add_all(coarse);
  const Eigen::Vector2i best = coarse.Best();
  if (coarse.At({0, 0}) >= static_cast<float>(kNearlyBest) * coarse.At(best)) return Eigen::Vector2d::Zero();
  ShiftContrasts<kReachAroundPx, 1> around(reader, best, cells);
  add_all(around);
  const float nearly = static_cast<float>(kNearlyBest) * around.At(best);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  around.ForEach([&](const Eigen::Vector2i& shift, float contrast) {
    if (contrast < nearly) return;
    sum += shift.cast<double>();
    ++count;
  });
  return sum / std::max(count, 1);
}

Eigen::Vector2d FindOwnShift(const AnchoredBoard& board, const LightReader& reader, const Lens& lens,
                             std::vector<float>& cells) {
  const BoardPoint middle(BoardGeometry(board.plane_from_board), lens);
  return middle.pixel_by_board.colwise().norm().minCoeff() < kLargeCellPx
             ? OwnShiftInStepsOf<1>(board, reader, lens, cells)
             : OwnShiftInStepsOf<2>(board, reader, lens, cells);
}

double SampledContrast(const AnchoredBoard& board) {
  if (board.light.size() == 0) return 0;
  float difference = 0, sum = 0;
  ForCells(board.size, [&](std::size_t cell, int row, int col) {
    const float light = board.light[cell][0] + board.light[cell][1];
    difference += IsDark(row, col) ? -light : light;
    sum += light;
  });
  return sum > 0 ? double{difference} / double{sum} : 0.0;
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
