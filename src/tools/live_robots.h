#pragma once

#include <optional>
#include <string>

#include "publish/messages.h"
#include "tools/recent_map.h"

namespace chequer {

/// Robots and tracks as they are now, as a table for a terminal: a line each with name, position, heading, speed, yaw
/// rate, age and what is to be noticed (coasting, off the floor). Those not heard of for ten seconds leave it. One
/// thread.
class LiveRobots {
 public:
  /// A message arrived at `now`, a time of this host.
  void Add(const std::string& channel, const RobotsMessage& message, MonotonicTime now);
  void Add(const std::string& channel, const TracksMessage& message, MonotonicTime now);

  /// Nothing to show; Text is empty then.
  bool empty() const { return rows_.empty(); }
  /// The table, at most `max_lines` lines; says how many found no place. @pre max_lines ≥ 3.
  std::string Text(MonotonicTime now, int max_lines);

 private:
  struct Row {
    RigidTransform pose;
    std::optional<double> speed_m_s, yaw_rate_rad_s;  ///< of tracks
    MonotonicTime arrived{};
    std::chrono::microseconds age_at_arrival{};  ///< from capture to publishing, of the publisher's clock
    bool coasting = false;
    bool off_floor = false;
  };
  struct Key {
    std::string prefix;  ///< of the channel: tracks and robots of one daemon share rows
    std::string name;
    int family = 0;
    std::uint64_t id = 0;
    auto operator<=>(const Key&) const = default;
  };

  /// More than anybody has; a bound for what may come from the network.
  static constexpr std::size_t kMaxRows = 4096;

  RecentMap<Key, Row> rows_{kMaxRows};
};

}  // namespace chequer
