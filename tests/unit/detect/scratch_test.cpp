#include "detect/common/scratch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "detect/common/fixed_vector.h"
#include "detect/common/raw_buffer.h"

namespace chequer {
namespace {

struct State {
  int count = 3;
  std::optional<int> found;
  std::vector<double> values;
  RawBuffer<float> raw;
  FixedVector<int, 4> few;
};

TEST(Scratch, BeginsAsANewOne) {
  Scratch<State> scratch;
  EXPECT_EQ(scratch->count, 3);
  scratch->count = 7;
  scratch->found = 2;
  scratch->values = {1, 2};
  scratch->raw.Resize(5);
  scratch->few.Assign(4, 9);
  const State& state = scratch.Start();
  EXPECT_EQ(&state, &*scratch);
  EXPECT_EQ(state.count, 3);
  EXPECT_FALSE(state.found.has_value());
  EXPECT_TRUE(state.values.empty());
  EXPECT_EQ(state.raw.size(), 0u);
  EXPECT_EQ(state.few.size(), 0u);
}

TEST(Scratch, KeepsTheMemoryOfItsVectors) {
  Scratch<State> scratch;
  scratch->values.resize(1000);
  scratch->raw.Resize(1000);
  const double* const values = scratch->values.data();
  const float* const raw = scratch->raw.data();
  scratch.Start();
  EXPECT_EQ(scratch->values.capacity(), 1000u);
  scratch->values.resize(10);
  scratch->raw.Resize(10);
  EXPECT_EQ(scratch->values.data(), values);
  EXPECT_EQ(scratch->raw.data(), raw);
}

TEST(RawBuffer, CopiesAndMovesWhatItHolds) {
  RawBuffer<int> a;
  a.Resize(3);
  for (std::size_t i = 0; i < 3; ++i) a[i] = static_cast<int>(i) + 5;
  RawBuffer<int> copy = a;
  ASSERT_EQ(copy.size(), 3u);
  EXPECT_TRUE(std::equal(a.begin(), a.end(), copy.begin()));
  EXPECT_NE(copy.data(), a.data());
  const int* const memory = a.data();
  RawBuffer<int> moved = std::move(a);
  EXPECT_EQ(moved.data(), memory);
  EXPECT_EQ(moved[2], 7);
  a = RawBuffer<int>();  // and may be used on
  a.Resize(2);
  a[1] = 1;
  EXPECT_EQ(moved.size(), 3u);
}

TEST(RawBuffer, GrowsAndGetsSmallerInPlace) {
  RawBuffer<char> buffer;
  buffer.Resize(100);
  const char* const memory = buffer.data();
  buffer.Resize(10);
  EXPECT_EQ(buffer.size(), 10u);
  buffer.Resize(100);
  EXPECT_EQ(buffer.data(), memory);
  buffer.Resize(101);
  EXPECT_EQ(buffer.size(), 101u);
}

TEST(FixedVector, HoldsUpToItsMost) {
  FixedVector<int, 4> values;
  values.Assign(2, 6);
  values[1] = 8;
  const FixedVector<int, 4> copy = values;
  values.Assign(4, 0);
  EXPECT_EQ(std::vector<int>(copy.begin(), copy.end()), (std::vector<int>{6, 8}));
  EXPECT_EQ(std::vector<int>(values.begin(), values.end()), std::vector<int>(4, 0));
  values = copy;
  EXPECT_EQ(values.size(), 2u);
  EXPECT_DEATH(values.Assign(5, 0), "more values than there is room for");
}

}  // namespace
}  // namespace chequer
