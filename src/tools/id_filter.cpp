#include "tools/id_filter.h"

#include <algorithm>
#include <variant>
#include <vector>

#include "tools/marker_options.h"

namespace chequer {

IdFilter::IdFilter(const std::string& list) {
  if (list.empty()) return;
  const std::vector<std::uint64_t> ids = ParseRoster(list);
  ids_.insert(ids.begin(), ids.end());
}

void IdFilter::Keep(ReceivedMessage& message) const {
  const auto wanted = [&](std::uint64_t id) { return ids_.contains(id); };
  if (auto* poses = std::get_if<PosesMessage>(&message))
    std::erase_if(poses->markers, [&](const MarkerPose& marker) { return !marker.id || !wanted(*marker.id); });
  if (auto* robots = std::get_if<RobotsMessage>(&message))
    std::erase_if(robots->robots, [&](const RobotPose& robot) {
      return std::none_of(robot.ids.begin(), robot.ids.begin() + robot.marker_count, wanted);
    });
  if (auto* tracks = std::get_if<TracksMessage>(&message))
    std::erase_if(tracks->tracks, [&](const TrackState& track) { return !wanted(track.key.id); });
}

}  // namespace chequer
