// Decoding runs for every marker of every frame: it must not touch the heap.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "chequer/marker.h"
#include "unit/marker/marker_codes.h"

namespace {

std::atomic<long> allocation_count{0};

}  // namespace

void* operator new(std::size_t size) {
  ++allocation_count;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
// The standard's forwards to the one above; a sanitizer's would not, and then complain of delete below.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocation_count;
  return std::malloc(size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace chequer {
namespace {

TEST(Decoding, AllocatesNothing) {
  for (const MarkerSize size : {MarkerSize{6, 6}, {8, 8}, {10, 10}}) {
    std::vector<MarkerCode> codes = test::AllCodes(size);
    codes.push_back(MarkerCode::FromTable(size, {1, 2, 3}));
    const Roster roster({0, 1, 2});
    std::vector<float> ratios(static_cast<std::size_t>(KernelBits(size)), 0.5f);
    ratios[3] = -1.0f;
    for (const MarkerCode& code : codes) {
      const RosterDecoder decoder(code, roster);
      const long before = allocation_count;
      const auto all = code.DecodeSoft(ratios);
      const auto limited = code.DecodeSoft(ratios, &roster);
      const auto prepared = decoder.DecodeSoft(ratios);
      const auto hard = code.DecodeHard(code.Encode(1));
      const long allocated = allocation_count - before;
      EXPECT_EQ(allocated, 0) << test::Describe(code);
      EXPECT_TRUE(all && limited && prepared && hard);
    }
  }
}

TEST(Decoding, AllocationsAreCounted) {
  const long before = allocation_count;
  const std::vector<int> vector(1000);
  EXPECT_GT(allocation_count, before) << vector.size();
}

}  // namespace
}  // namespace chequer
