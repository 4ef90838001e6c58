#include "detect/fit/fit.h"

#include <algorithm>

#include "detect/fit/motion_blur.h"

namespace chequer {
namespace {

/// Corners of boards that moved lie where a plane has them to 0.03 px; farther off, it may have been something else;
/// and where a motion is all that may be, so far at most.
constexpr double kMostOffMovedPx = 0.04, kMostOffMotionBlurredPx = 0.15;
/// Units that all fits of a board may take, for a corner, whatever it shows: boards that are blurred and crossed by a
/// shadow, the hardest that are read, take half of them. No other fit is begun once so much of them is spent.
constexpr std::uint64_t kMostUnitsOfCorner = 6000;
constexpr double kLastBegun = 0.6;

}  // namespace

const FittedBoard* PhotometricFit::Fit(const LightReader& reader, const Lens& lens, const Start& start) {
  BoardFit::Start board = start.board;
  const std::uint64_t most = kMostUnitsOfCorner * static_cast<std::uint64_t>(CornerCount(board.size));
  board.most_units = most;
  const Task task{reader, lens, board};
  fit_.StartWork();
  wants_more_ = cut_short_ = false;
  most_units_ = std::min(start.most_units, static_cast<std::uint64_t>(kLastBegun * static_cast<double>(most)));
  return start.plain_only ? FitPlain(task, start.motion_blurred) : FitFully(task, start.motion_blurred);
}

bool PhotometricFit::UseLearntLevels(const FittedBoard& fitted, LearntBoard& learnt) {
  fit_.StartWork();
  return &fitted == &fit_.result() && !wants_more_ && !cut_short_ && fit_.UseLearntLevels(learnt);
}

bool PhotometricFit::FitOnce(const Task& task, const BoardFit::Start& start) {
  cut_short_ = cut_short_ || units() > most_units_;
  return !cut_short_ && fit_.Fit(task.reader, task.lens, start, choice_);
}

const FittedBoard* PhotometricFit::FitPlain(const Task& task, bool motion_blurred) {
  choice_ = {};
  choice_.may_move = choice_.may_look_farther = false;
  const bool fitted = FitOnce(task, task.start);
  wants_more_ = !fitted || motion_blurred || !fit_.result().flat() || fit_.may_look_farther() ||
                AnyOf(fit_.Occluded()) || MayBeUnevenlyLit(task) || fit_.FindHighlight(task.start.saturated);
  return fitted ? &fit_.result() : nullptr;
}

const FittedBoard* PhotometricFit::FitFully(const Task& task, bool motion_blurred) {
  if (const FittedBoard* fitted = motion_blurred ? nullptr : FitAsItIs(task, Eigen::Vector2d::Zero())) return fitted;
  // Others of the image may have shown how it moved.
  if (motion_blurred && task.start.image && !task.start.image->motion_px.isZero()) {
    const FittedBoard* fitted = FitAsItIs(task, task.start.image->motion_px);
    if (fitted && fitted->reprojection_rms_px <= kMostOffMotionBlurredPx) return fitted;
  }
  // What runs away may have moved so far that the plain model does not come near it.
  const MotionBlurs motion_blurs = FindMotionBlurs(task.reader, task.lens, task.start.size, task.start.geometry);
  bool found = false;
  for (std::size_t i = 0; i < motion_blurs.count; ++i) {
    const FittedBoard* fitted = FitAsItIs(task, motion_blurs.by_px[i]);
    if (!fitted || fitted->reprojection_rms_px > kMostOffMotionBlurredPx) continue;
    if (found && !Better(fitted->explained, best_.explained, Hypothesis::kOtherMotion)) continue;
    best_ = *fitted;
    found = true;
  }
  return found ? &best_ : nullptr;
}

bool PhotometricFit::FitFirst(const Task& task, const Eigen::Vector2d& motion_blur_px) {
  choice_ = {};
  choice_.terms.motion_px = motion_blur_px;
  choice_.roughly = true;
  // One printer's ink spreads alike.
  const ImageTraits* image = task.start.image;
  if (motion_blur_px.isZero() && image && image->shares_dot_gain()) choice_.terms.dot_gain = image->dot_gain;
  bool fitted = FitOnce(task, task.start);
  if (!fitted && choice_.terms.dot_gain != 0) {
    choice_.terms.dot_gain = 0;
    fitted = FitOnce(task, task.start);
  }
  // A rough fit shows uneven illumination as well as a close one.
  if (!fitted || (fit_.rough() && fit_.motion_px().isZero() && MayBeUnevenlyLit(task))) return fitted;
  return fit_.FitClosely(task.reader, task.lens, task.start);
}

const FittedBoard* PhotometricFit::FitAsItIs(const Task& task, const Eigen::Vector2d& motion_blur_px) {
  const bool fitted = FitFirst(task, motion_blur_px);
  const bool moved = motion_blur_px.isZero() && fitted && !fit_.motion_px().isZero();
  const double off_px = fit_.result().reprojection_rms_px;
  if (moved && fit_.sure_of_motion() && off_px <= kMostOffMotionBlurredPx) return &fit_.result();
  if (moved && off_px <= kMostOffMovedPx && !AnyOf(fit_.Occluded())) return &fit_.result();
  // Shadows and ink make edges uneven, too; what seemed to have moved and did not fit may fit as it stands.
  if (moved) Keep(moved_);
  const bool again = motion_blur_px.isZero() && fit_.looks_farther() && (moved || !fitted);
  if (again) choice_.may_move = false;
  if (again ? !FitOnce(task, task.start) : !fitted) return moved ? &moved_.run.result : nullptr;
  // A motion mixes light cells into dark ones, which a highlight would explain in part.
  if (moved || !fit_.motion_px().isZero() || !FitHighlight(task)) ChooseTerms(task);
  if (moved && !BetterThan(moved_, Hypothesis::kNoMotion)) Restore(moved_);
  if (!fit_.result().determined()) return nullptr;
  LeaveOutPulled(task);
  return &fit_.result();
}

void PhotometricFit::ChooseTerms(const Task& task) {
  if (!fit_.looks_farther()) LeaveOutOccluded(task);
  const bool rough = fit_.rough(), off_before = !fit_.result().flat() && fit_.motion_px().isZero();
  const bool side = off_before && !rough && LeaveOutSide(task);
  // What ink moves hides what a shadow does.
  if (off_before && !rough && !side) fit_.FitDotGain(task.reader, task.lens, task.start);
  const bool uneven = MayBeUnevenlyLit(task) && FitUnevenlyLit(task);
  fit_.FitClosely(task.reader, task.lens, task.start);
  if (rough && !uneven && !fit_.result().flat() && fit_.motion_px().isZero())
    fit_.FitDotGain(task.reader, task.lens, task.start);
}

void PhotometricFit::Restore(const Kept& kept) {
  fit_.Restore(kept.run);
  choice_ = kept.choice;
}

bool PhotometricFit::Refit(const Task& task) {
  BoardFit::Start again = task.start;
  again.predicted = false;
  again.geometry = fit_.result().geometry;
  choice_.terms.motion_px = fit_.motion_px();
  return FitOnce(task, again);
}

}  // namespace chequer
