#pragma once

#include <string>
#include <vector>

namespace chequer {

/// Where and how urgently the pipeline's threads run.
struct SchedulingOptions {
  /// Worker i runs on cpus[i modulo their number] alone; empty: wherever the system puts it. Where several threads work
  /// on one frame, thread j of worker i runs on cpus[(i + j · workers) modulo their number], or on the next where that
  /// is its worker's.
  std::vector<int> cpus;
  /// SCHED_FIFO priority of the workers and of the threads that help them, 1..98; capturing and publishing, which are
  /// short and must not wait for them, run one above. 0: none asked for.
  int realtime_priority = 0;
};

/// The processor of a worker, or of a thread that helps it. @pre options.cpus is not empty.
int CpuOf(const SchedulingOptions& options, int worker, int thread = 0, int workers = 1);

/// Throws std::runtime_error, naming those that are there, where one of the processors does not exist or may not be
/// used by this process.
void CheckCpus(const std::vector<int>& cpus);

/// Makes the calling thread run on one processor. Empty, or why it does not.
std::string PinThisThread(int cpu);

/// What a thread that helps a worker does first: it takes a name, and becomes as urgent as the worker, who waits for
/// it. What is refused was refused to the worker too, who has told of it.
void BecomeHelper(const SchedulingOptions& options, int worker, int thread, int workers);

/// Makes the calling thread run under SCHED_FIFO. Empty, or why it does not and what would allow it.
std::string MakeThisThreadRealtime(int priority);

}  // namespace chequer
