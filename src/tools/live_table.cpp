#include "tools/live_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/printable.h"
#include "tools/message_text.h"

namespace chequer {
namespace {

using std::chrono::seconds;

/// Rates are of this time: long enough to be steady, short enough to follow.
constexpr seconds kRateWindow{2};
constexpr seconds kForgetAfter{10};
constexpr std::size_t kLeastIdWidth = 5;
/// Enough for a rate; bounds the memory of each marker, also if a publisher runs wild.
constexpr std::size_t kMaxArrivals = 256;

std::string Row(std::uint64_t id, std::size_t id_width, const MarkerPose& pose, double rate_hz, double age_s) {
  std::string place = fmt::format("{:>9} {:>9} {:>9} {:>8}", "-", "-", "-", "-");
  if (pose.has_pose) {
    const Eigen::Vector3d& t = pose.camera_from_marker.translation;
    place = fmt::format("{:>9} {:>9} {:>9} {:>8}", FixedText(t.x(), 4), FixedText(t.y(), 4), FixedText(t.z(), 4),
                        FixedText(HeadingDegrees(pose), 1));
  }
  return fmt::format("{:>{}} {} {:>8.1f} {:>8.2f}\n", id, id_width, place, rate_hz, age_s);
}

}  // namespace

void LiveTable::Arrivals::Add(MonotonicTime now) {
  times_.push_back(now);
  Forget(now);
}

void LiveTable::Arrivals::Forget(MonotonicTime now) {
  while (times_.size() > 1 && (now - times_.front() > kRateWindow || times_.size() > kMaxArrivals)) times_.pop_front();
}

double LiveTable::Arrivals::RateHz(MonotonicTime now) const {
  if (now - times_.back() > kRateWindow) return 0;
  const auto first = std::find_if(times_.begin(), std::prev(times_.end()),
                                  [&](MonotonicTime time) { return now - time <= kRateWindow; });
  const double span = std::chrono::duration<double>(times_.back() - *first).count();
  return span > 0 ? static_cast<double>(std::distance(first, times_.end()) - 1) / span : 0;
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
  markers_.EraseIf([&](const Marker& marker) { return now - marker.arrivals.last() > kForgetAfter; });
  std::string text;
  int lines = 0;
  channels_.ForEach([&](const std::string& name, const Channel& channel) {
    if (lines++ >= max_lines - 2) return false;
    text += fmt::format("{}: {:.1f} frames/s, {} frames dropped\n", Printable(name), channel.arrivals.RateHz(now),
                        channel.frames_dropped);
    return true;
  });
  std::size_t id_width = kLeastIdWidth;
  markers_.ForEach([&](const Key& key, const Marker&) {
    id_width = std::max(id_width, std::to_string(key.id).size());
    return true;
  });
  text += fmt::format("{:>{}} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8}\n", "id", id_width, "x m", "y m", "z m", "heading",
                      "rate Hz", "age s");
  ++lines;
  std::size_t shown = 0;
  markers_.ForEach([&](const Key& key, const Marker& marker) {
    const bool all_fit = lines + static_cast<int>(markers_.size() - shown) <= max_lines;
    if (!all_fit && lines >= max_lines - 1) return false;
    const auto age = std::chrono::duration<double>(now - marker.arrivals.last() + marker.age_at_arrival).count();
    text += Row(key.id, id_width, marker.pose, marker.arrivals.RateHz(now), age);
    ++lines;
    ++shown;
    return true;
  });
  if (shown < markers_.size()) text += fmt::format("and {} more\n", markers_.size() - shown);
  return text;
}

}  // namespace chequer
