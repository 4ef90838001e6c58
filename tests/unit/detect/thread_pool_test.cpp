#include "detect/common/thread_pool.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <barrier>
#include <map>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "support/no_room_for_threads.h"

namespace chequer {
namespace {

class ThreadPoolTest : public testing::TestWithParam<int> {};

TEST_P(ThreadPoolTest, DoesEveryItemOnceRunAfterRun) {
  ThreadPool pool(GetParam());
  EXPECT_EQ(pool.workers(), GetParam());
  for (int run = 0; run < 200; ++run) {
    const int count = run % 17;
    std::vector<std::atomic<int>> done(static_cast<std::size_t>(count));
    std::vector<std::atomic<int>> inside(static_cast<std::size_t>(GetParam()));
    pool.Run(count, [&](int item, int worker) {
      EXPECT_EQ(inside[static_cast<std::size_t>(worker)].fetch_add(1), 0) << "a worker does one item at a time";
      ++done[static_cast<std::size_t>(item)];
      --inside[static_cast<std::size_t>(worker)];
    });
    for (int item = 0; item < count; ++item)
      EXPECT_EQ(done[static_cast<std::size_t>(item)], 1) << "run " << run << ", item " << item;
  }
}

INSTANTIATE_TEST_SUITE_P(Workers, ThreadPoolTest, testing::Values(1, 2, 5));

TEST(ThreadPool, BeginsEachOfItsThreadsAsAskedFor) {
  std::mutex mutex;
  std::map<int, std::thread::id> begun;
  const auto begin = [&](int worker) {
    const std::lock_guard lock(mutex);
    EXPECT_TRUE(begun.emplace(worker, std::this_thread::get_id()).second);
  };
  std::map<int, std::thread::id> worked;
  {
    ThreadPool pool(3, begin);
    // Each waits for the others, so that every thread has an item.
    std::barrier all(3);
    pool.Run(3, [&](int, int worker) {
      {
        const std::lock_guard lock(mutex);
        worked[worker] = std::this_thread::get_id();
      }
      all.arrive_and_wait();
    });
  }
  ASSERT_EQ(begun.size(), 2u);
  EXPECT_EQ(worked.at(0), std::this_thread::get_id());
  EXPECT_EQ(begun.at(1), worked.at(1));
  EXPECT_EQ(begun.at(2), worked.at(2));
}

/// Processors that a thread may run on; changes those of the calling thread back.
class Processors {
 public:
  Processors() { EXPECT_EQ(sched_getaffinity(0, sizeof before_, &before_), 0); }
  ~Processors() { EXPECT_EQ(sched_setaffinity(0, sizeof before_, &before_), 0); }

  std::vector<int> All() const {
    std::vector<int> all;
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
      if (CPU_ISSET(static_cast<unsigned>(cpu), &before_)) all.push_back(cpu);
    return all;
  }
  static void RunOn(int cpu) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<unsigned>(cpu), &set);
    EXPECT_EQ(sched_setaffinity(0, sizeof set, &set), 0);
  }
  static bool MayRunOn(int cpu) {
    cpu_set_t set;
    EXPECT_EQ(sched_getaffinity(0, sizeof set, &set), 0);
    return CPU_ISSET(static_cast<unsigned>(cpu), &set);
  }

 private:
  cpu_set_t before_;
};

/// Of two processors, which a pool's second thread may run on in the next run.
std::vector<bool> HelperMayRunOn(ThreadPool& pool, int one, int other) {
  std::vector<bool> may;
  // Each waits for the other, so that every thread has an item.
  std::barrier both(2);
  pool.Run(2, [&](int, int worker) {
    if (worker == 1) may = {Processors::MayRunOn(one), Processors::MayRunOn(other)};
    both.arrive_and_wait();
  });
  return may;
}

TEST(ThreadPool, ThreadsKeepOffTheCallersProcessor) {
  const Processors processors;
  const std::vector<int> all = processors.All();
  if (all.size() < 2) GTEST_SKIP() << "there is one processor";
  const int one = all[0], other = all[1];
  Processors::RunOn(one);
  ThreadPool pool(2, [&](int) {
    // As the caller was before it was pinned.
    cpu_set_t set;
    CPU_ZERO(&set);
    for (const int cpu : all) CPU_SET(static_cast<unsigned>(cpu), &set);
    EXPECT_EQ(sched_setaffinity(0, sizeof set, &set), 0);
  });
  HelperMayRunOn(pool, one, other);  // afterwards it has begun
  EXPECT_EQ(HelperMayRunOn(pool, one, other), (std::vector{false, true}));
  Processors::RunOn(other);
  EXPECT_EQ(HelperMayRunOn(pool, one, other), (std::vector{true, false}));
}

TEST(ThreadPool, PinnedThreadsStayWhereTheyAre) {
  const Processors processors;
  const std::vector<int> all = processors.All();
  const int one = all[0], other = all.back();
  Processors::RunOn(one);
  ThreadPool pool(2, [&](int) { Processors::RunOn(one); });
  HelperMayRunOn(pool, one, other);
  EXPECT_EQ(HelperMayRunOn(pool, one, other), (std::vector{true, one == other}));
  Processors::RunOn(other);
  EXPECT_EQ(HelperMayRunOn(pool, one, other), (std::vector{true, one == other}));
}

TEST(ThreadPool, LeavesNothingBehindWhereAThreadCannotBeStarted) {
  const test::NoRoomForThreads no_room;
  EXPECT_THROW(ThreadPool(3), std::system_error);
}

}  // namespace
}  // namespace chequer
