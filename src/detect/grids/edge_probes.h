#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "detect/common/plane.h"
#include "detect/common/raw_buffer.h"

namespace chequer {

/// Lines along which an edge is expected. Keeps its memory.
class EdgeProbes {
 public:
  struct Probe {
    Eigen::Vector2f from = Eigen::Vector2f::Zero();   ///< where the line begins: pixels of the plane
    Eigen::Vector2f along = Eigen::Vector2f::Zero();  ///< from there to its end
    bool light_on_left = false;  ///< else right: the image's y points down, left of (1, 0) lies (0, 1)
    float most_reach = 0;        ///< no farther from the line is looked, pixels
    float least_step = 0;        ///< from dark to light, levels
  };

  /// Forgets all. @param most that may be added.
  void Start(std::size_t most);
  void Add(const Probe& probe) {
    const auto set = [&](Column k, float value) { columns_.column(k)[count_] = value; };
    set(kX, probe.from.x()), set(kY, probe.from.y());
    set(kAlongX, probe.along.x()), set(kAlongY, probe.along.y());
    set(kSide, probe.light_on_left ? 1.0f : -1.0f);
    set(kMostReach, probe.most_reach), set(kLeastStep, probe.least_step);
    ++count_;
  }
  /// Whether the plane shows an edge all along each line: 1 or 0, in the order in which they were added. It is looked
  /// for on both sides at three places, a quarter of the line's length away at most. Points outside the plane take its
  /// edge. 15 ns a line.
  std::span<const std::uint8_t> Look(const BytePlane& plane);

  enum Column : std::size_t { kX, kY, kAlongX, kAlongY, kSide, kMostReach, kLeastStep, kColumns };

 private:
  std::size_t count_ = 0;
  FloatColumns columns_;
  RawBuffer<std::uint8_t> found_;
};

}  // namespace chequer
