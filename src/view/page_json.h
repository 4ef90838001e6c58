#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "publish/messages.h"
#include "publish/view_messages.h"
#include "view/topics.h"

// What a page is told once a second or on a click: eight bytes (kind, 0, the camera's number, 0), then JSON.

namespace chequer {

SharedPacket StatusPacket(const StatusMessage& message, std::uint16_t index);
SharedPacket CameraPacket(const CameraMessage& message, std::uint16_t index);
SharedPacket DetailPacket(const DetailMessage& message, std::uint16_t index);
SharedPacket CalibrationPacket(const CalibrationMessage& message, std::uint16_t index);

/// One second of a camera, for the time line.
struct HistoryEntry {
  UtcTime utc{};
  double capture_rate_hz = 0, publish_rate_hz = 0, markers_mean = 0;
  double median_ms = 0, p99_ms = 0;  ///< of the whole latency
  std::uint64_t dropped = 0;         ///< since the entry before
  std::uint64_t deferred = 0;
  CameraState camera_state = CameraState::kWaiting;
};
HistoryEntry EntryOf(const StatusMessage& status, std::uint64_t dropped_before);
SharedPacket HistoryPacket(const std::deque<HistoryEntry>& entries, std::uint16_t index);

/// What a page is told of the server.
struct ServerState {
  std::uint64_t instance = 0;  ///< of the process: tells a page that the server was restarted
  std::string version;
  std::string lcm_url;
  std::string trouble;  ///< why nothing can be heard; empty where nothing is wrong
  std::uint64_t unreadable = 0;
  struct Camera {
    std::string prefix;  ///< of its channels
    std::string name;
  };
  std::vector<Camera> cameras;  ///< in the order of their numbers
  struct Replay {
    std::string log;
    UtcTime first{}, last{}, now{};
    double speed = 1;
    bool playing = true;
  };
  std::optional<Replay> replay;
};
SharedPacket ServerPacket(const ServerState& state);

}  // namespace chequer
