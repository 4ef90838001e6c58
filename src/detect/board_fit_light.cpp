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
/// Ink spreads over no more of a cell.
constexpr double kMostInkSpread = 0.3;
/// A first step that is shorter has other reasons: of a spread of half a pixel it is 0.29 px, of motion or noise 0.01.
constexpr double kLeastInkSpreadPx = 0.1;
/// Less of a cell pulls no pose, and edges drawn without a lens's blur may look so much off.
constexpr double kLeastInkSpread = 0.015;
/// The spread over such a step, as levels and blur have taken up the rest: measured, at the start and later.
constexpr double kInkStep = 1.75;
/// Every how many pixels tell whether there is any: on paper that is not flat, each board asks.
constexpr int kInkStride = 5;
/// With fewer corners, ink has to tell so many times as much of the board.
constexpr double kMoreByInk = 4;
/// Where corners lie as much farther off than was thought, other pixels are the board's.
constexpr double kCollectAnewPx = 0.3;
/// Longer steps lead elsewhere.
constexpr double kMostSmearStepPx = 1;
/// Its last step, cells.
constexpr double kSettledInkSpread = 0.0002;
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
      if (light >= input_.saturation) continue;
      const Eigen::Vector2d board = (board_from_plane * Eigen::Vector3d(u, v, 1)).hnormalized();
      const double share = std::max(even.At(board), kLeastShading);
      light /= static_cast<float>(share);
      const Eigen::Vector2d shift = blur_px_ * blur_px_ / share * (board_by_plane * even.SlopeAt(board));
      u += static_cast<float>(shift.x());
      v += static_cast<float>(shift.y());
    }
}

void BoardFit::EvenOutShadow() { EvenOutPixels(*shadow_); }

void BoardFit::FollowShadow() {
  shadow_moves_ = shadowed_.Move({.geometry = &result_.geometry,
                                  .blur_px = blur_px_,
                                  .levels = levels_,
                                  .noise = &noise_,
                                  .far_cells = take_out_ ? &far_cells_ : nullptr,
                                  .channel_of_phase = channel_of_phase_,
                                  .saturation = input_.saturation},
                                 used_, pixels_, *shadow_);
  shadowed_.PutBack(pixels_);
  EvenOutShadow();
  if (take_out_) far_cells_.Forget(pixels_);
}

void BoardFit::StartFarCells(const LightReader& reader, const Lens& lens) {
  far_cells_.Start(reader, lens, result_.geometry, channel_of_phase_, shadow_ ? &*shadow_ : nullptr, pixels_);
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
    EvenOutLanes(FallOf(per_px, shading->bend, board_by_plane), input_.saturation, pixels_.lanes());
  }
  for (int cell = 0; cell < size_.rows * size_.cols; ++cell) {
    const float scale = static_cast<float>(1 / shading->At(MiddleOfCell(size_, cell)));
    for (float& level : levels_[static_cast<std::size_t>(cell)]) level *= scale;
  }
}

void BoardFit::TakeOutLight() {
  FarCells::Known known = Known();
  far_cells_.TakeOut(known, pixels_);
  if (!smear_px_.isZero()) {
    const Eigen::Vector2d more = far_cells_.MoreSmear(known, used_, pixels_);
    if (more.norm() < kMostSmearStepPx) {
      smear_px_ += more;
      SetPlaces();
      known = Known();
      far_cells_.TakeOut(known, pixels_);
    }
  }
  if (!fit_ink_) return;
  // Levels and blur, which took up a part of the ink, follow first.
  if (ink_waits_ > 0) {
    --ink_waits_;
    return;
  }
  const double more = far_cells_.MoreInkSpread(known, used_, pixels_, 1), step = kInkStep * more;
  ink_moves_ = std::abs(step) > kSettledInkSpread;
  if (!ink_moves_) return;
  ink_spread_ = std::clamp(ink_spread_ + step, -kMostInkSpread, kMostInkSpread);
  known.ink_spread = ink_spread_;
  far_cells_.TakeOut(known, pixels_);
}

bool BoardFit::StartInk() {
  const double cell_px = CellPx();
  const double more = far_cells_.MoreInkSpread(Known(), used_, pixels_, kInkStride);
  if (std::abs(more) * cell_px < kLeastInkSpreadPx || kInkStep * std::abs(more) < kLeastInkSpread) return false;
  ink_spread_ = std::clamp(kInkStep * more, -kMostInkSpread, kMostInkSpread);
  ink_waits_ = kInkWaits;
  take_out_ = fit_ink_ = ink_moves_ = true;
  return true;
}

void BoardFit::FitInk(const LightReader& reader, const Lens& lens, const Start& start) {
  if (!take_out_) StartFarCells(reader, lens);
  if (!StartInk()) return;
  without_ink_ = result_;
  blur_px_ = std::min(blur_px_, start.blur_px);
  bool settled = Settle(lens, start, true);
  // Pixels chosen for corners that were far off reach into what lies beside the rim.
  if (settled && FarthestMove(collected_for_) > kCollectAnewPx) {
    settled = Collect(reader, lens);
    SetDerivatives();
    SetPlaces();
    StartFarCells(reader, lens);
    settled = settled && Settle(lens, start, true);
  }
  if (settled) Finish();
  // Ink explains all corners, or nearly all that the others lacked, or something else moved them.
  if (settled && (result_.corners_used >= without_ink_.corners_used ||
                  (result_.flat() && result_.told() > kMoreByInk * without_ink_.told())))
    return;
  result_ = without_ink_;
  ink_spread_ = 0;
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

FarCells::Known BoardFit::Known() const {
  return {.geometry = &result_.geometry,
          .blur_px = blur_px_,
          .ink_spread = ink_spread_,
          .smear_px = smear_px_,
          .levels = levels_,
          .own_levels = own_levels_,
          .saturation = input_.saturation};
}

}  // namespace chequer
