#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "evaluate/frame_score.h"

// What a run over millions of frames remembers of them. None of it grows with their number, so that the memory of the
// process shows that of the detector.

namespace chequer::bench {

/// What positive numbers are like, to a hundredth of each.
class LogHistogram {
 public:
  LogHistogram();

  /// Numbers below 1e-6 count as that, numbers above 1e9 as that.
  void Add(double value);

  std::uint64_t count() const { return count_; }
  double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }
  double largest() const { return largest_; }
  /// The smallest number that this share of all does not exceed; 0 where there are none.
  double Quantile(double share) const;

 private:
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  double sum_ = 0;
  double largest_ = 0;
};

/// The frames of a phase, over all seeds and rounds.
struct PhaseTally {
  std::string stream;  ///< the scenario's name
  std::string phase;
  std::uint64_t frames = 0;
  std::uint64_t expected = 0, read = 0;     ///< boards, as FrameScore has them
  std::uint64_t whole = 0, whole_read = 0;  ///< of these, those that are seen from rim to rim
  std::uint64_t undecided = 0, wrong = 0, twice = 0, ghosts = 0;
  std::uint64_t deferred = 0;  ///< boards that the budget did not last for
  LogHistogram work;           ///< units a frame
  LogHistogram position_over_covariance, rotation_over_covariance;

  void Add(const FrameScore& score, std::uint64_t units, int left_undone);
  std::uint64_t mistakes() const { return wrong + twice + ghosts; }
};

/// Resident memory of the process over a run.
class MemoryWatch {
 public:
  struct Sample {
    std::uint64_t frames = 0;
    double megabytes = 0;
  };
  void Add(std::uint64_t frames, double megabytes) { samples_.push_back({frames, megabytes}); }
  const std::vector<Sample>& samples() const { return samples_; }
  /// By how much memory grew after the first tenth of the run, megabytes: the least of the last tenth over the most
  /// of the second. What is needed once is there by then.
  double Growth() const;

 private:
  std::vector<Sample> samples_;
};

/// Of this process, megabytes. Throws std::runtime_error where the system does not say.
double ResidentMegabytes();

}  // namespace chequer::bench
