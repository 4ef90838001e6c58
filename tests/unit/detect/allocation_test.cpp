// Once its memory has grown to what frames need, a detector allocates nothing. This file replaces the program's
// operator new by one that counts.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <vector>

#include "chequer/detector.h"
#include "support/scenes.h"

namespace {
std::atomic<int> allocations{0};
}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace chequer {
namespace {

std::vector<Image> Frames(PixelFormat format) {
  std::vector<test::KnownFrame> known = test::ClutterFrames(2, 5);
  for (const double cell_px : {7.0, 13.0, 30.0})
    known.push_back(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1234, cell_px, 4));
  std::vector<Image> frames;
  for (test::KnownFrame& frame : known) {
    frame.options.format = format;
    frames.push_back(frame.Draw());
  }
  return frames;
}

TEST(Detector, AllocatesNothingOnceItIsWarm) {
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kBayerRg8, PixelFormat::kYuyv}) {
    SCOPED_TRACE(PixelFormatName(format));
    DetectorOptions options;
    options.families[0].side_m = 0.12;
    options.camera = test::PlainCamera();
    Detector detector(options);
    const std::vector<Image> frames = Frames(format);
    std::vector<MarkerPose> markers;
    std::size_t found = 0;
    for (const Image& frame : frames) {
      detector.Detect(frame.view(), markers);
      found += markers.size();
    }
    EXPECT_EQ(found, 3u);
    // In another order, so that every frame comes after one it did not come after before.
    const int before = allocations;
    for (std::size_t i = frames.size(); i-- > 0;) detector.Detect(frames[i].view(), markers);
    EXPECT_EQ(allocations - before, 0);
  }
}

}  // namespace
}  // namespace chequer
