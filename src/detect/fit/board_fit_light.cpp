// Of BoardFit: what is done to the pixels' light before they are fitted.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <optional>

#include "core/small_cholesky.h"
#include "detect/fit/board_fit.h"
#include "detect/fit/shading.h"

namespace chequer {
namespace {

/// No pixel is brightened more.
constexpr double kLeastShading = 0.02;
/// In larger cells weak light counts, too: a vignetting of a tenth makes a board of 40 px cells seem 3e-5 smaller,
/// three standard deviations.
constexpr double kFineCellPx = 12;
/// Under one that changes less, per cell, a veil moves a board by less than a fifth of its deviation (reckoned: dark
/// cells that seem to fall off as well, under a quarter of white, of 10 px).
constexpr double kSteepUnderVeil = 0.006;
/// The slope of a shadow at a corner is the difference between points this far to either side of it, cells. Its pixels
/// reach about as far.
constexpr double kAcrossCorner = 0.25;
/// Less is nothing: it moves a pose by a thousandth of its deviation.
constexpr double kNoShading = 1e-5;
/// A shading that was told from levels as they were sampled, and that the fit's tell otherwise, counts where it moves
/// the board by so many standard deviations (measured: with twice and with half as much, poses of knocked frames agree
/// as well).
constexpr double kOtherShading = 0.05;
/// Of these, twice: the levels of cells in uneven light are not quite those of their middles.
constexpr double kTwiceCellPx = 24;

/// How much the light changes at most, per cell, on a board.
double MostChange(const Shading& shading, MarkerSize size) {
  double most = 0;
  for (const double y : {-0.5, 0.5}) {
    const Eigen::Vector2d change = shading.SlopeAt({0.5 * size.cols, y * size.rows});
    // At the opposite rim, the bend changes it by as much the other way.
    most = std::max({most, change.norm(), (2 * shading.slope - change).norm()});
  }
  return most;
}

/// The quadratic form of a bend of x², xy and y².
Eigen::Matrix2d FormOf(const Eigen::Vector3d& bend) {
  return (Eigen::Matrix2d() << bend[0], bend[1] / 2, bend[1] / 2, bend[2]).finished();
}

/// The light's second order, from the board to the plane.
Eigen::Matrix2d BendOnPlane(const Eigen::Vector3d& bend, const Eigen::Matrix2d& board_by_plane) {
  return board_by_plane.transpose() * FormOf(bend) * board_by_plane;
}

/// @param slope per plane unit, @param bend as BendOnPlane() has it.
LightFall FallOf(const Eigen::Vector2d& slope, const Eigen::Matrix2d& bend) {
  const auto value = [](double of) { return static_cast<float>(of); };
  return {value(slope.x()), value(slope.y()), value(bend(0, 0)), value(2 * bend(0, 1)), value(bend(1, 1))};
}

/// How a shading moves a board whose light spreads so far, cells. @param slope, bend of the light's logarithm.
BoardGeometry::Parameters MoveByShading(const BoardGeometry& geometry, const Eigen::Matrix2d& spread,
                                        const Eigen::Vector2d& slope, const Eigen::Vector3d& bend) {
  const Eigen::Matrix2d board_by_plane = geometry.PlaneByBoard({0, 0}).inverse(),
                        by_slope = board_by_plane * spread * board_by_plane.transpose();
  const Eigen::Vector2d middle = by_slope * slope;
  const Eigen::Matrix2d grows = 2 * by_slope * FormOf(bend);
  return {middle.x(), grows(0, 0), grows(0, 1), middle.y(), grows(1, 0), grows(1, 1), 0, 0};
}

}  // namespace

BoardFit::SpreadOfLight BoardFit::HowLightSpreads() const {
  const BoardModel& model = run_->model;
  const bool is_term = !model.motion_px.isZero();
  const Eigen::Vector2d& way = is_term ? model.motion_px : model.blur_shape.way_px;
  const Eigen::Matrix2d half_motion = way * way.transpose() / 24;
  // The plain model's blur includes half of the way's variance, as the mean over all directions.
  const double lens = model.blur_px * model.blur_px - (is_term ? 0 : way.squaredNorm() / 24);
  const Eigen::Matrix2d half_lens = Eigen::Vector2d(0, lens / 2).asDiagonal();
  return {lens * Eigen::Matrix2d::Identity() - half_lens + half_motion, {half_motion, half_lens}};
}

Eigen::Matrix<double, BoardGeometry::kParameters, 2> BoardFit::MovedByShading() const {
  const SpreadOfLight spread = HowLightSpreads();
  const Eigen::Vector2d slope = run_->light.taken_out.slope + run_->model.grows;
  Eigen::Matrix<double, BoardGeometry::kParameters, 2> moved;
  for (int way = 0; way < 2; ++way)
    moved.col(way) = MoveByShading(run_->model.geometry, spread.uncertain[static_cast<std::size_t>(way)], slope,
                                   run_->light.taken_out.bend);
  return moved;
}

BoardGeometry::Parameters BoardFit::MovedByShadow(const BoardGeometry::Information& in_pixels) const {
  const Eigen::Matrix2d spread = HowLightSpreads().uncertain[0];  // that of motion
  const auto log_light = [&](const Eigen::Vector2d& board) {
    return std::log(std::max(run_->model.LightAt(board).share, kLeastShading));
  };
  BoardGeometry::Parameters pull = BoardGeometry::Parameters::Zero();
  for (const ShiftedCorner& corner : shifted_) {
    const Eigen::Matrix2d& by_pixel = pixels_.place(corner.corner).board_by_pixel;
    const auto slope_along = [&](const Eigen::Vector2d& step) {
      return (log_light(corner.board + step) - log_light(corner.board - step)) / (2 * kAcrossCorner);
    };
    const Eigen::Vector2d slope(slope_along({kAcrossCorner, 0}), slope_along({0, kAcrossCorner}));
    const Eigen::Vector2d by_shift = corner.information * (by_pixel * spread * by_pixel.transpose() * slope);
    const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner.corner)];
    pull += by.x * by_shift.x() + by.y * by_shift.y();
  }
  return InverseOf(in_pixels) * pull;
}

void BoardFit::MovePixelsByLight() {
  if (run_->light.shading.size() == 0) return;
  const Shading& light = run_->light.taken_out;
  const Eigen::Matrix2d spread = HowLightSpreads().of_pixels,
                        board_by_plane = run_->model.geometry.PlaneByBoard({0, 0}).inverse();
  pixels_.SetMove(spread * (board_by_plane.transpose() * light.slope),
                  2 * spread * BendOnPlane(light.bend, board_by_plane));
}

void BoardFit::EvenOutPixels(const Shading& even) {
  const Eigen::Matrix2d spread = HowLightSpreads().of_pixels;
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(run_->model.geometry);
  const Eigen::Matrix2d board_by_plane = run_->model.geometry.PlaneByBoard({0, 0}).inverse().transpose();
  // MovePixelsByLight() has what is linear in the place.
  const Shading linear{even.slope, even.BendOfLogarithm(), false};
  LaneBlock& lanes = pixels_.lanes();
  for (int lane = 0; lane < lanes.lanes(); ++lane)
    for (int i = 0; i < lanes.count(lane); ++i) {
      const std::size_t at = lanes.Place(lane, i);
      float &u = lanes.u_data()[at], &v = lanes.v_data()[at], &light = lanes.light_data()[at];
      const Eigen::Vector2d board = (board_from_plane * Eigen::Vector3d(u, v, 1)).hnormalized();
      const double share = std::max(even.At(board), kLeastShading);
      // Negative: a saturated one (see MarkSaturated()).
      const float of_phase = run_->light.veil[static_cast<std::size_t>(lane & 3)],
                  over = std::signbit(light) ? -of_phase : of_phase;
      light = over + (light - over) / static_cast<float>(share);
      const Eigen::Vector2d shift = spread * (board_by_plane * (even.SlopeAt(board) / share - linear.SlopeAt(board)));
      u += static_cast<float>(shift.x());
      v += static_cast<float>(shift.y());
    }
}

double BoardFit::LightAt(int corner) const { return run_->model.LightAt(pixels_.place(corner).board).share; }

std::optional<Shading> BoardFit::ShadingOfLevels(const Start& start, LevelsFrom from) {
  if (run_->model.own_levels || run_->model.LightVaries()) return std::nullopt;
  const double cell_px = CellPx();
  run_->light.shade_twice = cell_px > kTwiceCellPx;
  PhaseValues& veil = run_->light.veil;
  if (run_->light.shading.size() == 0) veil = {};
  ShadedCells cells{.size = run_->view.size,
                    .levels = run_->model.levels,
                    .saturated = start.saturated,
                    .hidden = run_->visibility.cells(),
                    .phases = run_->view.channels == 3 ? 4 : 1,
                    .blue_phase = run_->view.channels == 3 ? 3 - run_->view.red_phase : -1,
                    .fine = cell_px > kFineCellPx,
                    .from = from,
                    .veil = veil,
                    .before = run_->light.taken_out};
  std::optional<Shading> shading = FindShading(cells);
  // Levels tell of a veil as long as no light was taken out.
  if (shading && run_->light.shading.size() == 0 && shading->slope.norm() > kSteepUnderVeil) {
    cells.veil = veil = FindVeil(cells, *shading);
    if (veil != PhaseValues{}) shading = FindShading(cells);
  }
  if (shading && MostChange(*shading, run_->view.size) < kNoShading) return std::nullopt;
  return shading;
}

std::optional<Shading> BoardFit::EvenOutShading(const Start& start, LevelsFrom from) {
  const std::optional<Shading> shading = ShadingOfLevels(start, from);
  if (!shading) return std::nullopt;
  const PhaseValues& veil = run_->light.veil;
  run_->light.bent |= shading->bent;
  pixels_.PrepareChange();
  // Taken out of every pixel; levels then are those in the light of the board's centre.
  const Eigen::Matrix2d board_by_plane = run_->model.geometry.PlaneByBoard({0, 0}).inverse();
  run_->light.taken_out.slope += shading->slope;
  run_->light.taken_out.bend += shading->BendOfLogarithm();
  if (shading->bent) {
    EvenOutPixels(*shading);
  } else {
    const Eigen::Vector2d slope = board_by_plane.transpose() * shading->slope;
    EvenOutLanes(FallOf(slope, BendOnPlane(shading->bend, board_by_plane)), veil, pixels_.lanes());
  }
  if (run_->light.shading.size() == 0) run_->light.shading.Assign(run_->model.levels.size(), 1);
  for (std::size_t cell = 0; cell < run_->model.levels.size(); ++cell) {
    const float share = static_cast<float>(shading->At(MiddleOfCell(run_->view.size, static_cast<int>(cell))));
    run_->light.shading[cell] *= share;
    for (std::size_t phase = 0; phase < 4; ++phase) {
      float& level = run_->model.levels[cell][phase];
      level = veil[phase] + (level - veil[phase]) / share;
    }
  }
  return shading;
}

bool BoardFit::ShadingHolds(const Start& start, double variances, LevelsFrom from) {
  if (run_->light.shading.size() == 0) return true;
  const std::optional<Shading> change = EvenOutShading(start, from);
  if (!change) return true;
  const BoardGeometry::Parameters move =
      MoveByShading(run_->model.geometry, HowLightSpreads().of_pixels, change->slope, change->BendOfLogarithm());
  return move.dot(InformationOnMoves() * move) < kOtherShading * kOtherShading * variances;
}

void BoardFit::FollowShading(const Lens& lens, const Start& start) {
  // Cells that turn out to be occluded have falsified it.
  if (run_->visibility.ShowCellsByAllCorners()) TakeBackFromPixels(lens);
  EvenOutShading(start);
}

bool BoardFit::TakeBackFromPixels(const Lens& lens) {
  if (!TakeBackShading()) return false;
  pixels_.Reuse(lens, run_->model.geometry);
  SetPlaces();
  return true;
}

bool BoardFit::TakeBackShading() {
  if (run_->light.shading.size() == 0) return false;
  Shade(run_->model.levels, run_->light.shading, run_->light.veil);
  run_->light.shading.Assign(0, 1);
  run_->light.bent = false;
  run_->light.taken_out = {};
  return true;
}

double BoardFit::FarthestMove(const BoardGeometry& from) const {
  double farthest = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const CornerPlace& place = pixels_.place(corner);
    if (!place.inside) continue;
    const Eigen::Vector2d move = run_->model.geometry.ToPlane(place.board) - from.ToPlane(place.board);
    farthest = std::max(farthest, (place.plane_by_pixel.inverse() * move).norm());
  }
  return farthest;
}

}  // namespace chequer
