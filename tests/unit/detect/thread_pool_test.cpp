#include "detect/common/thread_pool.h"

#include <gtest/gtest.h>

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

TEST(ThreadPool, LeavesNothingBehindWhereAThreadCannotBeStarted) {
  const test::NoRoomForThreads no_room;
  EXPECT_THROW(ThreadPool(3), std::system_error);
}

}  // namespace
}  // namespace chequer
