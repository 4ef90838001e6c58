#pragma once

#include <chequer/robots_t.hpp>
#include <chequer/tracks_t.hpp>
#include <optional>

#include "publish/messages.h"

// Robots and tracks to LCM's types and back. Only for files of this folder: the generated headers are private to it.

namespace chequer {

void Write(const RobotsMessage& message, robots_t& wire);
void Write(const TracksMessage& message, tracks_t& wire);

/// Nothing where a value names what does not exist.
std::optional<RobotsMessage> Read(const robots_t& wire);
std::optional<TracksMessage> Read(const tracks_t& wire);

}  // namespace chequer
