#include "detect/common/thread_pool.h"

namespace chequer {

ThreadPool::ThreadPool(int workers, std::function<void(int)> on_start) {
  try {
    for (int worker = 1; worker < workers; ++worker)
      threads_.emplace_back([this, worker, on_start] {
        if (on_start) on_start(worker);
        WaitForRuns(worker);
      });
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
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void ThreadPool::Run(int count, const std::function<void(int, int)>& work) {
  if (threads_.empty() || count < 2) {
    for (int item = 0; item < count; ++item) work(item, 0);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    work_ = &work;
    count_ = count;
    next_ = 0;
    busy_ = static_cast<int>(threads_.size());
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
