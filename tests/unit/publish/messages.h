#pragma once

#include <cstddef>

#include "publish/messages.h"

namespace chequer::test {

/// A message in which every field has a value of its own; marker i has id i.
PosesMessage SamplePoses(std::size_t markers);

/// A message in which every field has a value of its own.
StatusMessage SampleStatus();

/// Messages in which every field has a value of its own; robot i is named "robot <i>" and bears i and i + 100.
RobotsMessage SampleRobots(std::size_t robots);
TracksMessage SampleTracks(std::size_t tracks);

}  // namespace chequer::test
