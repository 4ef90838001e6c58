#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace chequer {

/// What a camera does wrong.
enum class FaultKind : std::uint8_t {
  kStall,     ///< nothing comes for a time
  kDrop,      ///< frames are lost: a gap in the sequence
  kTruncate,  ///< a frame comes in part: kCorrupt
  kCorrupt,   ///< a frame comes whose pixels are partly noise, and nobody noticed: kFrame
  kVanish,    ///< the camera is gone (kDisconnected) and comes back: after a time, or after attempts at opening it
};

/// One fault at one frame. Frames are counted from 0 as they come from the camera behind, lost ones included.
struct Fault {
  FaultKind kind = FaultKind::kStall;
  std::uint64_t frame = 0;
  std::uint64_t count = 1;               ///< frames that kDrop loses
  std::chrono::milliseconds duration{};  ///< of kStall, kVanish
  int failed_opens = 0;                  ///< of kVanish: so many Open() fail, if duration is 0
};

/// Reads one fault: "stall FRAME TIME", "drop FRAME COUNT", "truncate FRAME", "corrupt FRAME", "vanish FRAME TIME" or
/// "vanish FRAME COUNT opens", a time as 0.5s or 500ms. Throws std::runtime_error saying what would be right.
Fault ParseFault(std::string_view text);

/// Reads several, in any order, and returns them by frame. Throws as ParseFault; also where two are at one frame.
std::vector<Fault> ParseFaults(const std::vector<std::string>& texts);

}  // namespace chequer
