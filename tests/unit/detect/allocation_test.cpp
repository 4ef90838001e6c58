// Once its memory has grown to what frames need, a detector allocates nothing. This file replaces the program's
// operator new, and malloc where no sanitizer has its own, by ones that count.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <new>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "chequer/detector.h"
#include "support/sanitizers.h"
#include "support/scenes.h"

namespace {
std::atomic<int> allocations{0};
}  // namespace

#if defined(CHEQUER_ADDRESS_SANITIZER) || defined(CHEQUER_THREAD_SANITIZER)
#define CHEQUER_MALLOC_IS_TAKEN
#endif

#ifndef CHEQUER_MALLOC_IS_TAKEN
// Eigen's matrices come from there.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}
#endif

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto step = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(step, (size + step) / step * step)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size > 0 ? size : 1);
}
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace chequer {
namespace {

std::vector<Image> Frames(PixelFormat format) {
  std::vector<test::KnownFrame> known = test::ClutterFrames(2, 5);
  for (const double cell_px : {7.0, 13.0, 30.0})
    known.push_back(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1234, cell_px, 4));
  // So steep that it takes a second look.
  known.push_back(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1234, 15, 2, 1.34));
  // So blurred that cells beyond those around a corner matter.
  known.push_back(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 77, 10, 6));
  known.back().options.blur_sigma_px = 3;
  // In the edge of a shadow.
  known.push_back(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 99, 8, 7));
  known.back().options.shadow = {.takes = 0.6,
                                 .direction_rad = 0.5,
                                 .through_x = known.back().options.camera.cx,
                                 .through_y = known.back().options.camera.cy,
                                 .width_px = 3};
  // The same where cells blur into each other, and ink has spread.
  known.push_back(known.back());
  known.back().options.blur_sigma_px = 2;
  known.push_back(known.back());
  known.back().options.blur_sigma_px = 0.6;
  known.back().scene.markers[0].ink_spread_cells = 0.1;
  // Several at once, for several threads.
  known.push_back(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1, 9, 5));
  for (const double beside : {-0.4, -0.2, 0.2, 0.4}) {
    known.back().scene.markers.push_back(known.back().scene.markers[0]);
    known.back().scene.markers.back().camera_from_marker.translation.x() += beside;
  }
  // The same, all of them motion-blurred, and a side of each occluded.
  known.push_back(known.back());
  known.back().options.motion_px = 7;
  known.back().options.motion_angle_rad = 0.4;
  known.push_back(known[known.size() - 2]);
  for (SceneMarker& marker : known.back().scene.markers) marker.occluders = {{.from = {-0.1, -0.1}, .to = {1.1, 0.2}}};
  std::vector<Image> frames;
  for (test::KnownFrame& frame : known) {
    frame.options.format = format;
    frames.push_back(frame.Draw());
  }
  return frames;
}

class Allocations : public testing::TestWithParam<std::tuple<PixelFormat, int, std::uint64_t>> {};

TEST_P(Allocations, ThereAreNoneOnceADetectorIsWarm) {
  const PixelFormat format = std::get<0>(GetParam());
  const int threads = std::get<1>(GetParam());
  const std::uint64_t budget = std::get<2>(GetParam());
  DetectorOptions options;
  options.families[0].side_m = 0.12;
  options.camera = test::PlainCamera();
  options.threads = threads;
  options.budget = budget;
  Detector detector(options);
  const std::vector<Image> frames = Frames(format);
  std::vector<MarkerPose> markers;
  // All frames, each after another than the time before. Returns how often something was allocated.
  auto round = [&, backwards = false]() mutable {
    const int before = allocations;
    std::size_t found = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      detector.Detect(frames[backwards ? frames.size() - 1 - i : i].view(), markers);
      found += markers.size();
    }
    if (budget == 0 || budget > 100'000) {
      EXPECT_EQ(found, 23u);
    }
    backwards = !backwards;
    return allocations - before;
  };
  // Two rounds at first: an image that follows one with more boards still grows. Which thread measures which board is
  // chance: each needs its time to have seen them all.
  for (int i = 0; i < 2; ++i) round();
  int quiet = 0;
  for (int i = 0; i < (threads > 1 ? 200 : 4) && quiet < 4; ++i) quiet = round() == 0 ? quiet + 1 : 0;
  EXPECT_EQ(quiet, 4) << "rounds without an allocation, one after the other";
}

/// Frames of a stream, which lose boards, find them, and are cut: with a memory of its own, or one that is handed on by
/// value as workers do.
class AllocationsOfStream : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(AllocationsOfStream, ThereAreNoneOnceDetectorAndMemoryAreWarm) {
  const auto [threads, handed] = GetParam();
  const bool handed_on = handed;  // no lambda may take a part of a binding
  DetectorOptions options;
  options.families[0].side_m = 0.12;
  options.camera = test::PlainCamera();
  options.threads = threads;
  Detector detector(options);
  DetectorMemory memory, other;
  const std::vector<Image> frames = Frames(PixelFormat::kBgr8);
  std::vector<MarkerPose> markers;
  std::chrono::nanoseconds now{1'000'000'000};
  std::size_t most_bytes = 0;
  // Every frame three times, so that boards are followed. Returns how often something was allocated.
  const auto round = [&] {
    const int before = allocations;
    for (const Image& frame : frames)
      for (int again = 0; again < 3; ++again) {
        now += std::chrono::milliseconds(16);
        if (handed_on) {
          other = memory;
          detector.Detect(frame.view(), now, other, markers);
          std::swap(memory, other);
        } else {
          detector.Detect(frame.view(), now, memory, markers);
        }
        most_bytes = std::max(most_bytes, memory.bytes());
      }
    return allocations - before;
  };
  for (int i = 0; i < 2; ++i) round();
  const std::size_t warm_bytes = most_bytes;
  int quiet = 0;
  for (int i = 0; i < (threads > 1 ? 100 : 6) && quiet < 4; ++i) quiet = round() == 0 ? quiet + 1 : 0;
  EXPECT_EQ(quiet, 4) << "rounds without an allocation, one after the other";
  EXPECT_GT(memory.boards(), 0u);
  EXPECT_EQ(most_bytes, warm_bytes) << "grown by the same frames";
  EXPECT_LE(most_bytes, 40 * 8192u) << "boards in the busiest frame, 8 kB each";
}

INSTANTIATE_TEST_SUITE_P(Detector, AllocationsOfStream,
                         testing::Values(std::tuple{1, false}, std::tuple{1, true}, std::tuple{2, false}),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param) > 1 ? "two_threads" : "one_thread") +
                                  (std::get<1>(test.param) ? "_handed_on" : "");
                         });

INSTANTIATE_TEST_SUITE_P(Detector, Allocations,
                         testing::Values(std::tuple{PixelFormat::kBgr8, 1, std::uint64_t{0}}, std::tuple{PixelFormat::kBayerRg8, 1, std::uint64_t{0}},
                                         std::tuple{PixelFormat::kYuyv, 1, std::uint64_t{0}}, std::tuple{PixelFormat::kBgr8, 2, std::uint64_t{0}},
                                         std::tuple{PixelFormat::kBgr8, 1, std::uint64_t{200'000}},
                                         std::tuple{PixelFormat::kBgr8, 2, std::uint64_t{10'000}}),
                         [](const auto& test) {
                           return std::string(PixelFormatName(std::get<0>(test.param))) +
                                  (std::get<1>(test.param) > 1 ? "_two_threads" : "") +
                                  (std::get<2>(test.param) > 0 ? "_budget_" + std::to_string(std::get<2>(test.param)) : "");
                         });

}  // namespace
}  // namespace chequer
