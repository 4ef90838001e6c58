#include "detect/board_fits.h"

#include <algorithm>
#include <functional>

#include "detect/camera_motion.h"

namespace chequer {
namespace {

/// Units of a board's plain fit at most, and for a pixel of its box (guesses).
constexpr double kUnitsOfPlain = 300, kUnitsOfPlainPixel = 0.15;
/// With a budget, after so many plain fits that found no board, one is fitted in full: what it shows of the image, as a
/// strong dot gain, lets plain fits find the others (a guess).
constexpr std::size_t kFruitlessFits = 2;

/// Units of a full fit of a board that moved, over those of a plain one (measured: 1.7, with 12 px cells).
constexpr std::uint64_t kFullOfPlain = 2;
/// Units of boards that moved, over those of the first one, of whose motion nothing was known (measured: 0.52 to 0.77,
/// 24 images of 50 boards that moved by 4 to 14 px).
constexpr double kOthersOfFirst = 2.0 / 3.0;
/// Largest corner error of the board that gives the traits of an image. Corners of boards in plain view lie on their
/// plane to 0.03 px, blurred ones to 0.06 px (measured).
constexpr double kMostOffOfFirst = 0.06;

/// To fit a board plainly.
FitTask TaskOf(const ImageJob& job, std::size_t board) {
  FitTask task{.board = board};
  if (!job.frame.plan.limited()) return task;
  const PixelBox& box = job.frame.boards[board].box;
  const double area = static_cast<double>(box.right - box.left) * (box.bottom - box.top);
  task.waited = job.undone.boards.Waited(box.Center());
  task.least = task.most = task.expected = static_cast<std::uint64_t>(kUnitsOfPlain + kUnitsOfPlainPixel * area);
  return task;
}

void DeferTask(const ImageJob& job, const FitTask& task) {
  job.Defer(job.frame.boards[task.board].box, task.waited, job.undone.boards);
  job.frame.outcomes[task.board].deferred = true;
}

/// Whether what a fitted board says of the image holds for others. One that was predicted may have been fitted where
/// something else lies.
bool TellsTraits(const ImageState& frame, std::size_t board) {
  return !frame.IsExpected(board) ||
         (frame.WasRead(board) && frame.outcomes[board].marker.reprojection_rms_px <= kMostOffOfFirst);
}

/// Hands on to the others of the image what the first of these boards shows of it: all of it, or motion and dot gain.
void ShareTraits(std::span<const FitTask> round, ImageState& frame) {
  for (const FitTask& task : round) {
    const BoardOutcome& outcome = frame.outcomes[task.board];
    if (!outcome.accepted) continue;
    if (!frame.traits) {
      if (TellsTraits(frame, task.board)) frame.traits = outcome.image;
      continue;
    }
    ImageTraits& traits = *frame.traits;
    if (traits.motion_px.isZero()) traits.motion_px = outcome.image.motion_px;
    // Blur and noise, too: plain fits have taken a part of the dot gain for them.
    if (traits.motion_px.isZero() && traits.dot_gain == 0 && outcome.image.dot_gain != 0) traits = outcome.image;
  }
}

/// Makes the topmost board's the first task, unless others wait.
void LeadWithTopmost(const ImageState& frame, std::span<FitTask> tasks) {
  if (tasks[0].waited > 0) return;
  const std::size_t topmost =
      frame.Topmost(frame.boards.size(), [&](std::size_t i) { return ShowsAllCorners(frame.boards[i]); });
  const auto lead =
      std::find_if(tasks.begin(), tasks.end(), [&](const FitTask& task) { return task.board == topmost; });
  if (lead != tasks.end()) std::iter_swap(tasks.begin(), lead);
}

/// Whether a board that was expected, and that a plain fit does not explain, may be blurred by motion.
bool MayHaveMovedFar(const ImageState& frame, std::size_t board) {
  const BoardOutcome& outcome = frame.outcomes[board];
  if (!frame.IsExpected(board) || !outcome.wants_more) return false;
  if (!outcome.accepted) return frame.stream.IsKnocked();
  // Of a long way, the plain model takes the blur for too narrow.
  const double blur_px = std::max(outcome.image.blur_px, outcome.motion.BlurPx(0));
  return BoardFit::MayBeMotion(blur_px, BoardGeometry(outcome.plane_from_board).CellSide());
}

/// Whether the budget lasts for so many boards that each take so many units.
bool Lasts(const ImageState& frame, std::size_t boards, std::uint64_t each) {
  return boards * each <= frame.plan.Left(frame.work.units());
}

/// Whether the middle of a board lies on one of the boards from `first` to before `past` that was read and needs no
/// other fit.
bool WasReadAt(const ImageState& frame, std::size_t board, std::size_t first, std::size_t past) {
  for (std::size_t i = first; i < past; ++i) {
    const BoardOutcome& outcome = frame.outcomes[i];
    if (outcome.is_read() && !outcome.wants_more && LiesOn(frame.boards[board], frame.boards[i])) return true;
  }
  return false;
}

/// Whether it lies on a board that was expected and waits for another fit.
bool WaitsAt(const ImageState& frame, std::size_t board) {
  for (std::size_t i = 0; i < frame.expected.size(); ++i)
    if (frame.outcomes[i].wants_more && LiesOn(frame.boards[board], frame.boards[i])) return true;
  return false;
}

const ImageTraits* PointerTo(const std::optional<ImageTraits>& traits) { return traits ? &*traits : nullptr; }

}  // namespace

BoardFits::BoardFits(const DetectorOptions& options) : pool_(options.threads, options.on_thread_start) {
  for (int worker = 0; worker < pool_.workers(); ++worker) readers_.emplace_back(options);
}

void BoardFits::FitFrom(const ImageJob& job, std::size_t first) {
  ImageState& frame = job.frame;
  frame.outcomes.resize(frame.boards.size());
  const std::size_t tasks_before = tasks_->size();
  for (std::size_t i = first; i < frame.boards.size(); ++i)
    if (!frame.IsExpected(i) || !frame.stream.postponed[i]) tasks_->push_back(TaskOf(job, i));
  FitTasks(job, tasks_before);
}

void BoardFits::FitPostponed(const ImageJob& job) {
  const ImageState& frame = job.frame;
  // Some were tried before.
  std::erase_if(
      *tasks_, [&](const FitTask& task) { return frame.IsExpected(task.board) && frame.stream.postponed[task.board]; });
  const std::size_t tasks_before = tasks_->size();
  for (std::size_t i = 0; i < frame.expected.size(); ++i)
    if (frame.stream.postponed[i] && !frame.ReadElsewhere(i)) tasks_->push_back(TaskOf(job, i));
  FitTasks(job, tasks_before);
}

void BoardFits::FitTasks(const ImageJob& job, std::size_t first) {
  ImageState& frame = job.frame;
  const bool limited = frame.plan.limited();
  const std::span<FitTask> tasks = std::span(*tasks_).subspan(first);
  if (tasks.empty()) return;
  if (limited) SortByWaiting(tasks);
  if (first == 0 && frame.expected.empty()) LeadWithTopmost(frame, tasks);
  std::size_t done = FitFirst(job, tasks);
  const std::uint64_t last = done > 0 ? frame.outcomes[tasks[done - 1].board].work.units() : 0,
                      each = static_cast<std::uint64_t>(kOthersOfFirst * static_cast<double>(last));
  // Plain fits find few of the boards that moved far.
  const bool moved = ShowsMotion(frame) && Lasts(frame, tasks.size() - done, each);
  const bool plain_only = limited && !moved;
  if (limited && !plain_only)
    for (FitTask& task : tasks.subspan(done)) task.expected = std::max(task.expected, each);
  done += FitInRounds(job, plain_only, tasks.subspan(done));
  for (const FitTask& task : tasks.subspan(done)) DeferTask(job, task);
}

void BoardFits::FitOne(const ImageJob& job, const FitOrder& order) {
  job.frame.outcomes[order.board] = ReadBoard(job, order, readers_[0]);
  job.frame.work.Add(job.frame.outcomes[order.board].work);
}

std::size_t BoardFits::FitFirst(const ImageJob& job, std::span<FitTask> tasks) {
  // Noise is the camera's, and so is most of the blur: the first board that is accepted tells them to the others. It
  // measures the noise in every frame. With the noise of the last frame, poses with and without memory differ by 0.10
  // instead of 0.06 deviations (measured).
  ImageState& frame = job.frame;
  const bool limited = frame.plan.limited();
  std::size_t done = 0, fruitless = 0;
  // Of boards that a knocked camera shows, the one that goes first may be the sharpest.
  const auto ask_more = [&] {
    return limited && done < kFewestThatMoved && frame.stream.IsKnocked() && !ShowsMotion(frame);
  };
  while (done < tasks.size() && (!frame.traits || ask_more())) {
    const FitTask& task = tasks[done];
    if (GrantRound(frame.plan, frame.work.units(), done == 0, tasks.subspan(done, 1)) == 0) break;
    FitOne(job, {task.board, PointerTo(frame.known_traits), limited, task.granted});
    ++done;
    const BoardOutcome& outcome = frame.outcomes[task.board];
    if (!outcome.accepted && ++fruitless == kFruitlessFits && limited && frame.expected.empty()) FitFully(job, task);
    if (limited && fruitless <= kFruitlessFits && MayHaveMovedFar(frame, task.board) &&
        Lasts(frame, tasks.size() - done, kFullOfPlain * outcome.work.units()))
      FitFully(job, task);
    if (outcome.accepted && TellsTraits(frame, task.board)) frame.traits = outcome.image;
    LearnMotion(job, tasks.subspan(done - 1, 1));
  }
  return done;
}

void BoardFits::FitFully(const ImageJob& job, const FitTask& task) {
  const ImageState& frame = job.frame;
  const BoardOutcome& outcome = frame.outcomes[task.board];
  const std::uint64_t left = frame.plan.Left(frame.work.units()),
                      most = frame.plan.MostForFit(outcome.work.units(), true, left);
  if (outcome.wants_more && most <= left) FitOne(job, {task.board, nullptr, false, most});
}

std::size_t BoardFits::FitInRounds(const ImageJob& job, bool plain_only, std::span<FitTask> tasks) {
  ImageState& frame = job.frame;
  const auto fit_round = [&](std::span<const FitTask> round) {
    const auto fit_one = [&](int item, int worker) {
      const std::size_t i = static_cast<std::size_t>(item), later = i + readers_.size();
      if (later < round.size()) job.measured.Prefetch(frame.boards[round[later].board].box);
      frame.outcomes[round[i].board] =
          ReadBoard(job, {round[i].board, PointerTo(frame.traits), plain_only, round[i].granted},
                    readers_[static_cast<std::size_t>(worker)]);
    };
    // By reference: a copy would be allocated.
    pool_.Run(static_cast<int>(round.size()), std::ref(fit_one));
    for (const FitTask& task : round) frame.work.Add(frame.outcomes[task.board].work);
    ShareTraits(round, frame);
    if (!plain_only) LearnMotion(job, round);
  };
  return RunInRounds(
      frame.plan, !plain_only, ShowsMotion(frame), tasks, [&] { return frame.work.units(); }, fit_round);
}

void BoardFits::ChooseForRefining(const ImageJob& job) {
  ImageState& frame = job.frame;
  // What was expected in another picture is not worth a look, nor is what was found since then and read.
  const std::size_t expected = frame.expected.size(), gone = frame.IsAnotherPicture() ? expected : 0;
  std::erase_if(*tasks_, [&](const FitTask& task) {
    const BoardOutcome& outcome = frame.outcomes[task.board];
    return !outcome.wants_more || outcome.deferred || (task.board < gone && !outcome.accepted) ||
           (task.board < expected && WasReadAt(frame, task.board, expected, frame.boards.size()));
  });
  for (FitTask& task : *tasks_) {
    const BoardOutcome& outcome = frame.outcomes[task.board];
    task.unclear = !outcome.is_read();
    task.most = outcome.work.units();
    task.least = WorkPlan::kLeastOfPlain * task.most;
    task.expected = WorkPlan::kMostOfPlain * task.most;
  }
}

void BoardFits::RefuseReadElsewhere(const ImageJob& job, std::size_t first) {
  const auto refuse = [&](const FitTask& task) {
    if (!WasReadAt(job.frame, task.board, 0, job.frame.expected.size())) return false;
    job.frame.outcomes[task.board].accepted = false;
    job.tracer.Refuse(task.board, Refusal::kSeenTwice);
    return true;
  };
  tasks_->erase(std::remove_if(tasks_->begin() + static_cast<std::ptrdiff_t>(first), tasks_->end(), refuse),
                tasks_->end());
}

void BoardFits::Refine(const ImageJob& job) {
  ImageState& frame = job.frame;
  ChooseForRefining(job);
  std::vector<FitTask>& tasks = *tasks_;
  // Of a board that was expected and found again, only one needs to be fitted.
  const bool another_picture = frame.IsAnotherPicture();
  const auto twins = std::partition(tasks.begin(), tasks.end(), [&](const FitTask& task) {
    return frame.IsExpected(task.board) || another_picture || !WaitsAt(frame, task.board);
  });
  const std::size_t first = static_cast<std::size_t>(twins - tasks.begin());
  SortByWorth(std::span(tasks).first(first));
  std::size_t done = FitInRounds(job, false, std::span(tasks).first(first));
  const auto lasts = [&] { return tasks[first].expected <= frame.plan.Left(frame.work.units()); };
  if (done == first && first < tasks.size() && (first == 0 || lasts())) {
    RefuseReadElsewhere(job, first);
    SortByWorth(std::span(tasks).subspan(first));
    done += FitInRounds(job, false, std::span(tasks).subspan(first));
  }
  for (const FitTask& task : std::span(tasks).subspan(done)) {
    BoardOutcome& outcome = frame.outcomes[task.board];
    outcome.plain_covariance = true;
    DeferTask(job, task);
  }
}

}  // namespace chequer
