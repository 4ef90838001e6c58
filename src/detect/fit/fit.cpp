#include "detect/fit/fit.h"

#include <algorithm>

#include "detect/fit/motion_blur.h"

namespace chequer {
namespace {

/// Where a motion is all that may be, corners lie so far off at most.
constexpr double kMostOffMotionBlurredPx = 0.15;
/// Boards that moved lose .2 and more of the score where they are fitted with another motion.
constexpr double kMotionsByChance = 0;
/// Units that all fits of a board may take, for a corner, whatever it shows: boards that are blurred and crossed by a
/// shadow, the hardest that are read, take half of them. No other fit is begun once so much of them is spent.
constexpr std::uint64_t kMostUnitsOfCorner = 6000;
constexpr double kLastBegun = 0.6;

/// Without corners that are pulled, others may return that are pulled too; a third round finds none (measured, under
/// hands on all boards: poses with and without memory differ by 0.15 instead of 0.22 deviations).
constexpr int kRoundsOfPulled = 2;

/// Whether the blur of a motion that others show is so wide that a plain fit would ask for it.
bool WouldBeFound(const PhotometricFit::Start& start) {
  if (start.motion.way_px.isZero() || !start.board.image) return false;
  return BoardFit::MayBeMotion(start.motion.BlurPx(start.board.image->blur_px), start.board.geometry.CellSide());
}

}  // namespace

const FittedBoard* PhotometricFit::Fit(const LightReader& reader, const Lens& lens, const Start& start) {
  BoardFit::Start board = start.board;
  const std::uint64_t most = kMostUnitsOfCorner * static_cast<std::uint64_t>(CornerCount(board.size));
  board.most_units = std::min(most, start.most_units);
  const Task task{reader, lens, board};
  fit_.StartWork();
  wants_more_ = cut_short_ = lies_elsewhere_ = false;
  most_units_ = std::min(start.most_units, static_cast<std::uint64_t>(kLastBegun * static_cast<double>(most)));
  return start.plain_only ? FitPlain(task, start.motion_blurred) : FitFully(task, start);
}

bool PhotometricFit::UseLearntLevels(const FittedBoard& fitted, LearntBoard& learnt) {
  fit_.StartWork();
  return HasAllOf(fitted) && fit_.UseLearntLevels(learnt);
}

bool PhotometricFit::StepOn(const LightReader& reader, const Lens& lens, const FittedBoard& fitted) {
  fit_.StartWork();
  if (!HasAllOf(fitted) || fit_.looks_farther() || !fit_.EndsRoughly()) return false;
  BoardRun& before = kept_[0].run;
  before = fit_.run();
  if (fit_.StepOn(reader, lens, made_.start)) return true;
  fit_.Restore(before);
  return false;
}

void PhotometricFit::FitWithout(const LightReader& reader, const Lens& lens, const FittedBoard& fitted,
                                const Visibility& shows) {
  const std::uint64_t spent = units();
  fit_.StartWork();
  if (!HasAllOf(fitted) || spent >= made_.start.most_units || !AnyUsedBesideHidden(shows)) return;
  most_units_ = made_.start.most_units - spent;
  // Finish() goes back to the first.
  TryRefit(kept_[1], [&](const BoardRun& before) {
    made_.start.most_units = most_units_;
    made_.start.visibility.TakeCellsOf(shows);
    made_.BeginAt(before.result.geometry, fit_.dot_gain());
    made_.choice.from = fit_.looks_farther() ? &before : nullptr;
    const Task task{reader, lens, made_.start};
    if (!FitOnce(task) || !fit_.FitClosely(reader, lens, made_.start) || !fit_.result().determined()) return false;
    Finish(task);
    return true;
  });
}

bool PhotometricFit::AnyUsedBesideHidden(const Visibility& shows) const {
  if (shows.ShowsAll()) return false;
  for (int corner = 0; corner < fit_.corners(); ++corner)
    if (fit_.used(corner) && shows.LiesBesideHidden(corner)) return true;
  return false;
}

template <class Refit>
bool PhotometricFit::TryRefit(Kept& before, const Refit& refit) {
  before.run = fit_.run();
  before.made = made_;
  const bool done = refit(before.run);
  if (done) {
    fit_.RestoreCells(before.run.result);
  } else {
    fit_.Restore(before.run);
    made_ = before.made;
  }
  return done;
}

bool PhotometricFit::FitOnce(const Task& task) {
  cut_short_ = cut_short_ || units() > most_units_;
  return !cut_short_ && fit_.Fit(task.reader, task.lens, made_.start, made_.choice);
}

const FittedBoard* PhotometricFit::FitPlain(const Task& task, bool motion_blurred) {
  made_ = {.start = task.start, .choice = {}};
  made_.choice.may_move = made_.choice.may_look_farther = false;
  made_.choice.terms.dot_gain = task.start.dot_gain;
  tried_ = {};
  const bool fitted = FitOnce(task);
  if (fitted) fit_.TellDoubt();
  wants_more_ =
      !fitted || motion_blurred || !fit_.result().flat() || fit_.may_look_farther() || FindNext() < Hypotheses().size();
  return fitted ? &fit_.result() : nullptr;
}

const FittedBoard* PhotometricFit::FitFully(const Task& task, const Start& start) {
  if (start.motion_blurred ? !start.motion.way_px.isZero() : WouldBeFound(start)) {
    const FittedBoard* fitted = FitFrom(task, start.motion);
    if (fitted && fitted->reprojection_rms_px <= kMostOffMotionBlurredPx) return fitted;
  }
  if (const FittedBoard* fitted = start.motion_blurred ? nullptr : FitFrom(task, {})) return fitted;
  // The plain model comes near a board that was expected, however it moved, unless it lies elsewhere (of 20,000 boards
  // in streams, of 380 that it did not come near, other fits found 6, for 6,000 units each).
  lies_elsewhere_ = start.may_lie_elsewhere && !start.motion_blurred;
  if (lies_elsewhere_) return nullptr;
  // What runs away may have moved so far that the plain model does not come near it.
  const MotionBlurs motion_blurs = FindMotionBlurs(task.reader, task.lens, task.start.size, task.start.geometry);
  bool found = false;
  for (std::size_t i = 0; i < motion_blurs.count; ++i) {
    const FittedBoard* fitted = FitFrom(task, {motion_blurs.by_px[i], 0});
    if (!fitted || fitted->reprojection_rms_px > kMostOffMotionBlurredPx) continue;
    if (found && !Better(fitted->explained, best_.explained, kMotionsByChance)) continue;
    best_ = *fitted;
    found = true;
  }
  return found ? &best_ : nullptr;
}

bool PhotometricFit::FitFirst(const Task& task, const BlurShape& motion, bool may_move) {
  made_ = {.start = task.start, .choice = {}};
  made_.choice.terms.motion_px = motion.way_px;
  made_.choice.terms.turn = motion.turn;
  made_.choice.roughly = true;
  made_.choice.may_move = may_move;
  tried_ = {};
  kept_count_ = 0;
  // One printer's ink spreads alike.
  made_.choice.terms.dot_gain = task.start.dot_gain;
  if (FitOnce(task)) return true;
  if (made_.choice.terms.dot_gain == 0) return false;
  made_.choice.terms.dot_gain = 0;
  return FitOnce(task);
}

const FittedBoard* PhotometricFit::FitFrom(const Task& task, const BlurShape& motion) {
  bool fitted = FitFirst(task, motion, true) && Explain(task);
  // What runs away with a motion may have stood.
  if (!fitted && motion.way_px.isZero() && fit_.looks_farther())
    fitted = FitFirst(task, motion, false) && Explain(task);
  if (!fitted) return nullptr;
  Finish(task);
  return &fit_.result();
}

bool PhotometricFit::Explain(const Task& task) {
  for (;;) {
    const std::size_t next = FindNext();
    if (next < Hypotheses().size())
      Try(task, next);
    else if (kept_count_ > 0 && !Holds())
      GoBack();
    else if (!fit_.rough() && kept_count_ == 0)
      return fit_.result().determined();
    else if (!fit_.rough())
      --kept_count_;
    // What is kept is fitted closely, which may call for more.
    else if (fit_.FitClosely(task.reader, task.lens, made_.start))
      continue;
    else if (kept_count_ > 0)
      GoBack();
    else
      return false;
  }
}

std::size_t PhotometricFit::FindNext() const {
  const std::span<const Hypothesis> all = Hypotheses();
  const int room = static_cast<int>(kept_.size()) - kept_count_;
  // A detour needs it for what goes on from it, too.
  const auto has_room = [&](const Hypothesis& of) { return room > (of.path == Hypothesis::Path::kDetour ? 1 : 0); };
  std::size_t next = 0;
  while (next < all.size() && (tried_[next] || !has_room(all[next]) || !all[next].calls(fit_, made_))) ++next;
  return next;
}

void PhotometricFit::Try(const Task& task, std::size_t hypothesis) {
  const Hypothesis& tried = Hypotheses()[hypothesis];
  tried_[hypothesis] = true;
  Kept& before = kept_[static_cast<std::size_t>(kept_count_++)];
  before.run = fit_.run();
  before.made = made_;
  before.tried = tried_;
  before.left_for = &tried;
  tried_ = {};
  made_.BeginAt(fit_.result().geometry, fit_.dot_gain());
  made_.choice.from = fit_.looks_farther() ? &before.run : nullptr;
  if (!tried.start({task.reader, task.lens, task.start, fit_, before.run, traits_}, made_)) return GoBack();
  // Both are compared by the same pixels; what starts the trial may have changed the fit.
  fit_.Restore(before.run);
  fit_.ExplainFew(task.reader, task.lens, before.made.start);
  before.run = fit_.run();
  if (!FitOnce(task)) return GoBack();
  fit_.ExplainFew(task.reader, task.lens, made_.start);
  if (tried.path == Hypothesis::Path::kDetour) return;
  const int others = tried.path == Hypothesis::Path::kArrival ? 2 : 1;
  const auto wins = [&] { return tried.holds(fit_) && Beats(others, Better, tried.most_by_chance); };
  const auto may_win = [&] { return tried.holds(fit_) && Beats(others, MayBeBetter, tried.most_by_chance); };
  // Rough fits compare with each other; what replaces a close one is fitted closely, too.
  const bool better = (before.run.terms.rough && wins()) ||
                      (may_win() && fit_.FitClosely(task.reader, task.lens, made_.start) && wins());
  if (!better) return GoBack();
  kept_count_ -= others;
}

bool PhotometricFit::Beats(int others, Compare better, double most_by_chance) const {
  const auto last = kept_.begin() + kept_count_;
  return std::all_of(last - others, last, [&](const Kept& other) {
    return better(fit_.result().explained, other.run.result.explained, most_by_chance);
  });
}

bool PhotometricFit::Holds() const {
  const Kept& before = kept_[static_cast<std::size_t>(kept_count_ - 1)];
  const bool may_gain = fit_.rough() && !before.run.terms.rough;
  return before.left_for->holds(fit_) && Beats(1, may_gain ? MayBeBetter : Better, before.left_for->most_by_chance);
}

void PhotometricFit::GoBack() {
  const Kept& before = kept_[static_cast<std::size_t>(--kept_count_)];
  fit_.Restore(before.run);
  made_ = before.made;
  tried_ = before.tried;
}

void PhotometricFit::Finish(const Task& task) {
  LeaveOutPulled(task);
  KeepOffWhatHides(task);
  fit_.TellDoubt();
}

void PhotometricFit::LeaveOutPulled(const Task& task) {
  if (fit_.looks_farther() || !fit_.result().flat()) return;
  if (!fit_.AnyUnused() || (!AnyOf(fit_.Occluded()) && !AnyOf(fit_.Pulled()))) return;
  // Occluded corners shifted the fit until they were found, and the pulled ones are those that disagree with where it
  // ends. So it goes on without them before they are looked for (measured, under hands: poses with and without memory
  // differ by 0.12 standard deviations; without this, by 0.20).
  BoardRun& occluded = kept_[0].run;
  occluded = fit_.run();
  if (!fit_.FitAnew(task.reader, task.lens, made_.start)) fit_.Restore(occluded);
  for (int round = 0; round < kRoundsOfPulled; ++round) {
    const CornerFlags pulled = fit_.Pulled();
    if (!AnyOf(pulled)) return;
    const bool done = TryRefit(kept_[0], [&](const BoardRun& before) {
      made_.LeaveOut(pulled, Hidden::kPulled);
      made_.BeginAt(before.result.geometry, before.model.dot_gain);
      return FitOnce(task);
    });
    if (!done) return;
  }
}

void PhotometricFit::KeepOffWhatHides(const Task& task) {
  if (!fit_.AnyBesideHidden()) return;
  TryRefit(kept_[0], [&](const BoardRun&) { return fit_.FitBesideHidden(task.reader, task.lens, made_.start); });
}

}  // namespace chequer
