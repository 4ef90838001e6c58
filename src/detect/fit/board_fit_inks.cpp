// Of BoardFit: inks that lie out of register (ink_register.h).
#include <algorithm>

#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Variance of pixels beside yellow cells, over that of a shift by the ink's offset where yellow ends and paper begins.
/// All pixels of an edge err alike, but only where ink and black leave a gap. Measured: with 0.25 squared errors over
/// the covariance are 1.9, with 1 they are 1 of positions and 0.4 of rotations.
constexpr float kYellowVariance = 0.6f;

}  // namespace

void BoardFit::WeighYellow(const Start& start) {
  // Sums of the light cells' levels, without the ink and with it.
  std::array<PhaseValues, 2> light{};
  std::array<float, 2> count{};
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const QuadrantLevels around = LevelsOf(corner), cells = CellsAround(run_->view.size, corner);
    run_->inks.beside_yellow[static_cast<std::size_t>(corner)] = false;
    for (std::size_t i = 0; i < 4; ++i) {
      if (IsDark(cells[i] / run_->view.size.cols, cells[i] % run_->view.size.cols)) continue;
      const std::size_t ink = start.saturated[static_cast<std::size_t>(cells[i])] != 0 ? 1 : 0;
      if (ink == 1) run_->inks.beside_yellow[static_cast<std::size_t>(corner)] = true;
      for (std::size_t phase = 0; phase < 4; ++phase)
        light[ink][phase] += run_->model.levels[static_cast<std::size_t>(around[i])][phase];
      ++count[ink];
    }
  }
  const float off_px = static_cast<float>(run_->inks.register_cells.mean() * CellPx());
  for (std::size_t phase = 0; phase < 4; ++phase) {
    const float differ = count[0] > 0 && count[1] > 0 ? light[0][phase] / count[0] - light[1][phase] / count[1] : 0;
    run_->inks.yellow_variance[phase] = kYellowVariance * off_px * off_px * differ * differ;
  }
}

void BoardFit::ShareInks(const Start& start) {
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const QuadrantLevels around = LevelsOf(corner), cells = CellsAround(run_->view.size, corner);
    const auto is_dark = [&](std::size_t i) {
      return IsDark(cells[i] / run_->view.size.cols, cells[i] % run_->view.size.cols);
    };
    // Information on the place of the edge between two of the cells, and which share of it is the blue ink's.
    double all[2] = {}, blue[2] = {};
    for (int axis = 0; axis < 2; ++axis)
      for (std::size_t side = 0; side < 2; ++side) {
        const std::size_t one = axis == 0 ? 2 * side : side, other = one + (axis == 0 ? 1 : 2),
                          dark = is_dark(one) ? one : other;
        // Of an edge that runs to the board's rim, more shows.
        const double middle = pixels_.place(corner).middle[1 - axis],
                     length = 0.5 + 2 * std::max(side == 0 ? -middle : middle, 0.0);
        double information = 1e-9;
        for (std::size_t phase = 0; phase < 4; ++phase) {
          const float a = run_->model.levels[static_cast<std::size_t>(around[one])][phase],
                      b = run_->model.levels[static_cast<std::size_t>(around[other])][phase];
          const std::size_t channel = static_cast<std::size_t>(run_->view.channel_of_phase[phase]);
          const float variance = run_->model.noise.floor[channel] + run_->model.noise.slope[channel] * (a + b) / 2;
          information += length * double{(a - b) * (a - b) / std::max(variance, 1e-9f)};
        }
        all[axis] += information;
        if (start.saturated[static_cast<std::size_t>(cells[dark])] != 0) blue[axis] += information;
      }
    run_->inks.blue_shares[static_cast<std::size_t>(corner)] =
        Eigen::Vector2d(blue[0] / all[0], blue[1] / all[1]).cast<float>();
  }
}

Eigen::Vector2d BoardFit::Printed(int corner) const {
  const Eigen::Vector2d& board = pixels_.place(corner).board;
  if (!MayBeOutOfRegister()) return board;
  return board +
         run_->inks.blue_shares[static_cast<std::size_t>(corner)].cast<double>().cwiseProduct(run_->model.blue_offset);
}

Eigen::Vector2d BoardFit::ShiftByInks(int corner) const {
  const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
  const InkRegister::Step& step = run_->step.inks;
  return Eigen::Vector2d(by.x.dot(step.moves), by.y.dot(step.moves)) -
         run_->inks.blue_shares[static_cast<std::size_t>(corner)].cast<double>().cwiseProduct(step.offset);
}

InkRegister BoardFit::RegisterOfCorners() const {
  InkRegister inks;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!used(corner)) continue;
    const auto [information, gradient] = ShiftOf(corner);
    inks.Add({.by = &derivatives_[static_cast<std::size_t>(corner)],
              .share = run_->inks.blue_shares[static_cast<std::size_t>(corner)].cast<double>(),
              .information = information,
              .gradient = gradient});
  }
  return inks;
}

void BoardFit::MoveInks(const Start& start) {
  ShareInks(start);
  WeighYellow(start);
  FindPlainShifts();
  run_->step.inks = RegisterOfCorners().Solve(run_->model.blue_offset, run_->inks.register_cells);
  run_->model.geometry.MoveCoordinates(run_->step.inks.moves);
  run_->model.blue_offset += run_->step.inks.offset;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const Eigen::Matrix2d& pixel_by_board = pixels_.place(corner).pixel_by_board;
    const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
    const Eigen::Vector2d move(by.x.dot(run_->step.inks.moves), by.y.dot(run_->step.inks.moves));
    run_->step.corner_px = std::max({run_->step.corner_px, (pixel_by_board * (MoveOf(corner) + move)).norm(),
                                     (pixel_by_board * run_->step.inks.offset).norm()});
  }
  SetPlaces();
}

BoardGeometry::Information BoardFit::TellRegister(const BoardGeometry::Information& of_moves, double variance) {
  InkRegister inks = RegisterOfCorners();
  inks.Scale(1 / variance);
  const InkRegister::Known known = inks.After(of_moves, run_->inks.register_cells);
  // Of the parameters, to first order.
  constexpr double kStep = 1e-4;
  for (int axis = 0; axis < 2; ++axis) {
    BoardGeometry moved = run_->model.geometry;
    moved.MoveCoordinates(kStep * known.by_prior.col(axis));
    run_->result.by_register.col(axis) = (moved.parameters() - run_->model.geometry.parameters()) / kStep;
  }
  return known.information;
}

}  // namespace chequer
