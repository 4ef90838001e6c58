#include "detect/fit/hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "detect/fit/board_fit_limits.h"
#include "detect/fit/motion_blur.h"

namespace chequer {
namespace {

using From = Hypothesis::From;

bool Stands(const BoardFit& fit) { return fit.motion_px().isZero(); }

/// The same dot gain, and nothing else, is fitted roughly.
void StartAnew(const From& from, Trial& trial) {
  trial.choice = {};
  trial.start.visibility = from.first.visibility;
  trial.choice.terms.dot_gain = from.fit.dot_gain();
  trial.choice.roughly = true;
}
/// What the board says of noise and blur holds in the trial too.
void KeepTraits(const From& from, Trial& trial) {
  if (trial.start.KnowsNoise()) return;
  from.traits = from.kept.result.image;
  trial.start.image = &from.traits;
  trial.start.image_from = BoardFit::Start::TraitsFrom::kThisBoard;
}

void StartMotion(const BlurShape& shape, Trial& trial) {
  MotionTerm& motion = trial.choice.terms;
  motion.motion_px = shape.way_px;
  motion.turn = shape.turn;
}

/// A short motion, too, which the plain model has as the shape of its blur.
void KeepMotion(const From& from, Trial& trial) { StartMotion(from.kept.result.motion, trial); }

/// Whether a close fit has a motion that it was not begun with.
bool FoundMotion(const BoardFit& fit, const Trial& made) {
  return !fit.rough() && !Stands(fit) && made.choice.terms.motion_px.isZero();
}

// Without the motion that its blur seemed to be: shadows and ink make edges uneven, too.

/// Corners of boards that moved lie where a plane has them to 0.03 px; farther off, it may have been something else,
/// unless nothing else makes edges as uneven: then so far at most.
constexpr double kMostOffMovedPx = 0.04, kMostOffSurelyMovedPx = 0.15;

bool MayHaveStood(const BoardFit& fit, const Trial& made) {
  if (!FoundMotion(fit, made)) return false;
  const double off_px = fit.result().reprojection_rms_px;
  if (fit.sure_of_motion() && off_px <= kMostOffSurelyMovedPx) return false;
  return off_px > kMostOffMovedPx || AnyOf(fit.Occluded());
}

bool StartStanding(const From& from, Trial& trial) {
  // What was left out stays so.
  const Visibility visibility = trial.start.visibility;
  trial.start = from.first;
  trial.start.visibility = visibility;
  trial.choice.may_move = false;
  trial.choice.from = nullptr;
  return true;
}

// With another motion: what the blur seemed to be is too short a way at first, from which a fit may come to rest before
// it reaches the true one. It then leaves so much that an image's first board takes all others' noise for larger.

/// How much farther corners of a board that moved lie off the plane than their pixels' noise puts them (measured, of
/// 730 with ways of .9 to 1.4 cells: up to 1.3 with their motion, 1.4 to 5.1 with another).
constexpr double kMovedShifts = 1.3;
/// Nearer ones, cells, are the same: harmonics tell a way to 0.08 (motion_blur.h).
constexpr double kOtherMotion = 0.25;

bool CameToRest(const BoardFit& fit) { return fit.unexplained_shifts() < kMovedShifts; }

bool MayHaveMovedOtherwise(const BoardFit& fit, const Trial& made) {
  return FoundMotion(fit, made) && !CameToRest(fit);
}

bool StartOtherMotion(const From& from, Trial& trial) {
  const MotionBlurs found = FindMotionBlurs(from.reader, from.lens, trial.start.size, trial.start.geometry);
  const Eigen::Vector2d& was = from.fit.motion_px();
  if (found.count == 0) return false;
  // Where the likeliest is what was fitted, something else is wrong.
  const Eigen::Vector2d& likeliest = found.by_px[0];
  if (std::min((likeliest - was).norm(), (likeliest + was).norm()) < kOtherMotion * from.fit.cell_px()) return false;
  StartAnew(from, trial);
  trial.choice.terms.motion_px = likeliest;
  return true;
}

// With a motion where none was found: from ways of about a cell, the plain model comes to rest elsewhere, where the
// blur that is left shows none.

bool MayHaveMovedAfterAll(const BoardFit& fit, const Trial& made) {
  if (fit.rough() || !fit.looks_farther() || !Stands(fit) || !made.choice.may_move) return false;
  return BoardFit::MayBeMotion(fit.run().model.blur_px, fit.cell_px()) && fit.run().told.pixel_variance > kExplained;
}

// With a motion beside the dot gain: of the two, the first step finds the one that explains more.

/// The least way, cells, that the plain model's blur has to show for it.
constexpr double kLeastWayBesideGain = 0.15;

bool MayHaveMovedToo(const BoardFit& fit, const Trial& made) {
  if (!fit.looks_farther() || !Stands(fit) || fit.dot_gain() == 0 || !made.choice.may_move) return false;
  const BoardModel& model = fit.run().model;
  // With the dot gain, the blur is as wide as the way has it at least, unless the way was the dot gain's.
  return model.blur_shape.way_px.norm() > kLeastWayBesideGain * fit.cell_px() &&
         model.blur_px > model.blur_shape.BlurPx(0);
}

bool StartMoving(const From& from, Trial& trial) {
  StartAnew(from, trial);
  StartMotion(from.kept.model.blur_shape, trial);
  return true;
}

// With cells that did not stand out from others when the board was found, as motion blurs them into each other.

bool MayShowAfterAll(const BoardFit& fit, const Trial& made) {
  if (fit.rough() || Stands(fit)) return false;
  const std::span<const Hidden> cells = made.start.visibility.cells();
  return std::any_of(cells.begin(), cells.end(),
                     [](Hidden why) { return why == Hidden::kFlat || why == Hidden::kCovered; });
}

bool StartShown(const From& from, Trial& trial) {
  StartAnew(from, trial);
  KeepMotion(from, trial);
  KeepTraits(from, trial);
  const std::span<const Hidden> cells = from.first.visibility.cells();
  trial.start.visibility = Visibility(trial.start.size);
  for (std::size_t cell = 0; cell < cells.size(); ++cell)
    if (cells[cell] == Hidden::kOutside) trial.start.visibility.Hide(cell, Hidden::kOutside);
  return true;
}

// A lamp that the print mirrors.

bool MayBeUnevenlyLit(const BoardFit& fit, const Trial& made);

/// The light of white paper.
PhaseValues WhiteOf(const BoardFit& fit, const BoardFit::Start& start) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0;
  ForCells(start.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col) || start.saturated[cell] || !fit.run().visibility.Shows(cell)) return;
    sum += fit.result().levels[cell];
    ++count;
  });
  PhaseValues white{};
  for (std::size_t phase = 0; phase < white.size() && count > 0; ++phase)
    white[phase] = sum[fit.run().view.channel_of_phase[phase]] / count;
  return white;
}

/// Beside what makes the light uneven, levels show neither how it falls off nor a veil: both are fitted.
void BeginUnevenLight(const From& from, const PhaseValues& white, Trial& trial) {
  trial.choice.terms.shaded = true;
  trial.choice.terms.VeilTerm::Start(white);
  trial.choice.from = &from.kept;
}

using FindLamp = std::optional<HighlightTerm>(const BoardFit& fit, const Trial& made);

/// Where all of a board shows. @tparam kStands or of one that moved.
template <bool kStands>
std::optional<HighlightTerm> FindInPlainView(const BoardFit& fit, const Trial& made) {
  const Visibility& visibility = fit.run().visibility;
  const bool asked = Stands(fit) == kStands && visibility.ShowsAll();
  return asked ? fit.FindHighlight(made.start.saturated, visibility.cells()) : std::nullopt;
}

/// By the cells that show of one that is hidden in part.
std::optional<HighlightTerm> FindBesideHidden(const BoardFit& fit, const Trial& made) {
  const Visibility& visibility = fit.run().visibility;
  return visibility.ShowsAll() ? std::nullopt : fit.FindHighlight(made.start.saturated, visibility.cells());
}

/// Where it may be what cells seem to be hidden for.
std::optional<HighlightTerm> FindThatHides(const BoardFit& fit, const Trial& made) {
  if (fit.run().visibility.ShowsAll()) return std::nullopt;
  return fit.FindHighlight(made.start.saturated, Visibility(made.start.size).cells());
}

template <FindLamp find>
bool MayMirrorLamp(const BoardFit& fit, const Trial& made) {
  return (!fit.rough() || MayBeUnevenlyLit(fit, made)) && find(fit, made).has_value();
}

template <FindLamp find>
bool StartLamp(const From& from, Trial& trial) {
  const HighlightTerm lamp = *find(from.fit, trial);
  StartAnew(from, trial);
  static_cast<HighlightTerm&>(trial.choice.terms) = lamp;
  KeepMotion(from, trial);
  BeginUnevenLight(from, lamp.white, trial);
  return true;
}

/// One that ends as next to nothing was none.
bool HasLamp(const BoardFit& fit) { return fit.run().model.IsSeenOn(fit.run().view.size); }

// The edge of one shadow, as quadrants' levels tell it.

/// Quadrants' levels take up a part of a way: with less of it, cells, there may be none (measured: with a tenth of a
/// cell, poses under hands with and without memory differ by .09 and .14 deviations instead of .06 and .13).
constexpr double kLeastWayInShadow = 0.2;

bool HasQuadrants(const BoardFit& fit, const Trial& /*made*/) { return fit.run().model.own_levels; }

bool StartShadow(const From& from, Trial& trial) {
  const std::optional<ShadowEdge> shadow = FindShadowEdge(from.fit.LitParts(trial.start.saturated));
  if (!shadow) return false;
  StartAnew(from, trial);
  // The lens makes no edge sharper than its blur, which parts of cells do not show.
  ShadowEdge::Parameters values = shadow->values();
  values[ShadowEdge::kLogWidth] =
      std::max(values[ShadowEdge::kLogWidth], std::log(from.fit.result().image.blur_px / from.fit.cell_px()));
  trial.choice.terms.ShadowTerm::Start(values);
  // Quadrants that are fitted with all terms have no motion.
  const BlurShape& own = from.kept.result.motion;
  const BlurShape& motion = own.way_px.isZero() ? trial.start.blur_shape : own;
  if (motion.way_px.norm() > kLeastWayInShadow * from.fit.cell_px()) StartMotion(motion, trial);
  BeginUnevenLight(from, WhiteOf(from.fit, trial.start), trial);
  KeepTraits(from, trial);
  return true;
}

// Without corners that something occludes, which have told the light, the levels and the noise before that was known.

bool HasOccluded(const BoardFit& fit, const Trial& made) {
  // Where edges blur into each other, a fit goes on without them; quadrants do so once.
  if (fit.looks_farther() && !(fit.run().model.own_levels && !made.LeavesOut())) return false;
  return AnyOf(fit.Occluded());
}

bool LeaveOutOccluded(const From& from, Trial& trial) {
  trial.LeaveOut(from.fit.Occluded(), Hidden::kLeftOut);
  return true;
}

// Without a whole side: what covers it may pull the board until all corners are off, and none so much more than the
// others that it is found occluded.

/// A side whose corners fit so much worse than the opposite one's may be covered.
constexpr double kCoveredSide = 4;

/// The corners of the side that fits worst, if it fits much worse than the opposite one.
std::optional<CornerFlags> WorstSide(const BoardFit& fit, MarkerSize size) {
  const int rows = size.rows - 1, cols = size.cols - 1;
  const auto misfit_of = [&](int first, int step, int count) {
    double sum = 0;
    for (int i = 0; i < count; ++i) {
      const int corner = first + i * step;
      if (fit.usable(corner)) sum += fit.misfit(corner);
    }
    return sum;
  };
  struct Side {
    int first, step, count;
    double over_opposite;
  } worst{};
  const auto compare = [&](int step, int count, int to_opposite) {
    const double here = misfit_of(0, step, count), opposite = misfit_of(to_opposite, step, count);
    if (here > worst.over_opposite * opposite) worst = {0, step, count, here / opposite};
    if (opposite > worst.over_opposite * here) worst = {to_opposite, step, count, opposite / here};
  };
  compare(1, cols, (rows - 1) * cols);
  compare(cols, rows, cols - 1);
  if (worst.over_opposite < kCoveredSide) return std::nullopt;
  CornerFlags side{};
  for (int i = 0; i < worst.count; ++i) side[static_cast<std::size_t>(worst.first + i * worst.step)] = true;
  return side;
}

/// Whether corners of a board in even light lie off the plane.
bool IsOff(const BoardFit& fit) { return !fit.rough() && !fit.result().flat() && Stands(fit); }

bool HasWorseSide(const BoardFit& fit, const Trial& made) {
  return IsOff(fit) && fit.run().model.LitEvenly() && WorstSide(fit, made.start.size).has_value();
}

bool LeaveOutSide(const From& from, Trial& trial) {
  trial.LeaveOut(*WorstSide(from.fit, trial.start.size), Hidden::kLeftOut);
  return true;
}

// Dot gain, which moves the edges of a line to either side by turns. What it moves hides what a shadow does.

bool MayHaveGain(const BoardFit& fit, const Trial& /*made*/) {
  return !fit.rough() && !fit.result().flat() && fit.dot_gain() == 0 && !fit.run().model.own_levels;
}

bool StartGain(const From& from, Trial& trial) {
  const std::optional<double> gain = from.fit.FindDotGain(from.reader, from.lens, trial.start);
  if (!gain) return false;
  trial.choice.terms = from.kept.model;
  trial.choice.terms.DotGainTerm::Start(*gain);
  trial.choice.roughly = true;
  trial.choice.from = &from.kept;
  return true;
}

// Levels for each corner's quadrants: where the edge of a shadow crosses cells, they have no one level.

/// A corner that fits so much worse than a quarter of them may be crossed by the edge of a shadow.
constexpr double kUnevenMisfit = 3;
/// The same where corners lie so much farther off the plane than noise puts them: where cells are small against the
/// blur, or dot gain is strong, a shadow moves corners before it spoils their fit. In other boards, paper that is not
/// flat does so too.
constexpr double kUnevenShifts = 1.5;
/// Light cells of one ink then differ by more than prints do; a lens that is not known well moves corners too, but
/// leaves the cells alike.
constexpr double kUnevenCells = 0.02;
/// In smaller cells that blur into each other, levels of quadrants tell nothing.
constexpr double kLeastBlurredCellPx = 6;
/// Steps until quadrants' levels tell of a shadow's edge: where the board lies was known before.
constexpr int kStepsOfQuadrants = 4;
/// Of the lights on a board where no cell is crossed by used corners' account: the most over the least of a shadow.
/// The cells' levels explain a weaker fall of light better.
constexpr float kShadow = 1.6f;

/// The standard deviation of light cells of one ink from their mean, over it.
double Unevenness(const FittedBoard& board, const BoardFit::Start& start) {
  std::array<double, 2> sum{}, square{}, count{};
  for (int cell = 0; cell < start.size.rows * start.size.cols; ++cell) {
    const std::size_t i = static_cast<std::size_t>(cell), ink = start.saturated[i] != 0 ? 1 : 0;
    if (IsDark(cell / start.size.cols, cell % start.size.cols) || !start.visibility.Shows(i)) continue;
    const double light = static_cast<double>(board.levels[i].sum());
    sum[ink] += light;
    square[ink] += light * light;
    ++count[ink];
  }
  double variance = 0, cells = 0;
  for (std::size_t ink = 0; ink < count.size(); ++ink) {
    if (!(count[ink] > 1 && sum[ink] > 0)) continue;
    const double mean = sum[ink] / count[ink];
    variance += square[ink] / (mean * mean) - count[ink];
    cells += count[ink] - 1;
  }
  return cells > 0 ? std::sqrt(std::max(variance, 0.0) / cells) : 0;
}

bool MayBeUnevenlyLit(const BoardFit& fit, const Trial& made) {
  if (!fit.run().model.LitEvenly()) return false;
  if (fit.looks_farther() && fit.cell_px() < kLeastBlurredCellPx) return false;
  if (made.LeavesOut() || AnyOf(fit.Occluded())) return true;
  // The levels of saturated cells are hardly known.
  if (!fit.run().view.overexposed && fit.unexplained_shifts() > kUnevenShifts &&
      Unevenness(fit.result(), made.start) > kUnevenCells)
    return true;
  if (fit.misfit_spread() <= kUnevenMisfit) return false;
  // Inks out of register spoil the fit of corners, too, but leave the cells alike.
  if (!made.start.register_cells.isZero() && Unevenness(fit.result(), made.start) <= kUnevenCells) return false;
  std::array<double, kMaxCorners> misfits;
  std::ptrdiff_t count = 0;
  for (int corner = 0; corner < fit.corners(); ++corner)
    if (fit.used(corner)) misfits[static_cast<std::size_t>(count++)] = fit.misfit(corner);
  if (count == 0) return false;
  const auto past = misfits.begin() + count, quarter = misfits.begin() + count / 4;
  const double most = *std::max_element(misfits.begin(), past);
  std::nth_element(misfits.begin(), quarter, past);
  return most > kUnevenMisfit * *quarter;
}

bool StartQuadrants(const From& from, Trial& trial) {
  StartAnew(from, trial);
  trial.choice.own_levels = true;
  trial.choice.most_steps_near = kStepsOfQuadrants;
  trial.start.blur_shape = from.kept.result.motion;
  if (!from.fit.looks_farther()) return true;
  // Levels of quadrants take up a part of the blur: by what that leaves, edges would not be the image's.
  trial.choice.from = &from.kept;
  KeepTraits(from, trial);
  return true;
}

bool InShadow(const BoardFit& fit) {
  CellLight all;
  for (const CellLight& lit : fit.result().lit) {
    if (lit.crossed()) return true;
    if (lit.most == 0) continue;
    all = {all.most == 0 ? lit.least : std::min(all.least, lit.least), std::max(all.most, lit.most)};
  }
  return all.most > kShadow * all.least;
}

bool Always(const BoardFit& /*fit*/) { return true; }

/// What they must gain is measured: on boards that have what is tried, and on boards that have something else (40 to
/// 600 of each kind of tests/bench: conditions with shadows, dot gain, blur, motion and occlusion, real_prints with
/// gloss).
constexpr Hypothesis kHypotheses[] = {
    // Boards that moved lose .2 and more where they are fitted as if they stood, and the reverse.
    {Hypothesis::Path::kDetour, 0, MayHaveStood, StartStanding, Always},
    // Where cells showed, boards gained .1 to 2, where not, less than .02 or nothing.
    {Hypothesis::Path::kDirect, 0.05, MayShowAfterAll, StartShown, CameToRest},
    // Boards that are fitted with another motion lose .2 and more. Of 1,900 in knocked frames, one called for it, and
    // gained 1.0. What it leaves may look like a lamp's image, with which a board keeps it.
    {Hypothesis::Path::kDirect, 0.1, MayHaveMovedOtherwise, StartOtherMotion, Always},
    // Boards without one that show wholly hardly call for it: that levels of one ink have a spot is more than the score
    // tells, by which levels are free. Through sharpening and JPEG, weak ones seem to lose up to .1, and move boards
    // (measured: 17 of 890 were off by more than they say, 11 with this, and with .2).
    {Hypothesis::Path::kDirect, -0.1, MayMirrorLamp<FindInPlainView<true>>, StartLamp<FindInPlainView<true>>, HasLamp},
    // Another motion than the true one leaves levels with spots, too.
    {Hypothesis::Path::kDirect, 0, MayMirrorLamp<FindInPlainView<false>>, StartLamp<FindInPlainView<false>>, HasLamp},
    // What lies beside a cover or in a shadow may look like a spot to the cells that are left: of 24 covered boards
    // that were better with one, 15 gained less.
    {Hypothesis::Path::kDirect, 0.05, MayMirrorLamp<FindBesideHidden>, StartLamp<FindBesideHidden>, HasLamp},
    {Hypothesis::Path::kDirect, 0.05, MayMirrorLamp<FindThatHides>, StartLamp<FindThatHides>, HasLamp},
    // True ones gain .03 and more over quadrants' levels; gloss loses .09 and more, or gains nothing.
    {Hypothesis::Path::kArrival, 0, HasQuadrants, StartShadow, Always},
    // Boards with nothing else gain -.08 to .08 by which pixels are chosen, and lie as well without.
    {Hypothesis::Path::kDirect, 0, HasOccluded, LeaveOutOccluded, Always},
    // Where dot gain or a shadow moves all corners, boards gain up to .2 without a side; with a cover on it, .34 and
    // more.
    {Hypothesis::Path::kDirect, 0.3, HasWorseSide, LeaveOutSide, Always},
    // As much as another motion, below. Of 36 boards whose way was a cell of 7 px, 8 called for it.
    {Hypothesis::Path::kDirect, 0.1, MayHaveMovedAfterAll, StartOtherMotion, Always},
    // True ones gained 1.5 and more.
    {Hypothesis::Path::kDirect, 0, MayHaveGain, StartGain, Always},
    // Boards with ways of .3 to .8 cells, fitted without one, lay 5 to 18 times as far off.
    {Hypothesis::Path::kDirect, 0, MayHaveMovedToo, StartMoving, Always},
    // By chance they lose .07 and more, as they have three times as many unknowns; of dot gain that is not known yet,
    // they explain .02.
    {Hypothesis::Path::kDetour, 0.1, MayBeUnevenlyLit, StartQuadrants, InShadow},
};

static_assert(std::size(kHypotheses) <= kMostHypotheses);

}  // namespace

std::span<const Hypothesis> Hypotheses() { return kHypotheses; }

}  // namespace chequer
