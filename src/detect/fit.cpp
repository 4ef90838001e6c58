#include "detect/fit.h"

#include <algorithm>

#include "detect/smear.h"

namespace chequer {
namespace {

/// Boards that seem blurred so much, cells and px, may be smeared.
constexpr double kSmearedBlur = 0.12, kSmearedBlurPx = 1.2;
/// A smear that is one raises the contrast over what is not explained by more: 5 to 12 times where it is 0.6 cells or
/// more.
constexpr double kClearerBySmear = 1.5;
/// Corners of smeared boards lie where a plane has them to 0.05 px; farther off, it was not that smear.
constexpr double kMostOffSmearedPx = 0.15;

}  // namespace

const FittedBoard* PhotometricFit::Fit(const LightReader& reader, const Lens& lens, const Start& start) {
  const FittedBoard* fitted = start.smeared ? nullptr : FitAsItIs({reader, lens, start.board}, Eigen::Vector2d::Zero());
  if (!start.smeared && !start.may_be_smeared) return fitted;
  if (fitted && fitted->image.blur_px < std::max(kSmearedBlur * fit_.CellPx(), kSmearedBlurPx)) return fitted;
  BoardFit::Start smeared = start.board;
  smeared.image = nullptr;
  if (fitted) smeared.geometry = fitted->geometry;
  const Smears smears = FindSmears(reader, lens, smeared.size, smeared.geometry);
  if (smears.count == 0) return fitted;
  bool found = fitted != nullptr;
  if (found) best_ = *fitted;
  double least_signal = found ? kClearerBySmear * best_.signal_to_noise : 0;
  for (std::size_t i = 0; i < smears.count; ++i) {
    fitted = FitAsItIs({reader, lens, smeared}, smears.by_px[i]);
    if (!fitted || fitted->signal_to_noise < least_signal || fitted->reprojection_rms_px > kMostOffSmearedPx) continue;
    best_ = *fitted;
    least_signal = best_.signal_to_noise;
    found = true;
  }
  return found ? &best_ : nullptr;
}

const FittedBoard* PhotometricFit::FitAsItIs(const Task& task, const Eigen::Vector2d& smear_px) {
  choice_ = {};
  choice_.smear_px = smear_px;
  if (!fit_.Fit(task.reader, task.lens, task.start, choice_)) return nullptr;
  if (!fit_.takes_out_light()) LeaveOutHidden(task);
  const bool off = !fit_.result().flat() && smear_px.isZero(), side = off && LeaveOutSide(task);
  const bool may_be_uneven = MayBeUnevenlyLit(task), uneven = may_be_uneven && FitUnevenlyLit(task);
  if (off && !side && !uneven) {
    // Ink is fitted from where the cells' levels are.
    if (may_be_uneven && !FitAnew(task)) {
      fit_.GoBackTo(evenly_lit_);
    } else {
      fit_.FitInk(task.reader, task.lens, task.start);
      // What ink moves hides what a shadow does.
      if (fit_.takes_out_light() && MayBeUnevenlyLit(task)) FitUnevenlyLit(task);
    }
  }
  return fit_.result().determined() ? &fit_.result() : nullptr;
}

bool PhotometricFit::FitAnew(const Task& task) {
  BoardFit::Start again = task.start;
  again.geometry = fit_.result().geometry;
  return fit_.Fit(task.reader, task.lens, again, choice_);
}

}  // namespace chequer
