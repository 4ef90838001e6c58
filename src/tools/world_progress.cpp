#include "tools/world_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace chequer {

WorldProgress::WorldProgress(const std::optional<CameraSetup>& setup, const CameraModel& camera,
                             std::vector<std::uint64_t> wanted, Solver solve)
    : watch_(setup), camera_(camera), wanted_(std::move(wanted)), solve_(std::move(solve)) {
  message_.kind = CalibrationMessage::Kind::kWorld;
  message_.width = camera.width;
  message_.height = camera.height;
}

void WorldProgress::TakeSeen(const std::vector<StillMarker>& seen) {
  message_.references.clear();
  message_.rms = 0;
  for (const std::uint64_t id : wanted_) {
    CalibrationMessage::Reference reference{.id = id};
    const auto found =
        std::find_if(seen.begin(), seen.end(), [&](const StillMarker& marker) { return marker.id == id; });
    if (found != seen.end()) {
      reference.frames = found->frames;
      reference.center_px = camera_.Project(found->camera_from_marker.translation).cast<float>();
    }
    message_.references.push_back(reference);
  }
}

void WorldProgress::TakeResult(const WorldResult& result) {
  message_.rms = result.estimate.rms_m;
  for (const ReferenceResidual& residual : result.estimate.residuals) {
    const std::uint64_t id = result.markers[residual.seen].id;
    for (CalibrationMessage::Reference& reference : message_.references)
      if (reference.id == id) {
        reference.offset_m = residual.offset_m.cast<float>();
        reference.limit_m = residual.limit_m;
      }
  }
}

void WorldProgress::Look(const StillMarkers& still, int frames_wanted) {
  if (!watch_.IsDue()) return;
  const std::vector<StillMarker> seen = still.Means();
  message_.frames = still.frames();
  TakeSeen(seen);
  try {
    TakeResult(solve_(seen));
    message_.advice = fmt::format("keep still: {} of {} frames", still.frames(), frames_wanted);
  } catch (const std::runtime_error& error) {
    message_.advice = error.what();
  }
  watch_.Send(message_);
}

void WorldProgress::Finish(const WorldResult& result) {
  if (!watch_.IsWatched()) return;
  TakeSeen(result.markers);
  TakeResult(result);
  message_.state = CalibrationMessage::State::kDone;
  message_.advice = "enough";
  watch_.Send(message_);
}

void WorldProgress::Fail(const std::string& why) {
  if (!watch_.IsWatched()) return;
  message_.state = CalibrationMessage::State::kFailed;
  message_.advice = why;
  watch_.Send(message_);
}

}  // namespace chequer
