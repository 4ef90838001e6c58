#pragma once

#include <string>
#include <string_view>

namespace chequer {

// Channel names are part of what users rely on (interfaces: <prefix>_POSES, <prefix>_STATUS).
inline constexpr std::string_view kPosesSuffix = "_POSES";
inline constexpr std::string_view kStatusSuffix = "_STATUS";

/// LCM carries channel names of at most 63 bytes.
inline constexpr std::size_t kMaxChannelLength = 63;
inline constexpr std::size_t kMaxPrefixLength = kMaxChannelLength - kStatusSuffix.size();

inline std::string PosesChannel(std::string_view prefix) { return std::string(prefix).append(kPosesSuffix); }
inline std::string StatusChannel(std::string_view prefix) { return std::string(prefix).append(kStatusSuffix); }

/// Whether a prefix can be part of a channel name: 1 to kMaxPrefixLength of the characters A-Z a-z 0-9 _ -.
/// (LCM allows more; these need no quoting in its regular expressions, in shells and in file names.)
bool IsValidPrefix(std::string_view prefix);

}  // namespace chequer
