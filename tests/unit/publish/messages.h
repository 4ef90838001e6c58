#pragma once

#include <cstddef>

#include "publish/messages.h"

namespace chequer::test {

/// A message in which every field has a value of its own; marker i has id i.
PosesMessage SamplePoses(std::size_t markers);

/// A message in which every field has a value of its own.
StatusMessage SampleStatus();

}  // namespace chequer::test
