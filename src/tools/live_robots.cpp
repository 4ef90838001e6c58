#include "tools/live_robots.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/printable.h"
#include "publish/channels.h"
#include "tools/message_text.h"

namespace chequer {
namespace {

using std::chrono::seconds;

constexpr seconds kForgetRobotAfter{10};
constexpr std::size_t kLeastNameWidth = 6;

std::string NameOf(const std::string& name, std::uint64_t id) {
  return name.empty() ? std::to_string(id) : Printable(name);
}

std::string PrefixOf(const std::string& channel) {
  for (const std::string_view suffix : kChannelSuffixes)
    if (channel.ends_with(suffix)) return channel.substr(0, channel.size() - suffix.size());
  return channel;
}

std::string Optional(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:>8}", FixedText(*value, digits)) : fmt::format("{:>8}", "-");
}

}  // namespace

void LiveRobots::Add(const std::string& channel, const RobotsMessage& message, MonotonicTime now) {
  for (const RobotPose& robot : message.robots) {
    // A robot's tracks know its first marker; which of two markers a frame shows does not matter here.
    Row& row = rows_[{PrefixOf(channel), robot.name, 0, 0}];
    row.off_floor = robot.floor && robot.floor->off_floor;
    if (row.speed_m_s && now - row.arrived < kForgetRobotAfter) continue;  // its track tells more
    row.pose = robot.frame_from_body;
    row.arrived = now;
    row.age_at_arrival = message.header.published_monotonic - message.header.captured_monotonic;
  }
}

void LiveRobots::Add(const std::string& channel, const TracksMessage& message, MonotonicTime now) {
  for (const TrackState& track : message.tracks) {
    const bool named = !track.key.robot.empty();
    Row& row = rows_[{PrefixOf(channel), track.key.robot, named ? 0 : track.key.family, named ? 0 : track.key.id}];
    row.pose = track.frame_from_body;
    row.speed_m_s = track.velocity.norm();
    row.yaw_rate_rad_s = track.angular_velocity.z();
    row.coasting = track.coasting;
    row.arrived = now;
    row.age_at_arrival = message.header.published_monotonic - message.valid_monotonic + track.since_seen;
  }
}

std::string LiveRobots::Text(MonotonicTime now, int max_lines) {
  rows_.EraseIf([&](const Row& row) { return now - row.arrived > kForgetRobotAfter; });
  if (rows_.empty()) return {};
  std::size_t width = kLeastNameWidth;
  rows_.ForEach([&](const Key& key, const Row&) {
    width = std::max(width, NameOf(key.name, key.id).size());
    return true;
  });
  std::string text = fmt::format("{:>{}} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "robot", width, "x m", "y m",
                                 "z m", "heading", "m/s", "deg/s", "age s");
  int lines = 1;
  std::size_t shown = 0;
  rows_.ForEach([&](const Key& key, const Row& row) {
    const bool all_fit = lines + static_cast<int>(rows_.size() - shown) <= max_lines;
    if (!all_fit && lines >= max_lines - 1) return false;
    const Eigen::Vector3d& t = row.pose.translation;
    const auto yaw_rate = row.yaw_rate_rad_s ? std::optional(*row.yaw_rate_rad_s * kDegreesPerRadian) : std::nullopt;
    text += fmt::format("{:>{}} {:>8} {:>8} {:>8} {:>8} {} {} {:>8.2f}{}{}\n", NameOf(key.name, key.id), width,
                        FixedText(t.x(), 4), FixedText(t.y(), 4), FixedText(t.z(), 4),
                        FixedText(HeadingRad(row.pose.rotation) * kDegreesPerRadian, 1), Optional(row.speed_m_s, 3),
                        Optional(yaw_rate, 1),
                        std::chrono::duration<double>(now - row.arrived + row.age_at_arrival).count(),
                        row.coasting ? "  coasting" : "", row.off_floor ? "  off the floor" : "");
    ++lines;
    ++shown;
    return true;
  });
  if (shown < rows_.size()) text += fmt::format("and {} more\n", rows_.size() - shown);
  return text;
}

}  // namespace chequer
