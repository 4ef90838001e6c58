// Of BoardFit: the shape that a short motion gives the blur.
#include <algorithm>
#include <limits>

#include "detect/fit/board_fit.h"
#include "detect/fit/board_fit_limits.h"

namespace chequer {
namespace {

/// A blur has a shape where Σ w r² falls by more with one: by noise alone it falls by 2 (a guess). Where it falls by so
/// much for each pixel, the motion is another one than the last frame's (a guess).
constexpr double kShapeCounts = 12, kOtherShape = 0.3;
/// A first step, whose levels are as sampled and which begins elsewhere, takes errors of these for a shape: it has one
/// that explains so much for each pixel (measured: of still boards, 95 % seem to have less; of driving ones, a third).
constexpr double kShapeOfFirstStep = 0.05;
/// One of a turn on the spot, which few boards make, is looked for after a step that moved corners less: errors of
/// places and levels grow towards the rim, too (measured: one of 12 boards behind a sharpening filter seemed to turn by
/// 2.5 degrees after a step of 0.07 px, and ended so far off that the RMS of all was a quarter more).
constexpr double kNearForTurnPx = 0.03;

}  // namespace

BlurShapeFit BoardFit::FitOfShape(const BlurShape& shape) const {
  BlurShapeFit fit(shape, BoardByPixel().rowwise().normalized(), run_->model.blur_px);
  CornerFour::Values square = CornerFour::Values::Zero();
  for (const CornerFour& four : pixels_.fours()) {
    const WayByTurn<CornerFour::Values> by_turn = fit.ByTurn(four.off_x, four.off_y);
    square += by_turn.x * by_turn.x + by_turn.y * by_turn.y;
  }
  fit.SetMeanSquare(double{square.sum()} / std::max(pixels_.inside(), 1));
  return fit;
}

bool BoardFit::ComesNear() const {
  return run_->plain_input.stride > 1 || run_->plain_input.lanes != KernelInput::kAllLanes;
}

CornerBlurSums<CornerFour::Values> BoardFit::SumBlur(const CornerFour& four, float blur_px) const {
  const CornerFour::Values none = CornerFour::Values::Zero();
  CornerBlurSums<CornerFour::Values> sums{none, none, none, none, none, none};
  for (std::size_t i = 0; i < 4; ++i) {
    const int corner = four.corner[i], lane = corner < 0 ? 0 : pixels_.Lane(corner);
    if (corner < 0 || !used(corner) || lane >= run_->plain_input.lanes) continue;
    const auto sum = [&](int which) {
      return Eigen::Map<const Eigen::Array4f>(pixels_.lanes().sum_data(which) + lane).sum();
    };
    const Eigen::Index at = static_cast<Eigen::Index>(i);
    sums.both_residual[at] = blur_px * sum(ProductSum(kBlur, kResidual));
    sums.both_square[at] = blur_px * blur_px * sum(ProductSum(kBlur, kBlur));
    sums.uneven_residual[at] = sum(kUnevenResidual);
    sums.uneven_square[at] = sum(kUnevenSquare);
    sums.skew_residual[at] = sum(kSkewResidual);
    sums.skew_square[at] = sum(kSkewSquare);
  }
  return sums;
}

void BoardFit::MoveBlurShape(double blur_px) {
  run_->step.shape_gain = 0;
  if (run_->model.blur_px < kLeastSeenBlur) {
    // Corners that were placed with one, as after a knock, make blurs seem as small: a step without it has to follow.
    if (!run_->step.placed_shape.round()) run_->step.shape_gain = std::numeric_limits<double>::infinity();
    run_->model.blur_shape = {};
    return;
  }
  // What lies elsewhere says nothing of its blur. Some of the pixels tell a shape less well than the last frame did.
  if (run_->step.corner_px > kStillFromPrediction * blur_px) return;
  if (ComesNear() && !run_->step.placed_shape.round()) return;
  const bool may_turn = !ComesNear() && run_->step.corner_px < kNearForTurnPx;
  BlurShapeFit fit = FitOfShape(run_->step.placed_shape);
  for (const CornerFour& four : pixels_.fours())
    fit.Add(fit.ByTurn(four.off_x, four.off_y), SumBlur(four, static_cast<float>(blur_px)), may_turn);
  // The noise that is known so far may be a hundred times what is left.
  const double variances = std::min(LeftVariances(), 1.0);
  run_->step.shape_gain = fit.Step(kShapeCounts * variances, run_->model.blur_shape) / variances;
  const BlurShape& placed = run_->step.placed_shape;
  if (ComesNear() && run_->step.shape_gain < kShapeOfFirstStep * pixels_.pixels()) {
    run_->model.blur_shape = placed;
    run_->step.shape_gain = 0;
    return;
  }
  if (placed.round()) return;
  // Another motion than the last frame's begins anew: steps from that one's might not find it.
  const bool another = placed == run_->step.start_shape && run_->step.shape_gain > kOtherShape * pixels_.pixels();
  if (another) run_->model.blur_shape = {};
  // So does one that explains no more than it would take to have it, or less than none at all: such a one leads
  // anywhere, step by step. (Of overexposed boards, one in some hundred began across its true way, and never found it.)
  const double round_leaves = fit.round_leaves() / variances;
  if (round_leaves >= -kShapeCounts && round_leaves + run_->step.shape_gain >= kShapeCounts) return;
  run_->model.blur_shape = {};
  run_->step.shape_gain = std::max(run_->step.shape_gain, std::abs(round_leaves));
}

}  // namespace chequer
