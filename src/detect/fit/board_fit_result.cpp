// Of BoardFit: what a fit that has ended tells of the board.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/small_cholesky.h"
#include "detect/common/widened.h"
#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Of ways of more than a cell, little of the cells is left in the pixels, and some fits are off by more than the
/// pixels' noise tells: those whose corners lie farther off the plane than that, px (measured: 0.015 of most, 0.03 of
/// these).
constexpr double kLongMotionCells = 1, kOffLongMotionPx = 0.016;
/// Ways of a blur's shape, cells, that the next frame's fit may begin with (measured: with .45, poses of fast boards
/// with and without memory differ by .10 instead of .085 deviations).
constexpr double kShortWay = 0.4;
/// A bend of the paper is fitted where it explains so many standard deviations of the corners' places: of flat boards,
/// chance makes three unknowns explain as much once in 6,000. Fewer corners do not tell it from a tilt.
constexpr double kLeastBend = 4.5;
constexpr int kFewestOfBend = 12;
/// Corners that are off by no more than noise tell of no bend: most boards are not asked. (Of flat boards one in eight
/// is; a bend that explains so much makes the corners of a board of 25 as far off.)
constexpr double kOffByBend = 1.25;

}  // namespace

SeenCorner BoardFit::SeenAt(const ShiftedCorner& corner) const {
  // Pixels whose coordinates are too small by the shift show the corner where coordinates are that much smaller.
  const BoardGeometry::Local seen = pixels_.SeenAt(run_->model.geometry, corner.board - corner.shift);
  const Eigen::Matrix2d board_by_plane = seen.plane_by_board.inverse();
  return {corner.board, seen.plane, board_by_plane.transpose() * corner.information * board_by_plane};
}

bool BoardFit::TellsOfBend(const Lens& lens) const {
  // What inks, a rolling shutter and some of the pixels leave of the corners' places is not the paper's.
  return !run_->bend.turns_over_rows && !MayBeOutOfRegister() && lens.calibrated() &&
         static_cast<int>(shifted_.size()) >= kFewestOfBend && !run_->terms.rough;
}

double BoardFit::ShareOfShiftsSeen() const {
  double alone = 0;
  for (const ShiftedCorner& corner : shifted_) alone += corner.information(0, 0) + corner.information(1, 1);
  const auto seen = [](const auto& normal) { return normal(0, 0) + normal(3, 3); };
  return (run_->terms.look_farther ? seen(model_equations_.information()) : seen(equations_.normal())) / alone;
}

void BoardFit::TellBendCorners(double pixel_variance) {
  const double seen = ShareOfShiftsSeen();
  std::vector<ShiftedCorner>& corners = run_->result.bend.corners;
  corners = shifted_;
  for (ShiftedCorner& corner : corners) {
    corner.shift *= 1 / seen;
    corner.information *= seen / pixel_variance;
  }
}

std::optional<BentPaper> BoardFit::FindBend(const Lens& lens) const {
  const std::vector<ShiftedCorner>& corners = run_->result.bend.corners;
  if (corners.empty() || (!run_->bend.taken_out && run_->told.unexplained_shifts < kOffByBend)) return std::nullopt;
  const BoardView view{run_->model.geometry, lens.focal(), run_->view.cell_ratio,
                       run_->bend.taken_out ? &*run_->bend.taken_out : nullptr};
  const LeastBend least{.times = kLeastBend * kLeastBend};
  if (!MayBeBent(view, corners, least)) return std::nullopt;
  std::array<SeenCorner, kMaxCorners> seen;
  std::transform(corners.begin(), corners.end(), seen.begin(),
                 [&](const ShiftedCorner& corner) { return SeenAt(corner); });
  return FindBentPaper(view, std::span(seen).first(corners.size()), least);
}

double BoardFit::SumOfUsed(int which) const {
  Eigen::Array4f of_phases = Eigen::Array4f::Zero();
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    if (used(corner))
      of_phases += Eigen::Map<const Eigen::Array4f>(pixels_.lanes().sum_data(which) + pixels_.Lane(corner));
  return double{of_phases.sum()};
}

void BoardFit::SumPixels() {
  const LaneBlock& lanes = pixels_.lanes();
  const int stride = run_->terms.look_farther ? run_->model_input.stride : run_->plain_input.stride;
  // Four lanes of a corner side by side.
  using Phases = Eigen::Array4f;
  Phases square = Phases::Zero(), count = Phases::Zero();
  run_->result.explained = {};
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner)) continue;
    const int lane = pixels_.Lane(corner);
    const float* const of_corner = lanes.sum_data(0) + lane;
    const auto sum = [&](int which) { return Eigen::Map<const Phases>(of_corner + which * lanes.padded()); };
    const Phases fits = sum(kDarkCount) + sum(kLightCount);
    Explained::Corner& explained = run_->result.explained.corners[static_cast<std::size_t>(corner)];
    explained.pixels = stride == 1 ? static_cast<float>(pixels_.pixels(corner)) : 0;
    for (int phase = 0; phase < 4 && stride != 1; ++phase)
      explained.pixels += static_cast<float>(lanes.Visited(lane + phase, stride));
    explained.fits = fits.sum();
    if (!used(corner)) {
      const float squares = sum(ProductSum(kResidual, kResidual)).sum(), weights = sum(kWeight).sum();
      explained.own_deviation = std::sqrt(std::max(squares, 1e-9f) / std::max(weights, 1e-9f));
      continue;
    }
    square += sum(kDarkSquare) + sum(kLightSquare);
    count += fits;
  }
  const double of_fit = double{square.sum()} / std::max(double{count.sum()}, 1.0);
  run_->result.explained.deviation = std::max(std::sqrt(of_fit), 1e-6);
}

BoardFit::ShiftSums BoardFit::TellShifts() {
  ShiftSums sums;
  shifted_.clear();
  FindPlainShifts();
  run_->result.visibility = run_->visibility;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const std::size_t i = static_cast<std::size_t>(corner);
    run_->told.misfit[i] = MisfitOf(corner);
    if (!used(corner)) continue;
    const auto [information, gradient] = ShiftOf(corner);
    const double determinant = information.determinant();
    if (!(determinant > 0)) {
      run_->result.visibility.Set(corner, Hidden::kFlat);
      continue;
    }
    // What is left of the corner's own shift after the last step.
    const Eigen::Vector2d shift = Eigen::Vector2d(information(1, 1) * gradient[0] - information(0, 1) * gradient[1],
                                                  information(0, 0) * gradient[1] - information(1, 0) * gradient[0]) /
                                  determinant;
    shifted_.push_back({corner, pixels_.place(corner).board, shift, information});
    sums.square_px += (pixels_.place(corner).pixel_by_board * shift).squaredNorm();
    sums.chi_square += shift.dot(gradient);
    sums.contrast += LightAt(corner) * Contrast(corner);
  }
  run_->result.visibility.ShowCellsByAnyCorner();
  return sums;
}

void BoardFit::Finish(const Lens& lens) {
  if (run_->told.sums_gone) return;  // by them, it was finished before
  run_->result.geometry = run_->model.geometry;
  SumPixels();
  ShiftSums shifts = TellShifts();
  const double n = std::max(run_->result.corners_used(), 1);
  const double unknowns =
      (run_->terms.look_farther ? ModelColumns(run_->model_input.terms).shared : BoardEquations::kUnknowns) +
      run_->view.channels * LevelCount(run_->view.size, run_->model.own_levels);
  const double chi_square =
      run_->terms.look_farther ? model_equations_.chi_square() : equations_.chi_square() - run_->step.gain;
  const double pixel_variance = std::max(chi_square / std::max(WeightUsed() - unknowns, 1.0), 1e-9);
  // Edges that lie where no homography puts them (paper that is not flat, print, what is left of the lens's distortion)
  // move all pixels along them alike: the noise of pixels does not tell, the corners' own shifts do.
  double shift_variance = shifts.chi_square / std::max(2 * n - BoardGeometry::kParameters, 1.0);
  run_->told.unexplained_shifts = shift_variance / pixel_variance;
  run_->result.bend.corners.clear();
  if (TellsOfBend(lens)) TellBendCorners(pixel_variance);
  run_->bend.found = FindBend(lens);
  if (const std::optional<BentPaper>& bent = run_->bend.found) {
    std::vector<ShiftedCorner>& corners = run_->result.bend.corners;
    shifts.square_px *= std::min(pixel_variance * bent->left() / std::max(shifts.chi_square, 1e-9), 1.0);
    shift_variance = pixel_variance * VarianceOfShifts(bent->left(), corners.size(), BentPaper::kUnknowns);
    corners.clear();
  }
  const double variance = std::max({pixel_variance, shift_variance, MayBeOutOfRegister() ? 1 : 1e-9});
  run_->result.reprojection_rms_px = std::sqrt(shifts.square_px / n);
  run_->told.pixel_variance = pixel_variance;
  run_->told.variance = variance;
  run_->result.bend.flat_variance = variance / pixel_variance;
  TellEdgeTally();
  TellInformation(InformationOnMoves(), variance);
  run_->result.image = {run_->model.noise, run_->model.blur_px, run_->model.edges, run_->model.motion_px,
                        GainForOthers()};
  run_->result.motion =
      run_->terms.look_farther ? BlurShape{run_->model.motion_px, run_->model.turn} : run_->model.blur_shape;
  // A fit that begins with a long way might not ask whether the motion's own term is better.
  const bool short_way = run_->model.blur_shape.way_px.norm() < kShortWay * CellPx();
  run_->result.blur_shape = short_way && !run_->terms.look_farther ? run_->model.blur_shape : BlurShape{};
  Explained& explained = run_->result.explained;
  explained.unknowns = unknowns;
  explained.contrast = shifts.contrast / n;
  run_->result.signal_to_noise = explained.contrast / explained.deviation;
  run_->told.cell_px = CellPx();
  TellLevels();
}

void BoardFit::TellInformation(const BoardGeometry::Information& in_pixels, double variance) {
  FittedBoard& result = run_->result;
  BoardGeometry::Information of_moves = in_pixels / variance;
  if (const std::optional<BentPaper>& bent = run_->bend.found) {
    result.geometry = bent->middle();
    of_moves = Widened<3>(of_moves, std::sqrt(variance / run_->told.pixel_variance) * bent->uncertain());
  }
  if (run_->light.shading.size() > 0 || run_->model.shaded) of_moves = Widened<2>(of_moves, MovedByShading());
  if (run_->model.shadow) of_moves = Widened<1>(of_moves, MovedByShadow(in_pixels));
  of_moves = CountAlongEdges(in_pixels, of_moves);
  const double off_px = result.reprojection_rms_px / kOffLongMotionPx;
  if (run_->model.motion_px.norm() > kLongMotionCells * CellPx()) of_moves /= std::max(off_px * off_px, 1.0);
  // What is left of a shadow moves the corners along its edge alike: measured, errors grow by as much again.
  if (run_->model.own_levels) of_moves /= std::max(run_->told.unexplained_shifts, 1.0);
  if (MayBeOutOfRegister()) of_moves = TellRegister(of_moves, variance);
  result.information = result.geometry.FromMoves(of_moves);
}

BoardGeometry::Information BoardFit::InformationOnMoves() const {
  if (run_->terms.look_farther) return model_equations_.InformationOnMoves();
  // The blur follows the geometry.
  constexpr int kMoves = BoardGeometry::kParameters;
  const BoardEquations::Matrix& normal = equations_.normal();
  const BoardGeometry::Parameters by_blur = normal.col(kMoves).head<kMoves>();
  return normal.topLeftCorner<kMoves, kMoves>() - by_blur * by_blur.transpose() / normal(kMoves, kMoves);
}

void BoardFit::FindPlainShifts() {
  if (!run_->terms.look_farther) equations_.FindShifts(PlainEquations(), run_->step.moves, plain_shifts_);
}

ModelEquations::CornerShift BoardFit::ShiftOf(int corner) const {
  ModelEquations::CornerShift shift;
  if (run_->terms.look_farther) {
    shift = model_equations_.ShiftOf(EquationsOfModel(), corner);
  } else {
    const BoardEquations::CornerShift& of = plain_shifts_[static_cast<std::size_t>(corner)];
    shift.information << of.xx, of.xy, of.xy, of.yy;
    shift.gradient = {of.x, of.y};
  }
  if (MayBeOutOfRegister()) shift.gradient -= shift.information * ShiftByInks(corner);
  return shift;
}

}  // namespace chequer
