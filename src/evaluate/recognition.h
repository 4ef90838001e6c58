#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/geometry.h"

namespace chequer {

/// A marker as some frame shows it.
struct SeenMarker {
  std::optional<std::uint64_t> id;                   ///< empty where undecided
  std::optional<RigidTransform> camera_from_marker;  ///< where a pose was measured
};
/// What one frame of a run shows.
using SeenFrame = std::vector<SeenMarker>;

/// How often the marker of a run was recognised: the publication's Table III.
struct Recognition {
  std::uint64_t id = 0;
  int frames = 0;
  int recognised = 0;  ///< frames in which the id was read
  int undecided = 0;   ///< of the others, those in which a board was found whose id was left undecided
  int wrong = 0;       ///< detections with an id that is none of the run's
  double Rate() const { return frames == 0 ? 0 : static_cast<double>(recognised) / frames; }
};

/// The id that most frames show; the smallest of several. Nothing where no frame shows one.
std::optional<std::uint64_t> MostSeen(std::span<const SeenFrame> frames);

/// Counts the frames in which `id` was read. @param others further ids that truly are there; they count nowhere.
Recognition CountRecognised(std::span<const SeenFrame> frames, std::uint64_t id,
                            std::span<const std::uint64_t> others = {});

/// Ids that are seen beside `id` again and again: other markers that are there, not misread ones, which are seen
/// instead of it. Ascending.
std::vector<std::uint64_t> SeenBeside(std::span<const SeenFrame> frames, std::uint64_t id);

/// The poses of an id, frame by frame; frames without one are left out, and of several in a frame the first counts.
std::vector<RigidTransform> PosesOf(std::span<const SeenFrame> frames, std::uint64_t id);

}  // namespace chequer
