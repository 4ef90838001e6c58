#include "detect/common/thread_pool.h"

#include <pthread.h>

namespace chequer {

ThreadPool::ThreadPool(int workers, std::function<void(int)> on_start) {
  try {
    for (int worker = 1; worker < workers; ++worker)
      helpers_.push_back({.thread = std::thread([this, worker, on_start] {
                            if (on_start) on_start(worker);
                            WaitForRuns(worker);
                          })});
  } catch (...) {
    Dismiss();
    throw;
  }
}

ThreadPool::~ThreadPool() { Dismiss(); }

void ThreadPool::Dismiss() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  start_.notify_all();
  for (Helper& helper : helpers_) helper.thread.join();
  helpers_.clear();
}

void ThreadPool::KeepOffThisProcessor() {
  const int cpu = sched_getcpu();
  if (cpu == caller_cpu_ || cpu < 0 || cpu >= CPU_SETSIZE) return;
  caller_cpu_ = cpu;
  for (Helper& helper : helpers_) {
    const pthread_t thread = helper.thread.native_handle();
    cpu_set_t set;
    if (pthread_getaffinity_np(thread, sizeof set, &set) != 0) continue;  // more processors than the set has room for
    // Who else has set it in the meantime is obeyed.
    if (!CPU_EQUAL(&set, &helper.left)) helper.given = set;
    set = helper.given;
    CPU_CLR(static_cast<unsigned>(cpu), &set);
    if (CPU_COUNT(&set) == 0) set = helper.given;
    helper.left = set;
    pthread_setaffinity_np(thread, sizeof set, &set);
  }
}

void ThreadPool::Run(int count, const std::function<void(int, int)>& work) {
  if (helpers_.empty() || count < 2) {
    for (int item = 0; item < count; ++item) work(item, 0);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    // Before, it might undo what on_start asks for.
    if (begun_ == helpers_.size()) KeepOffThisProcessor();
    work_ = &work;
    count_ = count;
    next_ = 0;
    busy_ = static_cast<int>(helpers_.size());
    ++run_;
  }
  start_.notify_all();
  TakeItems(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return busy_ == 0; });
  work_ = nullptr;
}

void ThreadPool::TakeItems(int worker) {
  while (true) {
    int item = 0;
    {
      const std::lock_guard lock(mutex_);
      if (next_ >= count_) return;
      item = next_++;
    }
    (*work_)(item, worker);
  }
}

void ThreadPool::WaitForRuns(int worker) {
  int seen = 0;
  std::unique_lock lock(mutex_);
  ++begun_;
  while (true) {
    start_.wait(lock, [&] { return stop_ || run_ != seen; });
    if (stop_) return;
    seen = run_;
    lock.unlock();
    TakeItems(worker);
    lock.lock();
    if (--busy_ == 0) done_.notify_one();
  }
}

}  // namespace chequer
