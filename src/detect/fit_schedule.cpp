#include "detect/fit_schedule.h"

namespace chequer {

std::size_t GrantRound(const WorkPlan& plan, std::uint64_t spent, bool at_least_one, std::span<FitTask> tasks,
                       bool in_full) {
  if (!plan.limited()) return tasks.size();
  std::size_t count = 0;
  for (; count < tasks.size(); ++count) {
    FitTask& task = tasks[count];
    const std::uint64_t left = plan.Left(spent);
    task.granted = plan.MostForFit(task.most, in_full, left);
    if (task.expected > left) {
      if (!(at_least_one && count == 0)) break;
      task.granted = std::max(task.least, std::min(task.granted, left));
    }
    spent += task.expected;
  }
  return count;
}

void ExpectAsMuch(std::span<const FitTask> done, std::uint64_t took, std::span<FitTask> others) {
  std::uint64_t expected = 0;
  for (const FitTask& task : done) expected += task.expected;
  if (expected == 0) return;
  // Boards differ.
  const std::uint64_t with_margin = took + took / 4;
  for (FitTask& task : others) task.expected = std::max<std::uint64_t>(task.expected * with_margin / expected, 1);
}

}  // namespace chequer
