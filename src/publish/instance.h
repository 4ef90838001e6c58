#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "publish/messages.h"

namespace chequer {

/// StatusMessage::detections holds under this name a number that tells daemons of one camera name apart. It is no
/// count; status_t has no other place that earlier programs accept.
inline constexpr std::string_view kInstanceName = "instance";

/// The number of this process: random, 1 to 2^48 − 1, so that JSON keeps it. The same in each call.
std::uint64_t InstanceOfProcess();

/// The number in a status; nothing where a daemon of before 0.2 sent it.
std::optional<std::uint64_t> InstanceOf(const StatusMessage& status);

}  // namespace chequer
