// Of BoardFit: the steps of the plain model until nothing moves any more.
#include <algorithm>
#include <cmath>
#include <utility>

#include "detect/fit/board_fit.h"
#include "detect/fit/board_fit_limits.h"

namespace chequer {
namespace {

constexpr int kMaxPasses = 8;
/// A step that moves corners and blur less ends the fit: the errors left are those of its square and cube.
constexpr double kSettledPx = 0.05, kSettledBlur = 0.1;
/// The next step over this one where residuals are noise, for each variance that they have (measured: 0.01 to 0.06, 0.1
/// to 0.4 at three variances and beyond).
constexpr double kNextStep = 0.04;
/// Steps that shrink by less are taken to shrink by that (a guess).
constexpr double kLeastShrinking = 0.1;
/// Residuals that are less are rounding, not noise, variances (a guess).
constexpr double kLeastVariances = 1e-3;
/// Where a step moved corners farther, they are placed anew before the next one. (With 0.1 px, one of the tests' boards
/// under gloss lies 5 % farther off.)
constexpr double kFollowSettlingPx = 0.05;
/// What a fit that has settled leaves.
struct SettleLimits {
  double square;         ///< of the way that the next steps would still lead, standard deviations, at most
  double shape;          ///< another shape of the blur lets Σ w r² fall by less for each pixel
  double shape_follows;  ///< a step that is made anyway has the shape that explains so much more
};
/// Measured: with a shape of 0.015, poses of moving boards with and without memory differ by a tenth more, in 2 % less
/// work. Noise alone explains less than 12 (kShapeCounts).
constexpr SettleLimits kUsualLimits{.square = 0.2, .shape = 0.008, .shape_follows = 12};
/// The same where another blur seems to be another place: of overexposed cells, the pixels at the light side of an edge
/// tell little, and of a board that is hidden in part, a turn moves the middle of what shows. Measured: poses with and
/// without memory differ by 0.08 to 0.10 deviations where boards are overexposed instead of 0.09 to 0.12, under hands
/// by 0.10 instead of 0.12, in 8 and 5 % more work.
constexpr SettleLimits kCloseLimits{.square = 0.01, .shape = 0.001, .shape_follows = 1};
/// A board whose blur seems longer by more than that, px, does not tell its edges: what the motion does to them is none
/// of the lens's. Boards that stand seem to have moved by less, behind a sharpening filter too (measured: with 1 to 2
/// px, poses of fast boards with and without memory differ by 0.07 instead of 0.12 deviations).
constexpr double kMostMovedOfEdgesPx = 1;
/// The most estimates of the dot gain before that of the edges; each begins with the one before. (Of overexposed
/// boards, the first has half of a strong one, and the fourth all of it.)
constexpr int kMostGains = 5;
/// The most passes after each of them, and after that of the edges.
constexpr int kPassesOfTraits = 6;
/// Passes until what is done to the light (see board_fit_light.cpp) has settled too, and where it had settled before.
constexpr int kPassesOfLight = 4, kPassesOfLightAnew = 2;

}  // namespace

double BoardFit::LeftVariances() const {
  if (run_->plain_input.sums == LaneSums::kShapes) return 1;  // no weights were summed
  return std::max((equations_.chi_square() - run_->step.gain) / std::max(WeightUsed(), 1.0), kLeastVariances);
}

double BoardFit::SquareOf(const BoardGeometry::Parameters& moves) const {
  constexpr int kMoves = BoardGeometry::kParameters;
  return moves.dot(equations_.normal().topLeftCorner<kMoves, kMoves>() * moves);
}

BoardFit::StepSize BoardFit::SizeOfStep() const {
  const double variances = LeftVariances();
  return {SquareOf(run_->step.moves.head<BoardGeometry::kParameters>()) / variances, variances};
}

double BoardFit::SquareLeft(const StepSize& step, const StepSize& before) const {
  double next = kNextStep * std::max(step.variances, 1.0);
  // Two steps tell it better.
  if (before.square > 0) next = std::sqrt(step.square / before.square);
  // As each of those that follow shrinks by as much, they lead so many times as far as the last one. Plain fits under a
  // budget do not go all the way.
  const double left = run_->terms.plain_only ? next : next / std::max(1 - next, kLeastShrinking);
  return left * left * step.square;
}

bool BoardFit::WhatIsLeftCounts(const StepSize& step, const StepSize& before, double most) const {
  // With a budget, plain fits of all boards go before better ones of those that they do not explain.
  if (run_->terms.plain_only && step.variances > kExplained) return false;
  return SquareLeft(step, before) > most;
}

bool BoardFit::EndsRoughly() const { return run_->told.square_left > kCloseLimits.square; }

bool BoardFit::FollowsClosely() const {
  // With a budget, plain fits of all boards go before better ones.
  return !run_->terms.plain_only && (run_->view.overexposed || AnyUnused());
}

bool BoardFit::SettleAnew(const LightReader& reader, const Lens& lens, const Start& start) {
  return Recollect(reader, lens, start) && Settle(lens, start, true, true);
}

bool BoardFit::StepOn(const LightReader& reader, const Lens& lens, const Start& start) {
  const ImageTraits image = run_->result.image;
  run_->number = ++pixels_of_;
  profiles_.Set(run_->model.edges);
  if (!Recollect(reader, lens, start) || !StepFromThere(lens, LaneSums::kLevels, true, 0)) return false;
  Finish(lens);
  FitBent(reader, lens, start);
  run_->result.image = image;  // the step asked for none of it
  return run_->result.determined();
}

bool BoardFit::StepFromThere(const Lens& lens, LaneSums sums, bool first, double shape_left) {
  const bool moved = run_->step.corner_px > kFollowSettlingPx;
  if (moved) pixels_.PlaceCorners(lens, run_->model.geometry);
  if (moved || first || run_->step.shape_gain >= shape_left) SetPlaces();
  return Step(sums) && run_->step.corner_px <= kRunawayPx;
}

bool BoardFit::Settle(const Lens& lens, const Start& start, bool noise_known, bool anew) {
  const int passes_of_light = anew ? kPassesOfLightAnew : kPassesOfLight;
  LaneSums sums = noise_known ? LaneSums::kLevels : LaneSums::kNoise;
  run_->light.fades = true;
  SetWindows();
  TraitsToTell untold{.gains = start.TellsGain() ? kMostGains : 0, .edges = !start.image};
  StepSize step, before;
  for (int pass = 1, last = kMaxPasses, lit_by = 0; pass < last; before = step, ++pass) {
    const SettleLimits& settled = FollowsClosely() ? kCloseLimits : kUsualLimits;
    const double shape_left = settled.shape * pixels_.pixels();
    run_->plain_input.robust_limit = noise_known ? kRobustLimit : 1e9f;
    if (!StepFromThere(lens, sums, pass == 1, std::min(settled.shape_follows, shape_left))) return false;
    if (pass == 1 && BeginsNear(start) && run_->step.corner_px > kOtherPixelsPx) return false;
    step = SizeOfStep();
    run_->told.pixel_variance = step.variances;
    // The model with motion takes over (NeedsTermsAfterAll).
    if (pass > 1 && !run_->terms.plain_only && FollowsLongWay()) break;
    if (MayBeOutOfRegister()) MoveInks(start);
    const bool changed = FindOccludedCorners();
    if (changed && run_->light.beside_hidden) SetWindows();
    // What is done to the light follows the fit by a pass or two.
    const bool uneven = run_->light.bent || AnyUnused(), again = run_->light.shade_twice && pass == 1;
    const bool follows = pass == lit_by || (uneven ? pass < passes_of_light : again);
    const bool near = run_->step.corner_px < kSettledPx && run_->step.blur_share < kSettledBlur;
    // The levels of one that is near are fitted, not sampled.
    const bool lit_anew =
        near && !uneven && pass + 1 < last &&
        !ShadingHolds(start, step.variances, untold.gains > 0 ? LevelsFrom::kFirstSteps : LevelsFrom::kFit);
    const bool ends = noise_known && !changed && !follows && near && !lit_anew && run_->step.shape_gain < shape_left &&
                      !WhatIsLeftCounts(step, before, settled.square);
    // With a strong dot gain that it does not know, a fit need not come to its end.
    if (ends || (pass + 1 == last && untold.gains > 0)) {
      // Of the image's first board, which tells the others: as it ends, however many steps it took.
      if (start.TellsNoise() && sums == LaneSums::kNoise) ReadNoise();
      run_->told.settled = ends;
      run_->told.square_left = SquareLeft(step, before);
      run_->result.moved_square = SquareOf(run_->step.moved) / step.variances;
      if (!TellTraits(lens, start, untold)) break;
      // What they explain is no noise.
      run_->told.settled = noise_known = false;
      last = pass + kPassesOfTraits;
      // Levels have told a shading that may have been what was told now.
      if (TakeBackFromPixels(lens)) lit_by = pass + 1;
      continue;
    }
    if (pass == lit_by || (uneven ? pass > 1 && pass < passes_of_light : again)) FollowShading(lens, start);
    noise_known = true;
    // It is the camera's: what a board has told holds for the image's others, too. What theirs have beside it, of print
    // or of steps that are not at their end, is no noise of pixels; their misfit widens the covariance.
    if (!start.TellsNoise()) continue;
    if (sums == LaneSums::kNoise) ReadNoise();
    sums = LaneSums::kNoise;
  }
  return true;
}

void BoardFit::ReadNoise() {
  EstimateNoise(pixels_, run_->visibility.corners(), run_->view.channel_of_phase, run_->model.noise);
}

bool BoardFit::TellTraits(const Lens& lens, const Start& start, TraitsToTell& untold) {
  if (untold.gains == 0 && !untold.edges) return false;
  Finish(lens);
  // Dot gain moves edges, and seems to give them another shape.
  const bool had_gain = run_->model.dot_gain != 0;
  if (untold.gains > 0 && TellGain()) {
    --untold.gains;
    // It looks like blur, too.
    if (!had_gain) run_->model.blur_px = std::min(run_->model.blur_px, start.blur_px);
    return true;
  }
  untold.gains = 0;
  // Those of a board that lies elsewhere seem to have another shape, too.
  const bool edges = std::exchange(untold.edges, false) && TellEdges();
  if (edges && run_->model.dot_gain != 0) untold.gains = 1;
  return edges;
}

bool BoardFit::TellEdges() {
  if (run_->model.blur_shape.way_px.norm() > kMostMovedOfEdgesPx || !run_->result.flat()) return false;
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  // Its sums take the place of the last step's.
  const std::optional<EdgeSpread> found = FindEdgeSpread(run_->plain_input, board_by_pixel.row(0),
                                                         board_by_pixel.row(1), run_->visibility.corners(), pixels_);
  run_->told.sums_gone = !found;
  run_->result.image.gaussian_edges = !found;
  if (!found) return false;
  run_->model.edges = *found;
  profiles_.Set(run_->model.edges);
  run_->model.blur_px = run_->model.edges.blur_px;
  return true;
}

}  // namespace chequer
