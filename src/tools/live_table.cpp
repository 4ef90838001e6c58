#include "tools/live_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/message_text.h"

namespace chequer {
namespace {

using std::chrono::seconds;

/// Rates are of this time: long enough to be steady, short enough to follow.
constexpr seconds kRateWindow{2};
constexpr seconds kForgetAfter{10};
/// No camera is that fast; bounds the memory if a publisher runs wild.
constexpr std::size_t kMaxArrivals = 4096;

std::string Row(std::uint64_t id, const MarkerPose& pose, double rate_hz, double age_s) {
  std::string place = fmt::format("{:>9} {:>9} {:>9} {:>8}", "-", "-", "-", "-");
  if (pose.has_pose) {
    const Eigen::Vector3d& t = pose.camera_from_marker.translation;
    place = fmt::format("{:>9.4f} {:>9.4f} {:>9.4f} {:>8.1f}", t.x(), t.y(), t.z(), HeadingDegrees(pose));
  }
  return fmt::format("{:>20} {} {:>8.1f} {:>8.2f}\n", id, place, rate_hz, age_s);
}

}  // namespace

void LiveTable::Arrivals::Add(MonotonicTime now) {
  times_.push_back(now);
  Forget(now);
}

void LiveTable::Arrivals::Forget(MonotonicTime now) {
  while (times_.size() > 1 && (now - times_.front() > kRateWindow || times_.size() > kMaxArrivals)) times_.pop_front();
}

double LiveTable::Arrivals::RateHz(MonotonicTime now) {
  Forget(now);
  const double span = std::chrono::duration<double>(times_.back() - times_.front()).count();
  if (span <= 0 || now - times_.back() > kRateWindow) return 0;
  return static_cast<double>(times_.size() - 1) / span;
}

void LiveTable::Add(const std::string& channel, const PosesMessage& message, MonotonicTime now) {
  Channel& from = channels_[channel];
  from.arrivals.Add(now);
  from.frames_dropped = message.frames_dropped;
  for (const MarkerPose& pose : message.markers) {
    if (!pose.id) continue;  // nobody to put it down to
    Marker& marker = markers_[{channel, pose.family, *pose.id}];
    marker.pose = pose;
    marker.arrivals.Add(now);
    marker.age_at_arrival = message.published_monotonic - message.captured_monotonic;
  }
}

std::string LiveTable::Text(MonotonicTime now, int max_lines) {
  std::erase_if(markers_, [&](const auto& entry) { return now - entry.second.arrivals.last() > kForgetAfter; });
  std::string text;
  int lines = 0;
  for (auto& [name, channel] : channels_) {
    if (lines++ >= max_lines - 2) break;
    text += fmt::format("{}: {:.1f} frames/s, {} frames dropped\n", name, channel.arrivals.RateHz(now),
                        channel.frames_dropped);
  }
  text += fmt::format("{:>20} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8}\n", "id", "x m", "y m", "z m", "heading", "rate Hz",
                      "age s");
  ++lines;
  std::size_t shown = 0;
  for (auto& [key, marker] : markers_) {
    const bool all_fit = lines + static_cast<int>(markers_.size() - shown) <= max_lines;
    if (!all_fit && lines >= max_lines - 1) break;
    const auto age = std::chrono::duration<double>(now - marker.arrivals.last() + marker.age_at_arrival).count();
    text += Row(key.id, marker.pose, marker.arrivals.RateHz(now), age);
    ++lines;
    ++shown;
  }
  if (shown < markers_.size()) text += fmt::format("and {} more\n", markers_.size() - shown);
  return text;
}

}  // namespace chequer
