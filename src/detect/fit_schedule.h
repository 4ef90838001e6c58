#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>

#include "detect/work_plan.h"

namespace chequer {

/// A board that is to be fitted.
struct FitTask {
  std::size_t board = 0;
  int waited = 0;                 ///< images on end in which it was left undone
  bool unclear = false;           ///< it has no pose or no id yet
  std::uint64_t most = 0;         ///< units that its plain fit may take, if there are as many
  std::uint64_t expected = 0;     ///< that it will take, by what others took
  std::uint64_t least = 0;        ///< that it is granted if it is done in any case
  std::uint64_t granted = ~0ull;  ///< that it may take
};

/// The longest waiting first.
inline void SortByWaiting(std::span<FitTask> tasks) {
  // Not stable_sort, which allocates.
  std::sort(tasks.begin(), tasks.end(), [](const FitTask& a, const FitTask& b) {
    return std::tuple(b.waited, a.board) < std::tuple(a.waited, b.board);
  });
}

/// A board without a pose or an id goes before boards that have waited for fewer images than it plus this number (a
/// guess).
inline constexpr int kUnclearFirst = 4;

/// The longest waiting first, of alike ones those that say least so far, then the cheapest.
inline void SortByWorth(std::span<FitTask> tasks) {
  const auto turn = [](const FitTask& task) { return task.waited + (task.unclear ? kUnclearFirst : 0); };
  std::sort(tasks.begin(), tasks.end(), [&](const FitTask& a, const FitTask& b) {
    return std::tuple(turn(b), b.unclear, a.most, a.board) < std::tuple(turn(a), a.unclear, b.most, b.board);
  });
}

/// Tasks of the first round: one, as it shows what the others take.
inline constexpr std::size_t kFewAtOnce = 1;

/// Where tasks took more than was expected of them, or less, expects it of the others by as much and some more.
void ExpectAsMuch(std::span<const FitTask> done, std::uint64_t took, std::span<FitTask> others);

/// Of tasks that are done in their order, how many the budget lasts for at once if each takes what is expected. Grants
/// each of them its units. So what is begun does not depend on how many threads share the work, nor on which is first.
/// @param spent on the image so far. @param at_least_one whether the first is granted its least in any case.
/// @param in_full whether boards are fitted in full.
std::size_t GrantRound(const WorkPlan& plan, std::uint64_t spent, bool at_least_one, std::span<FitTask> tasks,
                       bool in_full = false);

/// Of tasks, the first ones that are unclear, or those that are not.
inline std::span<FitTask> FirstAlike(std::span<FitTask> tasks) {
  const auto end = std::find_if(tasks.begin(), tasks.end(),
                                [&](const FitTask& task) { return task.unclear != tasks.front().unclear; });
  return tasks.first(static_cast<std::size_t>(end - tasks.begin()));
}

/// Runs tasks in rounds for as long as the budget lasts: run(round) does the tasks of a round and returns when all are
/// done; spent() is what the image took so far. Returns how many were run. Rounds begin with one task and grow, as each
/// shows what is to be expected of the next; and begin anew where tasks are clear that were not before: they take more.
/// @param in_full whether boards are fitted in full: then one is, in any case, so that there is an end to waiting
/// however small the budget is. @param learning whether rounds show also how the next are best fitted.
template <class Spent, class Run>
std::size_t RunInRounds(const WorkPlan& plan, bool in_full, bool learning, std::span<FitTask> tasks, const Spent& spent,
                        const Run& run) {
  std::size_t done = 0, at_once = plan.limited() || learning ? kFewAtOnce : tasks.size();
  for (; done < tasks.size(); at_once *= 2) {
    const std::uint64_t before = spent();
    if (plan.limited() && done > 0 && tasks[done].unclear != tasks[done - 1].unclear) at_once = kFewAtOnce;
    std::span<FitTask> next = tasks.subspan(done, std::min(at_once, tasks.size() - done));
    if (plan.limited()) next = FirstAlike(next);
    const std::size_t granted = GrantRound(plan, before, in_full && done == 0, next, in_full);
    if (granted == 0) break;
    run(next.first(granted));
    done += granted;
    ExpectAsMuch(next.first(granted), spent() - before, tasks.subspan(done));
  }
  return done;
}

}  // namespace chequer
