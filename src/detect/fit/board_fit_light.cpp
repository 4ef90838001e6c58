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
/// Of larger cells the light's bend is taken out too: a vignetting of a tenth makes a board of 40 px cells seem 3e-5
/// smaller, three standard deviations; in small cells it does not count.
constexpr double kFineCellPx = 12;
/// In others, a shading that changes less, per cell, is left alone: it moves a pose by less than a fifth of its
/// deviation (of 10 px cells blurred by 0.8 px, edges by 0.002 px). Told from few levels, it would move it as much by
/// its noise, otherwise in each frame (measured: poses with and without memory differed by 0.13 instead of 0.09
/// deviations). Of stronger ones the same is left out in part, so that one that is as strong does not decide by its
/// noise (measured: with and without memory, poses of knocked frames differ by 0.35 instead of 0.40 deviations).
constexpr double kWeakShading = 0.003;
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

/// What counts of a slope, as estimates are shrunk (James and Stein): nothing of a weak one, nearly all of a strong
/// one, and what lies between changes steadily.
Eigen::Vector2d Shrunk(const Eigen::Vector2d& slope) {
  const double square = slope.squaredNorm(), weak = kWeakShading * kWeakShading;
  return square > weak ? Eigen::Vector2d((1 - weak / square) * slope) : Eigen::Vector2d::Zero();
}

/// @param slope per plane unit, @param bend of x², xy and y² on the board.
LightFall FallOf(const Eigen::Vector2d& slope, const Eigen::Vector3d& bend, const Eigen::Matrix2d& board_by_plane) {
  const Eigen::Matrix2d square = (Eigen::Matrix2d() << bend[0], bend[1] / 2, bend[1] / 2, bend[2]).finished();
  const Eigen::Matrix2d per_plane = board_by_plane.transpose() * square * board_by_plane;
  const auto value = [](double of) { return static_cast<float>(of); };
  return {value(slope.x()), value(slope.y()), value(per_plane(0, 0)), value(2 * per_plane(0, 1)),
          value(per_plane(1, 1))};
}

/// How a shading moves a board whose light spreads so far. @param slope of the light's logarithm, a cell.
BoardGeometry::Parameters MoveBySlope(const BoardGeometry& geometry, const Eigen::Matrix2d& spread,
                                      const Eigen::Vector2d& slope) {
  const Eigen::Matrix2d board_by_plane = geometry.PlaneByBoard({0, 0}).inverse();
  const Eigen::Vector2d per_px = board_by_plane.transpose() * slope, cells = board_by_plane * (spread * per_px);
  BoardGeometry::Parameters move = BoardGeometry::Parameters::Zero();
  move[0] = cells.x(), move[3] = cells.y();
  return move;
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
  const Eigen::Vector2d slope = run_->light.slope + run_->model.grows;
  Eigen::Matrix<double, BoardGeometry::kParameters, 2> moved;
  for (int way = 0; way < 2; ++way)
    moved.col(way) = MoveBySlope(run_->model.geometry, spread.uncertain[static_cast<std::size_t>(way)], slope);
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

void BoardFit::EvenOutPixels(const Shading& even, const Eigen::Matrix2d& spread) {
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(run_->model.geometry);
  const Eigen::Matrix2d board_by_plane = run_->model.geometry.PlaneByBoard({0, 0}).inverse().transpose();
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
      const Eigen::Vector2d shift = spread * (board_by_plane * even.SlopeAt(board)) / share;
      u += static_cast<float>(shift.x());
      v += static_cast<float>(shift.y());
    }
}

double BoardFit::LightAt(int corner) const { return run_->model.LightAt(pixels_.place(corner).board).share; }

std::optional<Shading> BoardFit::ShadingOfLevels(const Start& start) {
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
                    .veil = veil};
  std::optional<Shading> shading = FindShading(cells);
  // Levels tell of a veil as long as no light was taken out.
  if (shading && run_->light.shading.size() == 0 && shading->slope.norm() > kSteepUnderVeil) {
    cells.veil = veil = FindVeil(cells, *shading);
    if (veil != PhaseValues{}) shading = FindShading(cells);
  }
  if (!shading || cell_px > kFineCellPx) return shading;
  const bool bends = !shading->bend.isZero();
  // Of all of it, whatever was taken out before: else what counts would depend on the order.
  if (!bends) shading->slope = Shrunk(run_->light.slope + shading->slope) - run_->light.slope;
  if (shading->slope.norm() < (bends ? kWeakShading : kNoShading)) return std::nullopt;
  return shading;
}

Eigen::Vector2d BoardFit::EvenOutShading(const Start& start) {
  const std::optional<Shading> shading = ShadingOfLevels(start);
  if (!shading) return Eigen::Vector2d::Zero();
  const PhaseValues& veil = run_->light.veil;
  run_->light.bent |= shading->bent;
  pixels_.PrepareChange();
  // Taken out of every pixel; levels then are those in the light of the board's centre. As the lens blurs what is
  // already shaded, more light comes to a pixel from its lighter side: it shows what lies σ² ∇log(light) away.
  const SpreadOfLight spread = HowLightSpreads();
  const Eigen::Matrix2d board_by_plane = run_->model.geometry.PlaneByBoard({0, 0}).inverse();
  const Eigen::Vector2d per_px = board_by_plane.transpose() * shading->slope;
  run_->light.slope += shading->slope;
  if (shading->bent) {
    EvenOutPixels(*shading, spread.of_pixels);
  } else {
    pixels_.MoveOrigin(spread.of_pixels * per_px);
    EvenOutLanes(FallOf(per_px, shading->bend, board_by_plane), veil, pixels_.lanes());
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
  return shading->slope;
}

bool BoardFit::ShadingHolds(const Start& start, double variances) {
  if (run_->light.shading.size() == 0) return true;
  const Eigen::Vector2d change = EvenOutShading(start);
  if (change.isZero()) return true;
  const BoardGeometry::Parameters move = MoveBySlope(run_->model.geometry, HowLightSpreads().of_pixels, change);
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
  run_->light.slope.setZero();
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
