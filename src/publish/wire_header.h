#pragma once

#include <string>

#include "publish/messages.h"
#include "publish/wire_values.h"

// What poses_t, robots_t and tracks_t begin with. Only for files of this folder, which know the generated types.

namespace chequer::wire_values {

/// Whether it is a text that LCM could have sent: they end with the first zero byte.
inline bool IsText(const std::string& text) { return text.find('\0') == std::string::npos; }

template <typename Wire>
void WriteHeader(const FrameHeader& header, Wire& wire) {
  wire.capture_utc_us = Microseconds(header.captured_utc);
  wire.capture_monotonic_us = Microseconds(header.captured_monotonic);
  wire.capture_instant = WireEnum(header.instant);
  wire.publish_utc_us = Microseconds(header.published_utc);
  wire.publish_monotonic_us = Microseconds(header.published_monotonic);
  wire.sequence = Signed(header.sequence);
  wire.camera = header.camera;
  wire.frame = header.frame;
}

/// False where a text is none.
template <typename Wire>
bool ReadHeader(const Wire& wire, FrameHeader& header) {
  if (!IsText(wire.camera) || !IsText(wire.frame)) return false;
  header.captured_utc = FromMicroseconds<UtcTime>(wire.capture_utc_us);
  header.captured_monotonic = FromMicroseconds<MonotonicTime>(wire.capture_monotonic_us);
  header.instant = ReadEnum<ExposureInstant>(wire.capture_instant);
  header.published_utc = FromMicroseconds<UtcTime>(wire.publish_utc_us);
  header.published_monotonic = FromMicroseconds<MonotonicTime>(wire.publish_monotonic_us);
  header.sequence = Unsigned(wire.sequence);
  header.camera = wire.camera;
  header.frame = wire.frame;
  return true;
}

}  // namespace chequer::wire_values
