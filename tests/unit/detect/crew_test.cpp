#include "detect/crew.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace chequer {
namespace {

class CrewTest : public testing::TestWithParam<int> {};

TEST_P(CrewTest, DoesEveryItemOnceRunAfterRun) {
  Crew crew(GetParam());
  EXPECT_EQ(crew.workers(), GetParam());
  for (int run = 0; run < 200; ++run) {
    const int count = run % 17;
    std::vector<std::atomic<int>> done(static_cast<std::size_t>(count));
    std::vector<std::atomic<int>> inside(static_cast<std::size_t>(GetParam()));
    crew.Run(count, [&](int item, int worker) {
      EXPECT_EQ(inside[static_cast<std::size_t>(worker)].fetch_add(1), 0) << "a worker does one item at a time";
      ++done[static_cast<std::size_t>(item)];
      --inside[static_cast<std::size_t>(worker)];
    });
    for (int item = 0; item < count; ++item)
      EXPECT_EQ(done[static_cast<std::size_t>(item)], 1) << "run " << run << ", item " << item;
  }
}

INSTANTIATE_TEST_SUITE_P(Workers, CrewTest, testing::Values(1, 2, 5));

}  // namespace
}  // namespace chequer
