// Of BoardFit: how the plain model comes near a board, from where it was found or is expected.
#include <algorithm>
#include <cmath>

#include "detect/fit/board_fit.h"
#include "detect/fit/board_fit_limits.h"

namespace chequer {
namespace {

/// A blur so much above what the pixels were chosen for asks for others.
constexpr double kWiderBlur = 1.2, kGrowingBlur = 0.5;
/// One that still grows and is wider than that, cells, is none of the lens's: the plain model makes ever more of a way
/// as long as a cell (measured, of knocked boards: the first one of an image took 4 to 6 times the work of others and
/// told a wrong motion, or did so by no more than chance; with .25 to .45 none).
constexpr double kWidestGrowing = 0.3;
/// Until corners that were found lie right.
constexpr int kStepsOfFound = 3;
/// Where the levels are known too, all pixels of so many corners, spread over the board, place it as well as a third of
/// the pixels of all corners do (1.6 of a whole fit's standard deviations), in five sixths of the instructions. Of
/// every second of them, poses with and without memory would differ by a tenth more.
constexpr int kFewestSpread = 9;
/// Cells, in blurs, whose middles show their own light.
constexpr double kClearCell = 6;
/// Steps towards a predicted board (kStillFromPrediction, kOtherPixelsPx).
constexpr int kMostFromPrediction = 4;
/// The same where others of the image tell its motion: a step that moves it less leaves a tenth of a pixel (measured).
constexpr int kMostAlongMotion = 3;
constexpr double kStillAlongMotionPx = 0.3;
/// Where it has moved farther, the cells' illumination was sampled elsewhere than it lies.
constexpr double kOtherLevelsPx = 0.5;
/// The same as kOtherPixelsPx where the rim's pixels fade out with the board (measured: up to 0.5 px, poses with and
/// without memory agree as well).
constexpr double kOtherSoftPixelsPx = 0.35;

}  // namespace

bool BoardFit::SpreadCornersSuffice() const {
  int count = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) count += pixels_.is_spread(corner) && used(corner);
  return count == pixels_.spread_corners() && count >= kFewestSpread;
}

bool BoardFit::BeginsNear(const Start& start) const {
  return start.near && start.KnowsNoise() && !BeginsAtFullScale(start) && !run_->model.own_levels &&
         !run_->model.MotionTerm::on();
}

bool BoardFit::ComeNear(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  // The first step only has to come near: a part of the pixels does, whatever their noise.
  // Who judges the noise by what is left needs the levels as they fit. Another's are as sampled, where their neighbours
  // do not blur into them, and none begins at full scale: it may be any that is as light, and edges would seem
  // blurred instead.
  const bool knows_levels = start.KnowsNoise() && !BeginsAtFullScale(start) &&
                            BoardByPixel().rowwise().norm().maxCoeff() * kClearCell * run_->model.blur_px < 1;
  const LaneSums first = knows_levels && !run_->model.own_levels ? LaneSums::kShapes : LaneSums::kLevels;
  const bool knows_all = first == LaneSums::kShapes && run_->plain_input.stride == kFirstStrideKnown;
  if (knows_all && SpreadCornersSuffice()) UsePixels(1, true);
  const double known_blur_px = run_->model.blur_px;
  if (!BeginsNear(start)) {
    const bool near = Step(first) && run_->step.corner_px <= kRunawayPx;
    if (!near && !ComeNearByFound(reader, lens, start, choice)) return false;
    if (start.predicted && !LeavePrediction(reader, lens, start, first)) return false;
  }
  if (BeginsAtFullScale(start)) {
    // The blur has taken up what levels lacked: it begins anew.
    run_->model.blur_px = start.blur_px;
    if (!Step(first) || run_->step.corner_px > kRunawayPx) return false;
  } else if (run_->view.overexposed) {
    // The same of a cell's level, which is not quite the mean of its ink.
    run_->model.blur_px = known_blur_px;
    run_->model.blur_shape = start.blur_shape;
  }
  // The rim's pixels were chosen for a sharper image: what is blurred into them from beside the board would pull it.
  for (double chosen_for = start.blur_px; run_->model.blur_px > kWiderBlur * chosen_for;) {
    // A blur that grows as much as a step may goes on to grow.
    const bool grows = run_->step.blur_share > kGrowingBlur;
    if (grows && choice.may_look_farther && run_->model.blur_px > kWidestGrowing * CellPx()) break;
    if (!grows) chosen_for = run_->light.window_blur_px = run_->model.blur_px;
    if (!grows && !Recollect(reader, lens, start)) return false;
    if (!Step(first) || run_->step.corner_px > kRunawayPx) return false;
  }
  EvenOutShading(start, LevelsFrom::kFirstSteps);
  return true;
}

bool BoardFit::LeavePrediction(const LightReader& reader, const Lens& lens, const Start& start, LaneSums sums) {
  const double still_px = kStillFromPrediction * run_->model.blur_px;
  double moved_px = run_->step.corner_px;  // at most
  for (int step = 1; step < kMostFromPrediction && run_->step.corner_px > still_px; ++step) {
    pixels_.PlaceCorners(lens, run_->model.geometry);
    SetPlaces();
    if (!Step(sums) || run_->step.corner_px > kRunawayPx) return false;
    moved_px += run_->step.corner_px;
  }
  const double other_px = std::lerp(kOtherPixelsPx, kOtherSoftPixelsPx, BoardPixels::RimSoftness(CellPx()));
  if (moved_px > other_px && !Recollect(reader, lens, start)) return false;
  // Levels that were sampled so far off leave more residuals than noise does.
  if (moved_px <= kOtherLevelsPx || sums == LaneSums::kLevels) return true;
  UsePixels(kFirstStrideKnown);
  return Step(LaneSums::kLevels) && run_->step.corner_px <= kRunawayPx;
}

bool BoardFit::ComeNearByFound(const LightReader& reader, const Lens& lens, const Start& start, const Choice& choice) {
  // Few corners on one side place those on the other badly.
  if (!Prepare(reader, lens, start, choice)) return false;
  UsePixels(1);
  int found = 0;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (used(corner) && !start.found[static_cast<std::size_t>(corner)]) run_->visibility.Set(corner, Hidden::kLeftOut);
    found += used(corner);
  }
  if (found < FittedBoard::kFewestCorners || found == pixels_.corners()) return false;
  for (int step = 0; step < kStepsOfFound; ++step) {
    if (!Step(LaneSums::kLevels)) return false;
    for (int corner = 0; corner < pixels_.corners(); ++corner) {
      if (!used(corner)) continue;
      if ((pixels_.place(corner).pixel_by_board * MoveOf(corner)).norm() > kRunawayPx) return false;
    }
    pixels_.PlaceCorners(lens, run_->model.geometry);
    SetPlaces();
  }
  // Where these have the others, there are other pixels.
  Start again = start;
  again.geometry = run_->model.geometry;
  again.image = nullptr;
  if (!Prepare(reader, lens, again, choice)) return false;
  return Step(LaneSums::kLevels) && run_->step.corner_px <= kRunawayPx;
}

void BoardFit::FollowMotion(const Lens& lens) {
  BoardModel& model = run_->model;
  const BoardGeometry from = model.geometry;
  const double lens_px = model.blur_px;
  const bool of_spread = SpreadCornersSuffice();
  UsePixels(of_spread ? 1 : kFirstStrideKnown, of_spread);
  for (int step = 0; step < kMostAlongMotion; ++step) {
    model.blur_shape = {model.motion_px, model.turn};
    model.blur_px = model.blur_shape.BlurPx(lens_px);
    SetPlaces();
    if (!Step(LaneSums::kShapes) || run_->step.corner_px > kRunawayPx) {
      model.geometry = from;
      run_->step.corner_px = 0;
    }
    pixels_.PlaceCorners(lens, model.geometry);
    if (run_->step.corner_px < kStillAlongMotionPx) break;
  }
  model.blur_px = lens_px;
  model.blur_shape = {};
  SetPlaces();
}

}  // namespace chequer
