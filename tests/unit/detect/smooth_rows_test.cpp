#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <random>

#include "detect/boards/view_kernels.h"
#include "support/targets.h"

namespace chequer {
namespace {

BytePlane Noise(int width, int height) {
  BytePlane plane;
  plane.Resize(width, height);
  std::mt19937 random(5);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      // Some rows are all light: the largest sums.
      plane.row(y)[x] = y % 3 == 0 ? 255 : static_cast<std::uint8_t>(random());
  return plane;
}

std::vector<int> Row(const BytePlane& plane, int y) { return {plane.row(y), plane.row(y) + plane.width()}; }

std::vector<int> Means(const std::vector<int>& row, int width) {
  const int count = static_cast<int>(row.size());
  std::vector<int> means;
  for (int x = 0; x < count; ++x) {
    int sum = 0;
    for (int at = x - width / 2; at <= x + width / 2; ++at)
      sum += row[static_cast<std::size_t>(std::clamp(at, 0, count - 1))];
    means.push_back((sum + width / 2) / width);
  }
  return means;
}

TEST(SmoothRows, TakesTwoRunningMeansWithEveryInstructionSet) {
  std::vector<std::uint8_t> scratch;
  for (const std::int64_t target : test::AllTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    for (const int size : {1, 2, 31, 66, 88})
      for (int width = 3; width <= kWidestMean; width += 2) {
        const BytePlane before = Noise(size, 7);
        BytePlane plane = Noise(size, 7);
        hwy::SetSupportedTargetsForTest(target);
        SmoothRows(width, plane, scratch);
        hwy::SetSupportedTargetsForTest(0);
        for (int y = 0; y < 7; ++y)
          ASSERT_EQ(Row(plane, y), Means(Means(Row(before, y), width), width)) << width << " of " << size;
      }
  }
}

}  // namespace
}  // namespace chequer
