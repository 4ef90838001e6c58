#include "capture/clock_fit.h"

#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

using std::chrono::microseconds;

constexpr std::size_t kWindow = 60;          ///< seconds that the line is drawn through
constexpr std::size_t kSecondsForDrift = 5;  ///< fewer tell more of the network than of the drift
constexpr double kMostDrift = 1e-3;          ///< bad crystals are off by 1e-4; more is something else
constexpr double kJumpUs = 1e6;              ///< no frame is that early or that late

}  // namespace

bool ClockFit::HasJumped(double device_us, double difference_us) const {
  if (seconds_.empty()) return true;
  return device_us < last_device_us_ - kJumpUs || std::abs(difference_us - (offset_us_ + drift_ * device_us)) > kJumpUs;
}

void ClockFit::Add(std::chrono::nanoseconds device, MonotonicTime arrived) {
  const auto as_us = [&] { return std::chrono::duration<double, std::micro>(device - origin_).count(); };
  const std::int64_t difference =
      arrived.time_since_epoch().count() - std::chrono::duration_cast<microseconds>(device).count();
  if (HasJumped(as_us(), static_cast<double>(difference - base_us_))) {
    *this = ClockFit();
    origin_ = device;
    base_us_ = difference;
  }
  const double device_us = as_us();
  const auto difference_us = static_cast<double>(difference - base_us_);
  const auto second = static_cast<std::int64_t>(std::floor(device_us / 1e6));
  last_device_us_ = device_us;
  const bool is_new = seconds_.empty() || seconds_.back().second != second;
  if (is_new) {
    seconds_.push_back({second, device_us, difference_us});
    if (seconds_.size() > kWindow) seconds_.pop_front();
  } else if (difference_us - drift_ * device_us < seconds_.back().difference_us - drift_ * seconds_.back().device_us) {
    seconds_.back() = {second, device_us, difference_us};
  } else {
    return;
  }
  Fit();
}

void ClockFit::Fit() {
  const auto count = static_cast<double>(seconds_.size());
  double x_mean = 0, y_mean = 0;
  for (const Fastest& fastest : seconds_) x_mean += fastest.device_us / count, y_mean += fastest.difference_us / count;
  double xx = 0, xy = 0;
  for (const Fastest& fastest : seconds_) {
    xx += (fastest.device_us - x_mean) * (fastest.device_us - x_mean);
    xy += (fastest.device_us - x_mean) * (fastest.difference_us - y_mean);
  }
  drift_ = seconds_.size() >= kSecondsForDrift && xx > 0 ? std::clamp(xy / xx, -kMostDrift, kMostDrift) : 0;
  offset_us_ = y_mean - drift_ * x_mean;
  double squares = 0, earliest = 0;
  for (const Fastest& fastest : seconds_) {
    const double off = fastest.difference_us - (offset_us_ + drift_ * fastest.device_us);
    squares += off * off / count;
    earliest = std::min(earliest, off);
  }
  offset_us_ += earliest;  // below all of them: what is faster is nearer to the truth
  if (seconds_.size() >= kSecondsForDrift) error_ = microseconds(std::llround(std::ceil(std::sqrt(squares))));
}

MonotonicTime ClockFit::Map(std::chrono::nanoseconds device) const {
  const double device_us = std::chrono::duration<double, std::micro>(device - origin_).count();
  const std::int64_t device_whole = std::chrono::duration_cast<microseconds>(device).count();
  return MonotonicTime(microseconds(device_whole + base_us_ + std::llround(offset_us_ + drift_ * device_us)));
}

std::optional<UtcTime> UtcOfPtp(std::chrono::nanoseconds device, UtcTime fitted, std::chrono::seconds tai_minus_utc,
                                microseconds tolerance) {
  const auto stamp = std::chrono::duration_cast<microseconds>(device);
  for (const microseconds utc : {stamp - tai_minus_utc, stamp})
    if (std::chrono::abs(utc - fitted.time_since_epoch()) <= tolerance) return UtcTime(utc);
  return std::nullopt;
}

}  // namespace chequer
