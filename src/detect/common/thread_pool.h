#pragma once

#include <sched.h>

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace chequer {

/// Threads that work on one image together, the caller's among them. They sleep between runs, and wake on other
/// processors than the caller's, which is busy: Linux does not always look for an idle one. With two processors,
/// threads that woke shared their caller's for whole images while the other one slept (seen with Linux 6.18).
class ThreadPool {
 public:
  /// @param workers ≥ 1, the caller counted. @param on_start called first on each thread 1 … workers − 1, if given;
  /// must not throw. Throws std::system_error, and leaves no thread behind, where one cannot be started.
  explicit ThreadPool(int workers, std::function<void(int worker)> on_start = {});
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  int workers() const { return static_cast<int>(helpers_.size()) + 1; }
  /// Calls work(item, worker) once for every item 0 … count − 1, each worker 0 … workers() − 1 one item at a time;
  /// comes back when all are done. `work` must not throw.
  void Run(int count, const std::function<void(int item, int worker)>& work);

 private:
  struct Helper {
    std::thread thread;
    cpu_set_t given{}, left{};  ///< processors that it may run on: without, and with the caller's taken out
  };

  void Dismiss();
  /// @pre mutex_ is held.
  void KeepOffThisProcessor();
  void WaitForRuns(int worker);
  void TakeItems(int worker);

  std::mutex mutex_;
  std::condition_variable start_, done_;
  const std::function<void(int, int)>* work_ = nullptr;  ///< of the run under way
  int count_ = 0, next_ = 0;
  int run_ = 0;   ///< number of the run, so that a worker joins each once
  int busy_ = 0;  ///< threads that have not left the run
  bool stop_ = false;
  std::size_t begun_ = 0;  ///< helpers that wait for runs, or work
  std::vector<Helper> helpers_;
  int caller_cpu_ = -1;  ///< that the helpers keep off
};

}  // namespace chequer
