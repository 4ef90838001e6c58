#pragma once

#include <map>
#include <string>

#include "publish/messages.h"
#include "tools/recent_map.h"

namespace chequer {

/// The robots as a map from above, of characters: an arrow each that points where it heads, and its name. Tracks are
/// shown where there are some, else robots, else markers. One thread.
class LiveArena {
 public:
  /// A message arrived at `now`, a time of this host.
  void Add(const std::string& channel, const PosesMessage& message, MonotonicTime now);
  void Add(const std::string& channel, const RobotsMessage& message, MonotonicTime now);
  void Add(const std::string& channel, const TracksMessage& message, MonotonicTime now);

  /// The map with a scale and who is where, at most so large. It grows as robots come, and shrinks again when they have
  /// gone. @pre lines ≥ 5, columns ≥ 20.
  std::string Text(MonotonicTime now, int lines, int columns);

 private:
  enum class Source : std::uint8_t { kMarkers, kRobots, kTracks };
  struct Key {
    std::string prefix, name;
    auto operator<=>(const Key&) const = default;
  };
  struct Body {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();
    double heading_rad = 0;
    bool in_world = false;
    bool coasting = false, off_floor = false;
    MonotonicTime arrived{};
  };
  struct Best {
    Source source = Source::kMarkers;
    MonotonicTime at{};
  };
  /// Whether this source is the best there is of that camera lately.
  bool IsBest(const std::string& prefix, Source source, MonotonicTime now);
  void Put(const std::string& prefix, const std::string& name, const RigidTransform& pose, bool in_world,
           MonotonicTime now, bool coasting = false, bool off_floor = false);

  RecentMap<Key, Body> bodies_{1024};
  RecentMap<std::string, Best> best_{64};
};

}  // namespace chequer
