// Of BoardFit: the dot gain that an image's first board tells.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/small_cholesky.h"
#include "detect/fit/board_fit.h"

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
/// Another one that is so much off, variances, is the same.
constexpr double kSame = 0.1;
/// A plain fit does not come near boards with more, cells.
constexpr double kMost = 0.15;

/// Where a parabola is lowest, and its second derivative.
struct Parabola {
  double at = 0, bend = 0;
};

/// That through three values, in order, one of which is the least.
template <class Value>
std::optional<Parabola> LowestAround(double middle, double step, const Value& value) {
  struct Try {
    double at = 0, value = 0;
  };
  std::array<Try, 3> tries;
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
  const auto& [a, b, c] = tries;
  const double first = (b.value - a.value) / (b.at - a.at), second = (c.value - b.value) / (c.at - b.at),
               bend = 2 * (second - first) / (c.at - a.at);
  if (!(bend > 0)) return std::nullopt;
  return Parabola{(a.at + b.at) / 2 - first / bend, bend};
}

}  // namespace

std::optional<double> BoardFit::LeftWithGain(double gain) {
  run_->model.dot_gain = gain;
  SetLanes();
  // Weights that follow the light would make χ² no parabola.
  LevelNoise(pixels_.lanes());
  AccumulateLanes(run_->plain_input, pixels_.lanes());
  work_.Add(WorkStep::kFitStep);
  work_.Add(WorkStep::kFitPixel, static_cast<std::uint64_t>(PixelsOfStep() / run_->plain_input.stride));
  equations_.Assemble(PlainEquations());
  const SmallCholesky<BoardEquations::kUnknowns> solver(equations_.normal());
  if (!solver.positive()) return std::nullopt;
  return equations_.chi_square() - solver.Solve(equations_.gradient()).dot(equations_.gradient());
}

double BoardFit::GainThatCounts(double gain, double information) const {
  // Where print or paper moves corners, it moves them along edges alike.
  const double noise = run_->told.pixel_variance * std::max(run_->told.unexplained_shifts, 1.0);
  const double counts = std::clamp((gain * gain * information / noise - kNone) / (kSure - kNone), 0.0, 1.0);
  return std::clamp(counts * gain, -kMost, kMost);
}

double BoardFit::GainForOthers() const {
  const double gain = run_->model.dot_gain;
  if (!run_->terms.look_farther || gain == 0) return gain;
  const int column = ModelColumns(run_->model_input.terms).of<DotGainTerm>();
  return GainThatCounts(gain, model_equations_.InformationOn<1>(column)(0, 0));
}

bool BoardFit::TellGainOfModel(const Lens& lens) {
  if (run_->model.DotGainTerm::on() || !run_->model.LitEvenly() || run_->view.overexposed) return false;
  Finish(lens);
  run_->told.sums_gone = true;
  run_->model.ink = true;
  SetTerms();
  run_->model.ink = false;
  if (!SolveModel(StrideFor(kPixels))) return false;
  const int column = ModelColumns(run_->model_input.terms).of<DotGainTerm>();
  const double gain = GainThatCounts(model_equations_.step()[column], model_equations_.InformationOn<1>(column)(0, 0));
  SetTerms();
  if (gain == 0) return false;
  run_->model.dot_gain = gain;
  run_->told.sums_gone = false;
  SetTerms();
  return true;
}

bool BoardFit::TellGain() {
  // What saturated pixels leave is no χ².
  if (run_->model.own_levels || run_->view.overexposed) return false;
  const double was = run_->model.dot_gain;
  const KernelInput input = run_->plain_input;
  UsePixels(StrideFor(kPixels));
  run_->plain_input.sums = LaneSums::kLevels;
  const std::optional<Parabola> lowest =
      LowestAround(was, kTriedPx / CellPx(), [&](double gain) { return LeftWithGain(gain); });
  run_->plain_input = input;
  run_->model.dot_gain = was;
  SetLanes();
  run_->told.sums_gone = true;
  if (!lowest) return false;
  const double information = lowest->bend / 2, gain = GainThatCounts(lowest->at, information), change = gain - was;
  if (change * change * information < kSame * run_->told.pixel_variance) return false;
  run_->model.dot_gain = gain;
  run_->told.sums_gone = false;
  return true;
}

}  // namespace chequer
