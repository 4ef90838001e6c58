#include "tools/live_arena.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/printable.h"
#include "publish/channels.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds kGoneAfter{3};
constexpr milliseconds kBestLasts{1500};
/// A character is about twice as high as wide.
constexpr double kAspect = 2;
/// From the x axis counter-clockwise.
constexpr std::array<const char*, 8> kArrows{"→", "↗", "↑", "↖", "←", "↙", "↓", "↘"};

/// Rows of characters, each some bytes of UTF-8 and one column wide.
class Sheet {
 public:
  Sheet(int rows, int columns)
      : columns_(columns),
        cells_(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), " "),
        rows_(rows) {}

  void Put(int row, int column, const std::string& character) {
    if (row < 0 || row >= rows_ || column < 0 || column >= columns_) return;
    cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)] =
        character;
  }
  void Write(int row, int column, const std::string& text) {
    for (const char c : text) Put(row, column++, (c & 0x80) != 0 ? "?" : std::string(1, c));
  }
  std::string Text() const {
    std::string text;
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      text += cells_[i];
      if ((i + 1) % static_cast<std::size_t>(columns_) == 0) text += '\n';
    }
    return text;
  }

 private:
  int columns_;
  std::vector<std::string> cells_;
  int rows_;
};

std::string PrefixOfArena(const std::string& channel) {
  for (const std::string_view suffix : kChannelSuffixes)
    if (channel.ends_with(suffix)) return channel.substr(0, channel.size() - suffix.size());
  return channel;
}

/// 1, 2 or 5 times a power of ten, at least that.
double RoundUp(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= least) return factor * power;
  return 10 * power;
}

std::string BarText(double metres) {
  return metres < 1 ? fmt::format("{:g} cm", 100 * metres) : fmt::format("{:g} m", metres);
}

const char* ArrowOf(double heading_rad) {
  const double eighths = heading_rad / (std::numbers::pi / 4);
  if (!std::isfinite(eighths)) return "o";
  return kArrows[static_cast<std::size_t>((static_cast<int>(std::lround(eighths)) % 8 + 8) % 8)];
}

}  // namespace

bool LiveArena::IsBest(const std::string& prefix, Source source, MonotonicTime now) {
  Best& best = best_[prefix];
  if (source < best.source && now - best.at < kBestLasts) return false;
  best = {source, now};
  return true;
}

void LiveArena::Put(const std::string& prefix, const std::string& name, const RigidTransform& pose, bool in_world,
                    MonotonicTime now, bool coasting, bool off_floor) {
  if (!pose.translation.allFinite()) return;
  bodies_[{prefix, name}] = {.position = pose.translation.head<2>(),
                             .heading_rad = HeadingRad(pose.rotation),
                             .in_world = in_world,
                             .coasting = coasting,
                             .off_floor = off_floor,
                             .arrived = now};
}

void LiveArena::Add(const std::string& channel, const PosesMessage& message, MonotonicTime now) {
  const std::string prefix = PrefixOfArena(channel);
  if (!IsBest(prefix, Source::kMarkers, now)) return;
  for (const MarkerPose& marker : message.markers)
    if (marker.id && marker.has_pose)
      Put(prefix, std::to_string(*marker.id), marker.camera_from_marker, message.frame == "world", now);
}

void LiveArena::Add(const std::string& channel, const RobotsMessage& message, MonotonicTime now) {
  const std::string prefix = PrefixOfArena(channel);
  if (!IsBest(prefix, Source::kRobots, now)) return;
  for (const RobotPose& robot : message.robots)
    Put(prefix, robot.name, robot.frame_from_body, message.header.frame == "world", now, false,
        robot.floor && robot.floor->off_floor);
}

void LiveArena::Add(const std::string& channel, const TracksMessage& message, MonotonicTime now) {
  const std::string prefix = PrefixOfArena(channel);
  if (!IsBest(prefix, Source::kTracks, now)) return;
  for (const TrackState& track : message.tracks)
    Put(prefix, track.key.robot.empty() ? std::to_string(track.key.id) : track.key.robot, track.frame_from_body,
        message.header.frame == "world", now, track.coasting);
}

std::string LiveArena::Text(MonotonicTime now, int lines, int columns) {
  bodies_.EraseIf([&](const Body& body) { return now - body.arrived > kGoneAfter; });
  Eigen::AlignedBox2d bounds;
  bool in_world = false;
  bodies_.ForEach([&](const Key&, const Body& body) {
    bounds.extend(body.position);
    in_world = in_world || body.in_world;
    return true;
  });
  if (bodies_.empty()) return "nobody is seen\n";
  const int rows = lines - 1;
  const Eigen::Vector2d middle = bounds.center(), span = bounds.sizes() * 1.2 + Eigen::Vector2d::Constant(0.2);
  // To a round number, so that it does not breathe with every step of a robot.
  const double metres_per_column = RoundUp(std::max(span.x() / columns, span.y() / (kAspect * rows)));
  // A camera's own frame has y downwards.
  const double up = in_world ? 1 : -1;
  Sheet sheet(rows, columns);
  bodies_.ForEach([&](const Key& key, const Body& body) {
    const Eigen::Vector2d offset = body.position - middle;
    const int column = columns / 2 + static_cast<int>(std::lround(offset.x() / metres_per_column));
    const int row = rows / 2 - static_cast<int>(std::lround(up * offset.y() / (kAspect * metres_per_column)));
    const bool lost = body.coasting || now - body.arrived > milliseconds(500);
    sheet.Put(row, column, lost ? "." : ArrowOf(up * body.heading_rad));
    sheet.Write(row, column + 1, Printable(key.name) + (body.off_floor ? " off the floor" : lost ? " lost" : ""));
    return true;
  });
  const double bar = RoundUp(8 * metres_per_column);
  const auto bar_columns = static_cast<std::size_t>(std::lround(bar / metres_per_column));
  std::string scale = "|" + std::string(bar_columns > 2 ? bar_columns - 2 : 0, '-') + "| " + BarText(bar) +
                      fmt::format(", {} in the {}", bodies_.size(), in_world ? "world" : "camera's frame");
  scale.resize(std::min(scale.size(), static_cast<std::size_t>(columns)));
  return sheet.Text() + scale + "\n";
}

}  // namespace chequer
