#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

struct MemoryState;

/// What the last frames of a stream taught, with which the next one starts (Detector::Detect). A value: copies are
/// independent. It belongs to one camera and to detectors with the same options. One thread at a time; what was moved
/// from can only be assigned to.
class DetectorMemory {
 public:
  /// Boards, and as many open places, that it holds at most.
  static constexpr std::size_t kMostBoards = 1024;

  /// Empty: the next frame is searched as a whole.
  DetectorMemory();
  ~DetectorMemory();
  DetectorMemory(const DetectorMemory& other);
  DetectorMemory& operator=(const DetectorMemory& other);
  DetectorMemory(DetectorMemory&&) noexcept;
  DetectorMemory& operator=(DetectorMemory&&) noexcept;

  /// Forgets everything: to be called where the next frame may show something else, as after a camera was reopened.
  void Clear();
  /// Boards that are expected in the next frame.
  std::size_t boards() const;
  /// Memory that its values take, bytes.
  std::size_t bytes() const;

  /// For the detector.
  MemoryState& state() { return *state_; }
  const MemoryState& state() const { return *state_; }

 private:
  std::unique_ptr<MemoryState> state_;
};

}  // namespace chequer

#pragma GCC visibility pop
