#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "daemon/newest_queue.h"
#include "daemon/reorder_buffer.h"
#include "support/seed.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::seconds;

TEST(NewestQueue, GivesWhatWasPut) {
  NewestQueue<int> queue;
  EXPECT_EQ(queue.counts().waiting, 0);
  EXPECT_TRUE(queue.Put(7));
  EXPECT_EQ(queue.counts().waiting, 1);
  const auto taken = queue.Take();
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(taken->item, 7);
  EXPECT_EQ(taken->ticket, 0u);
  EXPECT_EQ(taken->superseded, 0u);
  EXPECT_EQ(queue.counts().waiting, 0);
}

TEST(NewestQueue, ReplacesWhatWaitsAndCountsIt) {
  NewestQueue<int> queue;
  for (int i = 0; i < 5; ++i) queue.Put(i);
  const auto taken = queue.Take();
  ASSERT_TRUE(taken.has_value());
  EXPECT_EQ(taken->item, 4);
  EXPECT_EQ(taken->ticket, 0u);
  EXPECT_EQ(taken->superseded, 4u);
  EXPECT_EQ(queue.counts().superseded, 4u);
}

TEST(NewestQueue, LetsGoOfWhatIsReplacedAtOnce) {
  NewestQueue<std::shared_ptr<int>> queue;
  auto first = std::make_shared<int>(1);
  const std::weak_ptr<int> watch = first;
  queue.Put(std::move(first));
  queue.Put(std::make_shared<int>(2));
  EXPECT_TRUE(watch.expired());
}

TEST(NewestQueue, GivesTheLastItemAfterItsClose) {
  NewestQueue<int> queue;
  queue.Put(1);
  queue.Close();
  EXPECT_FALSE(queue.Put(2));
  EXPECT_FALSE(queue.PutWhenFree(3));
  ASSERT_TRUE(queue.Take().has_value());
  EXPECT_FALSE(queue.Take().has_value());
}

TEST(NewestQueue, CountsWhatBecomesOfAllThatComes) {
  NewestQueue<int> queue;
  queue.Put(1);
  queue.Take();
  queue.Put(2);
  queue.Put(3);
  queue.CloseAndDiscard();
  queue.CloseAndDiscard();
  EXPECT_FALSE(queue.Put(4));
  EXPECT_FALSE(queue.PutWhenFree(5));
  EXPECT_FALSE(queue.Take().has_value());
  const QueueCounts counts = queue.counts();
  EXPECT_EQ(counts.came, 5u);
  EXPECT_EQ(counts.superseded, 1u);
  EXPECT_EQ(counts.discarded, 3u);
  EXPECT_EQ(counts.waiting, 0);
}

TEST(NewestQueue, WaitsUntilThePlaceIsFree) {
  NewestQueue<int> queue;
  queue.Put(0);
  std::vector<int> taken;
  {
    const std::jthread putter([&] {
      for (int i = 1; i <= 1000; ++i) ASSERT_TRUE(queue.PutWhenFree(i));
      queue.Close();
    });
    while (const auto item = queue.Take()) taken.push_back(item->item);
  }
  ASSERT_EQ(taken.size(), 1001u);
  for (int i = 0; i <= 1000; ++i) EXPECT_EQ(taken[static_cast<std::size_t>(i)], i);
  EXPECT_EQ(queue.counts().superseded, 0u);
}

TEST(NewestQueue, ReleasesWhoWaitsForAPlaceWhenItCloses) {
  NewestQueue<int> queue;
  queue.Put(0);
  std::atomic<bool> put{true};
  std::latch started(1);
  {
    const std::jthread putter([&] {
      started.count_down();
      put = queue.PutWhenFree(1);
    });
    started.wait();
    queue.CloseAndDiscard();
  }
  EXPECT_FALSE(put);
}

TEST(NewestQueue, GivesEachTicketOnceAndInTheOrderOfPutting) {
  NewestQueue<int> queue;
  constexpr int kItems = 2000;
  std::vector<int> item_of_ticket(kItems, -1);
  std::atomic<std::uint64_t> count{0};
  {
    std::vector<std::jthread> takers;
    for (int i = 0; i < 3; ++i)
      takers.emplace_back([&] {
        while (const auto taken = queue.Take()) {
          item_of_ticket[taken->ticket] = taken->item;  // each ticket is one taker's
          ++count;
        }
      });
    for (int i = 0; i < kItems; ++i) queue.Put(i);
    queue.Close();
  }
  EXPECT_EQ(count + queue.counts().superseded, static_cast<std::uint64_t>(kItems));
  for (std::size_t ticket = 0; ticket + 1 < count; ++ticket)
    EXPECT_LT(item_of_ticket[ticket], item_of_ticket[ticket + 1]);
  EXPECT_EQ(item_of_ticket[count - 1], kItems - 1);
}

TEST(ReorderBuffer, GivesItemsInTheOrderOfTheirTickets) {
  ReorderBuffer<int> buffer(4);
  buffer.Push(2, 20);
  buffer.Push(1, 10);
  EXPECT_FALSE(buffer.Pop(microseconds(0)).has_value());
  buffer.Push(0, 0);
  EXPECT_EQ(buffer.Pop(seconds(10)), 0);
  EXPECT_EQ(buffer.Pop(seconds(10)), 10);
  EXPECT_EQ(buffer.Pop(seconds(10)), 20);
}

TEST(ReorderBuffer, IsDoneWhenClosedAndEmpty) {
  ReorderBuffer<int> buffer(4);
  buffer.Push(0, 5);
  buffer.Close();
  EXPECT_FALSE(buffer.IsDone());
  EXPECT_EQ(buffer.Pop(seconds(10)), 5);
  EXPECT_TRUE(buffer.IsDone());
  EXPECT_FALSE(buffer.Pop(seconds(10)).has_value());
}

TEST(ReorderBuffer, ReleasesEverybodyWhenAborted) {
  ReorderBuffer<int> buffer(1);
  {
    const std::jthread far_ahead([&] { buffer.Push(5, 50); });
    const std::jthread waiting([&] { EXPECT_FALSE(buffer.Pop(seconds(60)).has_value()); });
    buffer.Abort();
  }
  EXPECT_TRUE(buffer.IsDone());
}

TEST(ReorderBuffer, LetsOneSlowWorkerHoldUpOnlyAsMuchAsItHolds) {
  ReorderBuffer<int> buffer(3);
  std::atomic<int> pushed{0};
  std::latch three(3);
  {
    const std::jthread quick([&] {
      for (int ticket = 1; ticket <= 6; ++ticket) {
        buffer.Push(static_cast<std::uint64_t>(ticket), ticket);
        if (++pushed <= 2) three.count_down();
      }
    });
    three.count_down();
    three.wait();  // 1 and 2 are in; 3 waits for 0
    EXPECT_EQ(pushed, 2);
    buffer.Push(0, 0);
    for (int ticket = 0; ticket <= 6; ++ticket) EXPECT_EQ(buffer.Pop(seconds(10)), ticket);
  }
  EXPECT_EQ(pushed, 6);
}

TEST(ReorderBuffer, OrdersWhatManyWorkersFinish) {
  ReorderBuffer<std::uint64_t> buffer(6);
  NewestQueue<std::uint64_t> queue;
  constexpr std::uint64_t kItems = 2000;
  std::atomic<int> left{3};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      while (const auto taken = queue.Take()) {
        if (taken->item % 7 == 0) std::this_thread::yield();
        buffer.Push(taken->ticket, taken->item);
      }
      if (--left == 0) buffer.Close();
    });
  threads.emplace_back([&] {
    for (std::uint64_t i = 0; i < kItems; ++i) queue.PutWhenFree(i);
    queue.Close();
  });
  std::uint64_t expected = 0;
  while (!buffer.IsDone()) {
    if (const auto item = buffer.Pop(seconds(1))) {
      EXPECT_EQ(*item, expected++);
    }
  }
  EXPECT_EQ(expected, kItems);
}

}  // namespace
}  // namespace chequer
