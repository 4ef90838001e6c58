#include "detect/identity/cell_sampler.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "detect/common/homography.h"

namespace chequer {
namespace {

/// A cell with this light is overexposed; a board whose lightest cell has less than the second may have none (guesses).
constexpr float kOverexposedLight = 0.985f, kNearlyOverexposed = 0.85f;
/// If the middle of the lightest cell has less light, no cell is overexposed: cells of one ink differ by shading and
/// noise only (a guess).
constexpr float kMayBeOverexposed = 0.93f;
/// Half the window in a cell's middle: so many blurs short of its edge, and no more than that share of its shorter
/// side (guesses; as CellUnmixer, which takes over where no window is left).
constexpr double kBlursFromEdge = 1.2, kMostOfCell = 0.35;

/// Mean light of the window around a pixel.
Eigen::Vector3f WindowLight(const LightReader& reader, const Eigen::Vector2d& pixel, double half_px) {
  return reader.Rgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(half_px));
}

/// Mean light of a cell's middle, which its neighbours do not blur into.
Eigen::Vector3f MiddleLight(const BoardInImage& in, std::size_t cell) {
  const BoardPoint middle(in.board.geometry, in.lens, MiddleOfCell(in.size, static_cast<int>(cell)));
  const Eigen::Matrix2d& by_board = middle.pixel_by_board;
  const double short_side = std::abs(by_board.determinant()) / std::max(by_board.col(0).norm(), by_board.col(1).norm());
  const double clear =
      std::clamp(0.5 * short_side - kBlursFromEdge * in.board.image.blur_px, 0.0, kMostOfCell * short_side);
  return WindowLight(in.reader, middle.pixel, clear);
}

/// Where shadows' edges cross the board: makes the cells' light what it would be if the board were lit alike all over.
void EvenOut(const BoardInImage& in, CellLights& cells) {
  if (in.board.lit.empty()) return;
  ForCells(in.size, [&](std::size_t cell, int row, int col) {
    const CellLight& lit = in.board.lit[cell];
    if (lit.most == 0) return;
    Eigen::Vector3f& light = cells.light[cell];
    if (!lit.crossed()) {
      light /= std::sqrt(lit.least * lit.most);
    } else if (!IsDark(row, col)) {
      // What was read lies to one side of a shadow's edge, or to both: its colour is the cell's in any case.
      const float read = RedAndGreen::Of(light[0], light[1]);
      if (read > 0) light *= in.board.levels[cell].sum() / read;
    } else {
      // Dark cells return too little light to tell how much of it reached them.
      light /= lit.most;
      cells.half_lit[cell] = lit.most / lit.least;
    }
  });
}

}  // namespace

Eigen::Vector3f LightDiffers(const BoardInImage& in, std::size_t cell) {
  // From the cell's middle to that of a quarter, and half of the window there, as shares of the cell's side (a guess).
  constexpr double kOff = 0.2, kHalfWindow = 0.12;
  const Eigen::Vector2d middle = MiddleOfCell(in.size, static_cast<int>(cell));
  Eigen::Vector3f least = Eigen::Vector3f::Constant(std::numeric_limits<float>::max()), most = -least;
  for (const double x : {-kOff, kOff})
    for (const double y : {-kOff, kOff}) {
      const BoardPoint quarter(in.board.geometry, in.lens, middle + Eigen::Vector2d(x, y));
      const double side_px = std::sqrt(std::abs(quarter.pixel_by_board.determinant()));
      const Eigen::Vector3f light = WindowLight(in.reader, quarter.pixel, kHalfWindow * side_px);
      least = least.cwiseMin(light), most = most.cwiseMax(light);
    }
  return most - least;
}

void CellSampler::Sample(const BoardInImage& in, CellLights& cells) {
  board_.Start();
  const std::size_t count = static_cast<std::size_t>(in.size.rows * in.size.cols);
  cells.light.resize(count);
  cells.half_lit.assign(count, 1.0f);
  cells.overexposed.assign(count, 0);
  if (in.reader.channels() == 3) {
    // The fit's levels are free of what neighbours and the lens mix in.
    std::copy(in.board.levels.begin(), in.board.levels.end(), cells.light.begin());
    SampleOverexposed(in, cells);
    return;
  }
  if (!SampleSmall(in, cells))
    for (std::size_t cell = 0; cell < count; ++cell) cells.light[cell] = MiddleLight(in, cell);
  EvenOut(in, cells);
}

bool CellSampler::SampleSmall(const BoardInImage& in, CellLights& cells) {
  const MarkerSize size = in.size;
  // The homography from the cells, with a ring of others around the board, to the image, whatever the lens does.
  std::array<PointPair, 4> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector2d at(k % 2 == 0 ? 0 : size.cols, k / 2 == 0 ? 0 : size.rows);
    corners[k].from = at + Eigen::Vector2d::Ones();
    corners[k].to = in.lens.ToImage(in.board.geometry.ToPlane(at - 0.5 * Eigen::Vector2d(size.cols, size.rows)));
  }
  const double across = (corners[1].to - corners[0].to).norm() / size.cols,
               down = (corners[2].to - corners[0].to).norm() / size.rows;
  if (CellUnmixer::WindowsAreClear(in.reader, std::min(across, down), in.board.image.blur_px)) return false;
  const auto homography = FitHomography(corners);
  if (!homography) return false;
  const CellMesh mesh{*homography, size.rows + 2, size.cols + 2, static_cast<float>(in.board.image.blur_px)};
  board_->unmixed.resize(static_cast<std::size_t>(mesh.rows * mesh.cols));
  const bool solved = unmixer_.Solve(in.reader, mesh, board_->unmixed);
  cells.mixed_pixels = unmixer_.pixels();
  if (!solved) return false;
  ForCells(size, [&](std::size_t cell, int row, int col) {
    cells.light[cell] = board_->unmixed[static_cast<std::size_t>((row + 1) * mesh.cols + col + 1)];
  });
  return true;
}

void CellSampler::SampleOverexposed(const BoardInImage& in, CellLights& cells) {
  std::vector<Eigen::Vector3f>& light = cells.light;
  const auto brighter_than = [](float least) {
    return [least](const Eigen::Vector3f& of_cell) { return of_cell.maxCoeff() >= least; };
  };
  const auto lightest = std::max_element(light.begin(), light.end(),
                                         [](const auto& a, const auto& b) { return a.maxCoeff() < b.maxCoeff(); });
  if (lightest == light.end() || !brighter_than(kNearlyOverexposed)(*lightest)) return;
  // A cell is overexposed as a whole: where the lightest ones' middles are not, none is.
  if (!brighter_than(kMayBeOverexposed)(MiddleLight(in, static_cast<std::size_t>(lightest - light.begin())))) return;
  std::vector<Eigen::Vector3f>& middles = board_->middles;
  middles.resize(light.size());
  for (std::size_t cell = 0; cell < light.size(); ++cell) middles[cell] = MiddleLight(in, cell);
  if (std::none_of(middles.begin(), middles.end(), brighter_than(kOverexposedLight))) return;
  light = middles;
  std::ranges::transform(middles, cells.overexposed.begin(), brighter_than(kOverexposedLight));
  EvenOut(in, cells);
}

}  // namespace chequer
