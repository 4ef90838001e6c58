#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <variant>

#include "publish/messages.h"

namespace chequer {

/// Turns messages into the bytes of their LCM types (lcmtypes/). Holds scratch memory; one a thread.
class WireEncoder {
 public:
  WireEncoder();
  ~WireEncoder();
  WireEncoder(WireEncoder&&) noexcept;
  WireEncoder& operator=(WireEncoder&&) noexcept;

  /// The bytes are valid until the next call.
  std::span<const std::uint8_t> Encode(const PosesMessage& message);
  std::span<const std::uint8_t> Encode(const StatusMessage& message);
  std::span<const std::uint8_t> Encode(const RobotsMessage& message);
  std::span<const std::uint8_t> Encode(const TracksMessage& message);

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

using ReceivedMessage = std::variant<PosesMessage, StatusMessage, RobotsMessage, TracksMessage>;

/// What bytes from LCM say; nothing where they are none of the four types, of another version of them, cut off, or
/// name a variant, size or state that does not exist.
std::optional<ReceivedMessage> DecodeMessage(std::span<const std::uint8_t> bytes);

}  // namespace chequer
