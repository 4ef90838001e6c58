#pragma once

#include <cstdint>

namespace chequer {

enum class BudgetChoice : std::uint8_t {
  kAuto,       ///< by the camera's rate, the workers and the speed of this machine
  kUnlimited,  ///< every frame takes the time it takes
  kUnits,      ///< a number of units
};

struct BudgetOptions {
  BudgetChoice choice = BudgetChoice::kAuto;
  std::uint64_t units = 0;  ///< with kUnits
};

/// How much work the detection of a frame may take, units of DetectStats::work.
class FrameBudget {
 public:
  /// Of the time that all workers have between two frames, the share that detection may take; the rest is for
  /// capturing, publishing, and what else the machine does.
  static constexpr double kShare = 0.7;
  /// A frame is worked on for no longer than so many intervals of the camera, so that it is published within two,
  /// however many workers there are; the rest is for capturing, publishing, and what units of work differ by.
  static constexpr double kMostIntervals = 1.2;
  /// A frame may always take what two frames of 1920 × 1080 px with 50 boards in plain view do. Where a machine is too slow
  /// for that at the camera's rate, frames are left out: all the robots in half of the frames are worth more than half of
  /// the robots in all of them.
  static constexpr std::uint64_t kLeastAuto = 75'000;

  /// No limit.
  FrameBudget() = default;
  static FrameBudget Units(std::uint64_t units);
  /// What lets `workers` keep up with a camera, each of which does so many units a second.
  static FrameBudget Auto(double units_per_second, int workers);

  /// Units for a frame of a source of that rate; 0: no limit. Where the rate is not known (0), there is none but a
  /// number that was given.
  std::uint64_t For(double rate_hz) const;

 private:
  std::uint64_t units_ = 0;
  double units_per_second_ = 0;  ///< times what the workers are worth
};

}  // namespace chequer
