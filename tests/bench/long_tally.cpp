#include "bench/long_tally.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace chequer::bench {
namespace {

constexpr double kLeast = 1e-6, kMost = 1e9;
/// From the begin of a bin to that of the next.
constexpr double kRatio = 1.01;

const double kLogRatio = std::log(kRatio);
const auto kBins = static_cast<std::size_t>(std::log(kMost / kLeast) / kLogRatio) + 2;

}  // namespace

LogHistogram::LogHistogram() : bins_(kBins) {}

void LogHistogram::Add(double value) {
  const double kept = std::clamp(value, kLeast, kMost);
  ++bins_[static_cast<std::size_t>(std::log(kept / kLeast) / kLogRatio)];
  ++count_;
  sum_ += value;
  largest_ = std::max(largest_, value);
}

double LogHistogram::Quantile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t passed = 0;
  for (std::size_t i = 0; i < bins_.size(); ++i) {
    passed += bins_[i];
    if (passed > 0 && passed >= wanted)
      return std::min(largest_, kLeast * std::pow(kRatio, static_cast<double>(i) + 0.5));
  }
  return 0;
}

void PhaseTally::Add(const FrameScore& score, std::uint64_t units, int left_undone) {
  const auto add = [](std::uint64_t& sum, int number) { sum += static_cast<std::uint64_t>(number); };
  ++frames;
  add(expected, score.expected);
  add(read, score.read);
  add(whole, score.whole);
  add(whole_read, score.whole_read);
  add(undecided, score.undecided);
  add(wrong, score.wrong);
  add(twice, score.twice);
  add(ghosts, score.ghosts);
  add(deferred, left_undone);
  work.Add(static_cast<double>(units));
  for (const PoseError& error : score.errors) {
    if (error.position_over_covariance) position_over_covariance.Add(*error.position_over_covariance);
    if (error.rotation_over_covariance) rotation_over_covariance.Add(*error.rotation_over_covariance);
  }
}

double MemoryWatch::Growth() const {
  if (samples_.size() < 2) return 0;
  const double total = static_cast<double>(samples_.back().frames);
  double before = 0, after = samples_.back().megabytes;
  for (const Sample& sample : samples_) {
    const double at = static_cast<double>(sample.frames) / total;
    if (at >= 0.1 && at <= 0.2) before = std::max(before, sample.megabytes);
    if (at >= 0.9) after = std::min(after, sample.megabytes);
  }
  return before == 0 ? 0 : after - before;
}

double ResidentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double size = 0, resident = 0;
  if (!(file >> size >> resident)) throw std::runtime_error("/proc/self/statm cannot be read");
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

}  // namespace chequer::bench
