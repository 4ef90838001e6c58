#pragma once

#include <cstddef>
#include <cstdint>

// A message of LCM that fits into one datagram: the word below, a number (32 bits), both big-endian, the channel's name
// with its zero byte, then the message.

namespace chequer {

inline constexpr std::uint32_t kShortLcmMessage = 0x4c433032;  // "LC02"
inline constexpr std::size_t kLcmHeaderBytes = 8;

}  // namespace chequer
