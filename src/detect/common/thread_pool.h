#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace chequer {

/// Threads that work on one image together, the caller's among them. They sleep between runs.
class ThreadPool {
 public:
  /// @param workers ≥ 1, the caller counted. @param on_start called first on each thread 1 … workers − 1, if given;
  /// must not throw. Throws std::system_error, and leaves no thread behind, where one cannot be started.
  explicit ThreadPool(int workers, std::function<void(int worker)> on_start = {});
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool();

  int workers() const { return static_cast<int>(threads_.size()) + 1; }
  /// Calls work(item, worker) once for every item 0 … count − 1, each worker 0 … workers() − 1 one item at a time;
  /// comes back when all are done. `work` must not throw.
  void Run(int count, const std::function<void(int item, int worker)>& work);

 private:
  void Dismiss();
  void WaitForRuns(int worker);
  void TakeItems(int worker);

  std::mutex mutex_;
  std::condition_variable start_, done_;
  const std::function<void(int, int)>* work_ = nullptr;  ///< of the run under way
  int count_ = 0, next_ = 0;
  int run_ = 0;   ///< number of the run, so that a worker joins each once
  int busy_ = 0;  ///< threads that have not left the run
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace chequer
