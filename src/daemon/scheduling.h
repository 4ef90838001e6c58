#pragma once

#include <string>
#include <vector>

namespace chequer {

/// Where and how urgently the pipeline's threads run.
struct SchedulingOptions {
  /// Worker i runs on cpus[i modulo their number] alone; empty: wherever the system puts it.
  std::vector<int> cpus;
  /// SCHED_FIFO priority of the workers, 1..98; capturing and publishing, which are short and must not wait for them,
  /// run one above. 0: none asked for.
  int realtime_priority = 0;
};

/// Throws std::runtime_error, naming those that are there, where one of the processors does not exist or may not be
/// used by this process.
void CheckCpus(const std::vector<int>& cpus);

/// Makes the calling thread run on one processor. Empty, or why it does not.
std::string PinThisThread(int cpu);

/// Makes the calling thread run under SCHED_FIFO. Empty, or why it does not and what would allow it.
std::string MakeThisThreadRealtime(int priority);

}  // namespace chequer
