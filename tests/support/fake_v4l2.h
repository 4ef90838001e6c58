#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "capture/v4l2_nodes.h"
#include "support/temporary_directory.h"

namespace chequer::test {

/// What the next buffer of the fake driver says of itself.
struct FakeV4l2Frame {
  bool is_damaged = false;
  std::uint32_t bytes_left_out = 0;
  std::uint32_t sequence = 0;
};

/// A driver of V4L2 that takes no time: it takes the place of libv4l2 in a program that links fake_v4l2.cpp. One camera
/// of 1920x1080 YUYV, whose buffers are filled as soon as it has them. One at a time; used by one thread, but for
/// buffers that go back.
class FakeV4l2 {
 public:
  FakeV4l2();
  ~FakeV4l2();
  FakeV4l2(const FakeV4l2&) = delete;
  FakeV4l2& operator=(const FakeV4l2&) = delete;

  /// Where its node is to be looked for; the camera is called Fake.
  V4l2Roots Roots() const;

  /// What the following frames say, but for the sequence, which counts on from here.
  void Say(const FakeV4l2Frame& frame);
  /// From now on every call fails as if the camera had been unplugged.
  void Unplug();
  /// Whether an address lies in one of its buffers.
  bool Owns(const void* address) const;
  /// Buffers that it has, filled or not.
  std::size_t held() const;

 private:
  TemporaryDirectory folder_;
};

}  // namespace chequer::test
