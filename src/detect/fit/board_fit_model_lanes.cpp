// Of BoardFit: what the model with all its terms is given of a board, and of each of its corners.
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Correlation of the blur along both edges of a cell: from here on it is taken to a higher order. Below, what that
/// adds to the light is less than .3 % of the contrast (.5 × .3² × the square of the largest bend, .24). Above, fits
/// without it come to rest beside their minimum: at a slant of 65 degrees (.7) up to 20 deviations off.
constexpr double kSkewed = 0.3;
/// How far beyond the rim the light beside the board is looked up, cells, and half the width of the window: in the
/// middle of the margin of one cell that prints should have. (Farther out, a way brings what lies beyond it: measured,
/// with ways of .7 cells and such a margin, depths were off by 1.4 to 2 times as much, at 2.0 to 2.5 squares of their
/// covariances.)
constexpr double kBeside = 0.5, kBesideHalf = 0.15;
/// More pixels tell no more of it.
constexpr double kMostBesidePx = 4;

/// Of the 4 × 4 cells around a corner: the one of its four that is as dark or light, and near.
std::size_t QuadrantOfColour(int row, int col) {
  const int near_row = std::clamp(row, 1, 2), near_col = std::clamp(col, 1, 2);
  const bool same = (row + col + near_row + near_col) % 2 == 0;
  return static_cast<std::size_t>(2 * (near_row - 1) + (same ? near_col - 1 : 2 - near_col));
}

}  // namespace

void BoardFit::LookBeside(const LightReader& reader, const Lens& lens) {
  const int rows = run_->view.size.rows + 2, cols = run_->view.size.cols + 2;
  run_->around.beside.resize(static_cast<std::size_t>(rows * cols));
  // At least beyond what the board sends there during the exposure.
  const Eigen::Vector2d half_way = (BoardByPixel() * run_->model.motion_px).cwiseAbs() / 2,
                        reach = (half_way + Eigen::Vector2d::Constant(kBesideHalf)).cwiseMax(kBeside);
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      if (row > 0 && col > 0 && row < rows - 1 && col < cols - 1) continue;
      const auto along = [](int i, int count, double beyond) {
        const double middle = i + 0.5 - 0.5 * count, rim = 0.5 * count - 1;
        return i == 0 ? -rim - beyond : i == count - 1 ? rim + beyond : middle;
      };
      const Eigen::Vector2d board(along(col, cols, reach.x()), along(row, rows, reach.y()));
      Eigen::Matrix2d pixel_by_plane;
      const Eigen::Vector2d pixel = lens.ToImage(run_->model.geometry.ToPlane(board), &pixel_by_plane);
      const double cell_px =
                       std::sqrt(std::abs((pixel_by_plane * run_->model.geometry.PlaneByBoard(board)).determinant())),
                   half_px = std::min(kBesideHalf * cell_px, kMostBesidePx);
      const LightThere lit = run_->model.LightAt(board);
      const Eigen::Vector3f light =
          reader.Rgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(half_px));
      for (std::size_t phase = 0; phase < 4; ++phase)
        run_->around.beside[static_cast<std::size_t>(row * cols + col)][phase] = lit.Of(
            run_->view.channels == 3 ? light[run_->view.channel_of_phase[phase]] : RedAndGreen::Of(light[0], light[1]),
            phase);
    }
}

void BoardFit::MapLevels() {
  const int corners = pixels_.corners();
  run_->around.levels.resize(static_cast<std::size_t>(corners));
  for (int corner = 0; corner < corners; ++corner) {
    const int row = corner / (run_->view.size.cols - 1), col = corner % (run_->view.size.cols - 1);
    const QuadrantLevels quadrants = LevelsOf(corner);
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) {
        const int cell_row = row + r - 1, cell_col = col + c - 1;
        const bool on_board =
            cell_row >= 0 && cell_row < run_->view.size.rows && cell_col >= 0 && cell_col < run_->view.size.cols;
        int level = on_board ? cell_row * run_->view.size.cols + cell_col : ModelEquations::kNoLevel;
        if (on_board && run_->model.own_levels) level = quadrants[QuadrantOfColour(r, c)];
        run_->around.levels[static_cast<std::size_t>(corner)][static_cast<std::size_t>(4 * r + c)] = level;
      }
  }
}

void BoardFit::SetModelInput(int stride) {
  MovePixelsByLight();
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(run_->model.geometry);
  for (int i = 0; i < 9; ++i)
    run_->model_input.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  run_->model_input.edge_x = profiles_.Across(board_by_pixel.row(0));
  run_->model_input.edge_y = profiles_.Across(board_by_pixel.row(1));
  Terms::ForEach([&]<class Term>() {
    typename Term::Input& input = run_->model_input;
    input = {};
    if constexpr (requires { run_->model.Term::SetInput(run_->model.blur_px, stride > 1, input); })
      if (run_->model_input.terms.on<Term>()) run_->model.Term::SetInput(run_->model.blur_px, stride > 1, input);
  });
  run_->model_input.stride = stride;
}

void BoardFit::SetModelLanes() {
  model_lanes_.Reset(pixels_.lanes().padded(), ModelColumns(run_->model_input.terms).products());
  const Eigen::Matrix2d shading = HowLightSpreads().of_pixels;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    SetLanesOfTerms(corner, shading);
    SetLanesOfLevels(corner);
  }
}

void BoardFit::SetModelLane(int corner, int which, double value) {
  std::fill_n(model_lanes_.parameter_data(which) + pixels_.Lane(corner), 4, static_cast<float>(value));
}

void BoardFit::SetLanesOfTerms(int corner, const Eigen::Matrix2d& shading) {
  const CornerPlace& place = pixels_.place(corner);
  const Eigen::Matrix2d& by_pixel = place.board_by_pixel;
  const Eigen::Matrix2d lens = run_->model.blur_px * run_->model.blur_px * by_pixel * by_pixel.transpose();
  const Eigen::Vector2d way = by_pixel * run_->model.motion_px;
  TermCorner of_terms{.by_pixel = by_pixel,
                      .lens = lens,
                      .way = way * way.transpose() / 12,
                      .blur = lens,
                      .shading = by_pixel * shading * by_pixel.transpose(),
                      .size = run_->view.size,
                      .row = corner / (run_->view.size.cols - 1),
                      .col = corner % (run_->view.size.cols - 1)};
  Terms::ForEach([&]<class Term>() {
    const auto set_own = [&](int which, const auto& value) {
      if constexpr (std::is_same_v<decltype(value), const PhaseValues&>)
        std::copy_n(value.data(), 4, model_lanes_.parameter_data(ModelLanes::Of<Term>(which)) + pixels_.Lane(corner));
      else
        SetModelLane(corner, ModelLanes::Of<Term>(which), value);
    };
    if constexpr (Term::kLanes > 0)
      if (run_->model_input.terms.on<Term>()) run_->model.Term::SetLanes(run_->model_input, of_terms, set_own);
  });
  SetLanesOfBlur(corner, lens, of_terms.blur);
  const Eigen::Vector2d printed = Printed(corner);
  SetModelLane(corner, ModelLanes::kCornerX, printed.x());
  SetModelLane(corner, ModelLanes::kCornerY, printed.y());
  SetModelLane(corner, ModelLanes::kByPixelXx, by_pixel(0, 0));
  SetModelLane(corner, ModelLanes::kByPixelXy, by_pixel(0, 1));
  SetModelLane(corner, ModelLanes::kByPixelYx, by_pixel(1, 0));
  SetModelLane(corner, ModelLanes::kByPixelYy, by_pixel(1, 1));
  for (int axis = 0; axis < 2; ++axis) {
    const WindowEnds ends = run_->light.fades ? EndsOf(corner, axis) : WindowEnds{};
    SetModelLane(corner, ModelLanes::kFadeX + axis, ends.slope);
    SetModelLane(corner, ModelLanes::kMiddleX + axis, ends.middle());
    SetModelLane(corner, ModelLanes::kPeakX + axis, ends.peak());
  }
}

void BoardFit::SetLanesOfBlur(int corner, const Eigen::Matrix2d& lens, const Eigen::Matrix2d& blur) {
  for (int axis = 0; axis < 2; ++axis) {
    const double variance = blur(axis, axis);
    SetModelLane(corner, ModelLanes::kScaleX + axis, 1 / std::sqrt(variance));
    SetModelLane(corner, ModelLanes::kBlurX + axis, lens(axis, axis) / variance / run_->model.blur_px);
  }
  SetModelLane(corner, ModelLanes::kCovariance, blur(0, 1));
  const bool skewed = lens(0, 1) * lens(0, 1) > kSkewed * kSkewed * lens(0, 0) * lens(1, 1);
  SetModelLane(corner, ModelLanes::kSkew, skewed ? blur(0, 1) : 0);
  SetModelLane(corner, ModelLanes::kSkewByBlur, skewed ? 2 * lens(0, 1) / run_->model.blur_px : 0);
}

void BoardFit::SetLanesOfLevels(int corner) {
  const int lane = pixels_.Lane(corner), cols = run_->view.size.cols + 2;
  const int row = corner / (run_->view.size.cols - 1), col = corner % (run_->view.size.cols - 1);
  const bool by_yellow = MayBeOutOfRegister() && run_->inks.beside_yellow[static_cast<std::size_t>(corner)];
  for (std::size_t phase = 0; phase < 4; ++phase) {
    const std::size_t channel = static_cast<std::size_t>(run_->view.channel_of_phase[phase]);
    const auto set = [&](int which, float value) {
      model_lanes_.parameter_data(which)[lane + static_cast<int>(phase)] = value;
    };
    set(ModelLanes::kNoiseFloor,
        run_->model.noise.floor[channel] + (by_yellow ? run_->inks.yellow_variance[phase] : 0));
    set(ModelLanes::kNoiseSlope, run_->model.noise.slope[channel]);
    for (int i = 0; i < ModelColumns::kLevels; ++i) {
      const int level = run_->around.levels[static_cast<std::size_t>(corner)][static_cast<std::size_t>(i)];
      set(ModelLanes::kLevel00 + i,
          level != ModelEquations::kNoLevel
              ? run_->model.levels[static_cast<std::size_t>(level)][phase]
              : run_->around.beside[static_cast<std::size_t>((row + i / 4) * cols + col + i % 4)][phase]);
    }
  }
}

}  // namespace chequer
