#include "evaluate/recognition.h"

#include <algorithm>
#include <map>

namespace chequer {

std::optional<std::uint64_t> MostSeen(std::span<const SeenFrame> frames) {
  std::map<std::uint64_t, int> counts;
  for (const SeenFrame& frame : frames)
    for (const SeenMarker& marker : frame)
      if (marker.id) ++counts[*marker.id];
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? std::nullopt : std::optional(most->first);
}

Recognition CountRecognised(std::span<const SeenFrame> frames, std::uint64_t id,
                            std::span<const std::uint64_t> others) {
  Recognition counts{.id = id, .frames = static_cast<int>(frames.size())};
  for (const SeenFrame& frame : frames) {
    bool read = false, undecided = false;
    for (const SeenMarker& marker : frame) {
      read |= marker.id == id;
      undecided |= !marker.id;
      counts.wrong +=
          marker.id && marker.id != id && std::find(others.begin(), others.end(), *marker.id) == others.end();
    }
    counts.recognised += read;
    counts.undecided += !read && undecided;
  }
  return counts;
}

std::vector<std::uint64_t> SeenBeside(std::span<const SeenFrame> frames, std::uint64_t id) {
  constexpr int kFewest = 3;
  constexpr double kLeastShare = 0.1;
  int with_id = 0;
  std::map<std::uint64_t, int> beside;
  for (const SeenFrame& frame : frames) {
    if (std::none_of(frame.begin(), frame.end(), [&](const SeenMarker& marker) { return marker.id == id; })) continue;
    ++with_id;
    for (const SeenMarker& marker : frame)
      if (marker.id && marker.id != id) ++beside[*marker.id];
  }
  std::vector<std::uint64_t> others;
  for (const auto& [other, count] : beside)
    if (count >= kFewest && count >= kLeastShare * with_id) others.push_back(other);
  return others;
}

std::vector<RigidTransform> PosesOf(std::span<const SeenFrame> frames, std::uint64_t id) {
  std::vector<RigidTransform> poses;
  for (const SeenFrame& frame : frames) {
    const auto seen = std::find_if(frame.begin(), frame.end(), [&](const SeenMarker& marker) {
      return marker.id == id && marker.camera_from_marker;
    });
    if (seen != frame.end()) poses.push_back(*seen->camera_from_marker);
  }
  return poses;
}

}  // namespace chequer
