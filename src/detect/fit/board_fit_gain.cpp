// Of BoardFit: dot gain. An image's first board tells it.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/small_cholesky.h"
#include "detect/fit/board_fit.h"
#include "detect/fit/board_fit_limits.h"
#include "detect/fit/parabola.h"

namespace chequer {
namespace {

/// As many pixels tell it.
constexpr int kPixels = 1500;
/// By which it is tried to be more and less, px: an eighth of a blur.
constexpr double kTriedPx = 0.1;
/// Where it is still less at an end, so many times as far again, so often.
constexpr double kFarther = 1.6;
constexpr int kMostMore = 6;
/// Of what it explains, variances: with less there is none, with more it is surely there; between, a part of it counts.
/// One that is none costs boards that moved twice the work; as much as goes untold, of cells of 10 px .0005, moves a
/// board by a quarter of its deviation.
constexpr double kNone = 16, kSure = 36;
/// Half as many pixels, with all else as it is, tell in a third of the work whether it may be there: of what a gain
/// explains they show an eighth at least (measured, of 594 boards with .003 to .02 cells; nine tenths of 346 boards
/// without any show less).
constexpr int kPixelsOfGlance = kPixels / 2;
constexpr double kNoneAtAGlance = kNone / 8;
/// Another one that is so much off, variances, is the same.
constexpr double kSame = 0.1;
/// A first step that is shorter has other reasons: of a spread of half a pixel it is 0.29 px, of motion or noise 0.01.
constexpr double kLeastInkSpreadPx = 0.1;
/// Less of a cell pulls no pose, and edges drawn without a lens's blur may look so much off.
constexpr double kLeastInkSpread = 0.015;
/// So many pixels tell whether there is any: on paper that is not flat, each board asks.
constexpr int kPixelsOfInk = 700;
/// A plain fit does not come near boards with more, cells.
constexpr double kMost = 0.15;
/// Of overexposed boards, light levels that nothing shows move edges as a dot gain does: steps have so much of the
/// information that they seem to (measured, of 90 frames without any: 2.6 times the deviation, 7 times at most).
constexpr double kOverexposedTells = 0.15;

/// The parabola through three values, in order, the middle one of which is the least.
template <class Value>
std::optional<Parabola> LowestAround(double middle, double step, const Value& value) {
  std::array<ParabolaPoint, 3> tries;
  for (std::size_t i = 0; i < tries.size(); ++i) {
    const double at = middle + (static_cast<double>(i) - 1) * step;
    const std::optional<double> left = value(at);
    if (!left) return std::nullopt;
    tries[i] = {at, *left};
  }
  // Farther each time, until it rises.
  for (int more = 0; more < kMostMore && tries[1].value >= std::min(tries[0].value, tries[2].value); ++more) {
    if (tries[0].value < tries[2].value) std::swap(tries[0], tries[2]);
    const double at = tries[2].at + kFarther * (tries[2].at - tries[1].at);
    const std::optional<double> left = value(at);
    if (!left) return std::nullopt;
    tries = {tries[1], tries[2], {at, *left}};
  }
  return ParabolaThrough(tries);
}

}  // namespace

void BoardFit::SetLanesWithGain(double gain) {
  run_->model.dot_gain = gain;
  SetLanes();
  // Weights that follow the light would make χ² no parabola.
  LevelNoise(pixels_.lanes());
}

std::optional<double> BoardFit::LeftWithGain(double gain) {
  SetLanesWithGain(gain);
  SumPlain();
  work_.Add(WorkStep::kFitStep);
  const SmallCholesky<BoardEquations::kUnknowns> solver(equations_.normal());
  if (!solver.positive()) return std::nullopt;
  return equations_.chi_square() - solver.Solve(equations_.gradient()).dot(equations_.gradient());
}

double BoardFit::VarianceOfGain() const {
  // Corners that print or paper moves make a gain less certain, too.
  return run_->told.pixel_variance * std::max(run_->told.unexplained_shifts, 1.0);
}

double BoardFit::GainThatCounts(double gain, double information) const {
  const double counts = std::clamp((gain * gain * information / VarianceOfGain() - kNone) / (kSure - kNone), 0.0, 1.0);
  return std::clamp(counts * gain, -kMost, kMost);
}

double BoardFit::InformationOnGain() const {
  const double seems = model_equations_.InformationOn<1>(ModelColumns(run_->model_input.terms).of<DotGainTerm>())(0, 0);
  return run_->view.overexposed ? kOverexposedTells * seems : seems;
}

std::optional<BoardFit::ToldGain> BoardFit::SolveGain(int pixels) {
  run_->model.ink = true;
  SetTerms();
  run_->model.ink = false;
  if (!SolveModel(StrideFor(pixels))) return std::nullopt;
  const double step = model_equations_.step()[ModelColumns(run_->model_input.terms).of<DotGainTerm>()];
  return ToldGain{run_->model.dot_gain + step, InformationOnGain()};
}

std::optional<double> BoardFit::FindDotGain(const LightReader& reader, const Lens& lens, const Start& start) {
  if (!HavePixels(reader, lens, start)) return std::nullopt;
  if (!run_->terms.look_farther) LookBeside(reader, lens);
  const double cell_px = CellPx();
  const std::optional<ToldGain> told = SolveGain(kPixelsOfInk);
  if (!told) return std::nullopt;
  const double size = std::abs(told->cells);
  if (size * cell_px < kLeastInkSpreadPx || size < kLeastInkSpread) return std::nullopt;
  return told->cells;
}

double BoardFit::GainForOthers() const {
  const double gain = run_->model.dot_gain;
  if (!run_->terms.look_farther || gain == 0) return gain;
  return GainThatCounts(gain, InformationOnGain());
}

bool BoardFit::TellGainOfModel(const Lens& lens) {
  if (run_->model.DotGainTerm::on() || run_->model.own_levels) return false;
  Finish(lens);
  run_->told.sums_gone = true;
  const std::optional<ToldGain> told = SolveGain(kPixels);
  if (told) run_->model.dot_gain = GainThatCounts(told->cells, told->information);
  SetTerms();
  if (run_->model.dot_gain == 0) return false;
  run_->told.sums_gone = false;
  return true;
}

double BoardFit::LeftAtAGlance(double gain) {
  SetLanesWithGain(gain);
  SumLanes();
  return SumOfUsed(ProductSum(kResidual, kResidual));
}

bool BoardFit::MayHaveGrown() {
  UsePixels(StrideFor(kPixelsOfGlance));
  run_->plain_input.sums = LaneSums::kShapes;
  const std::optional<Parabola> lowest =
      LowestAround(0, kTriedPx / CellPx(), [&](double gain) { return LeftAtAGlance(gain); });
  run_->model.dot_gain = 0;
  if (!lowest) return true;
  constexpr double kAll = kPixels / kPixelsOfGlance;
  const double explains = kAll * lowest->bend / 2 * lowest->at * lowest->at;
  return explains > kNoneAtAGlance * VarianceOfGain();
}

std::optional<BoardFit::ToldGain> BoardFit::TryGains() {
  const double was = run_->model.dot_gain;
  UsePixels(StrideFor(kPixels));
  run_->plain_input.sums = LaneSums::kLevels;
  const std::optional<Parabola> lowest =
      LowestAround(was, kTriedPx / CellPx(), [&](double gain) { return LeftWithGain(gain); });
  run_->model.dot_gain = was;
  if (!lowest) return std::nullopt;
  return ToldGain{lowest->at, lowest->bend / 2};
}

void BoardFit::PrepareGain(const LightReader& reader, const Lens& lens) {
  if (run_->view.overexposed && !run_->terms.look_farther) LookBeside(reader, lens);
}

bool BoardFit::TellGain() {
  if (run_->model.own_levels || (run_->view.overexposed && run_->model.blur_px < kLeastSeenBlur)) return false;
  const double was = run_->model.dot_gain;
  const KernelInput input = run_->plain_input;
  // What saturated pixels leave is no χ², which trials would compare: a step takes them as it does for other unknowns.
  // Few pixels of such boards tell it, so all are asked.
  std::optional<ToldGain> told;
  if (run_->view.overexposed)
    told = SolveGain(kMostPixels);
  else if (was != 0 || MayHaveGrown())
    told = TryGains();
  run_->plain_input = input;
  SetLanes();
  run_->told.sums_gone = true;
  if (!told) return false;
  const double gain = GainThatCounts(told->cells, told->information), change = gain - was;
  if (change * change * told->information < kSame * run_->told.pixel_variance) return false;
  run_->model.dot_gain = gain;
  run_->told.sums_gone = false;
  return true;
}

}  // namespace chequer
