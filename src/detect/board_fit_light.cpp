// Of BoardFit: what is done to the pixels' light before they are fitted.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "detect/board_fit.h"
#include "detect/shading.h"

namespace chequer {
namespace {

/// No pixel is brightened more.
constexpr double kLeastShading = 0.02;
/// A first step that is shorter has other reasons: of a spread of half a pixel it is 0.29 px, of motion or noise 0.01.
constexpr double kLeastInkSpreadPx = 0.1;
/// Less of a cell pulls no pose, and edges drawn without a lens's blur may look so much off.
constexpr double kLeastInkSpread = 0.015;
/// So many pixels tell whether there is any: on paper that is not flat, each board asks.
constexpr int kPixelsOfInk = 700;
/// With fewer corners, ink has to tell so many times as much of the board.
constexpr double kMoreByInk = 4;
/// Of larger cells the light's bend is taken out too: a vignetting of a tenth makes a board of 40 px cells seem 3e-5
/// smaller, three standard deviations; in small cells it does not count.
constexpr double kFineCellPx = 12;
/// Of these, twice: the levels of cells in uneven light are not quite those of their middles.
constexpr double kTwiceCellPx = 24;

/// @param slope per plane unit, @param bend of x², xy and y² on the board.
LightFall FallOf(const Eigen::Vector2d& slope, const Eigen::Vector3d& bend, const Eigen::Matrix2d& board_by_plane) {
  const Eigen::Matrix2d square = (Eigen::Matrix2d() << bend[0], bend[1] / 2, bend[1] / 2, bend[2]).finished();
  const Eigen::Matrix2d per_plane = board_by_plane.transpose() * square * board_by_plane;
  const auto value = [](double of) { return static_cast<float>(of); };
  return {value(slope.x()), value(slope.y()), value(per_plane(0, 0)), value(2 * per_plane(0, 1)),
          value(per_plane(1, 1))};
}

}  // namespace

template <class Light>
void BoardFit::EvenOutPixels(const Light& even) {
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(result_.geometry);
  const Eigen::Matrix2d board_by_plane = result_.geometry.PlaneByBoard({0, 0}).inverse().transpose();
  LaneBlock& lanes = pixels_.lanes();
  for (int lane = 0; lane < lanes.lanes(); ++lane)
    for (int i = 0; i < lanes.count(lane); ++i) {
      const std::size_t at = lanes.Place(lane, i);
      float &u = lanes.u_data()[at], &v = lanes.v_data()[at], &light = lanes.light_data()[at];
      const Eigen::Vector2d board = (board_from_plane * Eigen::Vector3d(u, v, 1)).hnormalized();
      const double share = std::max(even.At(board), kLeastShading);
      light /= static_cast<float>(share);
      const Eigen::Vector2d shift = blur_px_ * blur_px_ / share * (board_by_plane * even.SlopeAt(board));
      u += static_cast<float>(shift.x());
      v += static_cast<float>(shift.y());
    }
}

double BoardFit::LightAt(int corner) const { return shadow_ ? shadow_->At(pixels_.place(corner).board) : 1; }

void BoardFit::EvenOutShading(const Start& start) {
  if (own_levels_ || shadow_) return;
  const double cell_px = CellPx();
  shade_twice_ = cell_px > kTwiceCellPx;
  const auto shading = FindShading({.size = size_,
                                    .levels = levels_,
                                    .saturated = start.saturated,
                                    .hidden = hidden_cells_,
                                    .phases = channels_ == 3 ? 4 : 1,
                                    .blue_phase = channels_ == 3 ? 3 - red_phase_ : -1,
                                    .fine = cell_px > kFineCellPx});
  if (!shading) return;
  bent_light_ |= shading->bent;
  // Taken out of every pixel; levels then are those in the light of the board's centre. As the lens blurs what is
  // already shaded, more light comes to a pixel from its lighter side: it shows what lies σ² ∇log(light) away.
  if (shading->bent) {
    EvenOutPixels(*shading);
  } else {
    const Eigen::Matrix2d board_by_plane = result_.geometry.PlaneByBoard({0, 0}).inverse();
    const Eigen::Vector2d per_px = board_by_plane.transpose() * shading->slope;
    pixels_.MoveOrigin(blur_px_ * blur_px_ * per_px);
    EvenOutLanes(FallOf(per_px, shading->bend, board_by_plane), pixels_.lanes());
  }
  for (int cell = 0; cell < size_.rows * size_.cols; ++cell) {
    const float scale = static_cast<float>(1 / shading->At(MiddleOfCell(size_, cell)));
    for (float& level : levels_[static_cast<std::size_t>(cell)]) level *= scale;
  }
}

bool BoardFit::StartInk(const LightReader& reader, const Lens& lens) {
  const double cell_px = CellPx();
  if (!look_farther_) LookBeside(reader, lens);
  MapLevels();
  fit_ink_ = true;
  model_input_.terms = {.motion = !smear_px_.isZero(), .dot_gain = true, .shadow = shadow_.has_value()};
  if (!SolveModel(StrideFor(kPixelsOfInk))) return false;
  const double more = std::abs(model_equations_.step()[ModelColumns(model_input_.terms).dot_gain]);
  return more * cell_px >= kLeastInkSpreadPx && more >= kLeastInkSpread;
}

void BoardFit::FitInk(const LightReader& reader, const Lens& lens, const Start& start) {
  const bool looked_farther = look_farther_;
  if (!StartInk(reader, lens)) {
    fit_ink_ = false;
    return;
  }
  look_farther_ = true;
  without_ink_ = result_;
  StartGain(model_equations_.step()[ModelColumns(model_input_.terms).dot_gain], start.blur_px);
  const bool settled = SettleModel(reader, lens, start, true);
  if (settled) Finish();
  // Ink explains all corners, or most of what the others lacked, or something else moved them.
  if (settled && (result_.corners_used >= without_ink_.corners_used ||
                  result_.told() > kMoreByInk * without_ink_.told()))
    return;
  result_ = without_ink_;
  ink_spread_ = 0;
  fit_ink_ = false;
  look_farther_ = looked_farther;
}

double BoardFit::FarthestMove(const BoardGeometry& from) const {
  double farthest = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const CornerPlace& place = pixels_.place(corner);
    if (!place.inside) continue;
    const Eigen::Vector2d move = result_.geometry.ToPlane(place.board) - from.ToPlane(place.board);
    farthest = std::max(farthest, (place.plane_by_pixel.inverse() * move).norm());
  }
  return farthest;
}

double BoardFit::CellPx() const {
  return std::sqrt(std::abs(pixels_.place(pixels_.corners() / 2).pixel_by_board.determinant()));
}

}  // namespace chequer
