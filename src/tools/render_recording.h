#pragma once

#include "capture/recording_writer.h"
#include "simulate/render.h"

namespace chequer {

inline constexpr const char* kRenderedCamera = "camera.toml";
inline constexpr const char* kRenderedTruth = "truth.jsonl";

/// 2024-01-01T00:00:00Z: the same frames are to have the same times whenever they are rendered.
inline constexpr UtcTime kRenderedUtc{std::chrono::seconds(1704067200)};
/// Not 0, which reads like a time that was forgotten.
inline constexpr MonotonicTime kRenderedMonotonic{std::chrono::seconds(1)};

/// What recording.toml says of rendered frames.
RecordingInfo RenderedInfo(const RenderOptions& options, double fps);

}  // namespace chequer
