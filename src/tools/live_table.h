#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <utility>

#include "publish/messages.h"
#include "tools/recent_map.h"

namespace chequer {

/// What is seen now, as a table for a terminal: a line a channel and one a marker, with id, position, heading, rate and
/// age. Markers that were not seen for ten seconds leave it. One thread.
class LiveTable {
 public:
  /// A frame arrived at `now`, a time of this host.
  void Add(const std::string& channel, const PosesMessage& message, MonotonicTime now);

  /// The table, at most `max_lines` lines; says how many markers found no place. @pre max_lines ≥ 3.
  std::string Text(MonotonicTime now, int max_lines);

 private:
  /// Times of arrival within the last seconds.
  class Arrivals {
   public:
    void Add(MonotonicTime now);
    double RateHz(MonotonicTime now) const;
    MonotonicTime last() const { return times_.back(); }

   private:
    void Forget(MonotonicTime now);
    std::deque<MonotonicTime> times_;
  };
  struct Channel {
    Arrivals arrivals;
    std::uint64_t frames_dropped = 0;
  };
  struct Marker {
    MarkerPose pose;
    Arrivals arrivals;
    std::chrono::microseconds age_at_arrival{};  ///< from capture to publishing, of the publisher's clock
  };
  struct Key {
    std::string channel;
    int family = 0;
    std::uint64_t id = 0;
    auto operator<=>(const Key&) const = default;
  };

  // More than anybody has; bounds for what may come from the network.
  static constexpr std::size_t kMaxChannels = 64;
  static constexpr std::size_t kMaxMarkers = 4096;

  RecentMap<std::string, Channel> channels_{kMaxChannels};
  RecentMap<Key, Marker> markers_{kMaxMarkers};
};

}  // namespace chequer
