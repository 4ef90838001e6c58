#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "publish/lcm_subscriber.h"
#include "support/temporary_directory.h"

namespace chequer::test {

/// Puts the multicast route of the test's namespace there, or takes it away. Throws std::runtime_error if that fails.
void SetMulticastRoute(bool there);

/// The recording that tests replay: 60 frames at 20 a second, 8 markers in each, with truth.
std::filesystem::path DemoRecording();

/// A folder with configurations of chequerd for the demo recording.
class Workspace {
 public:
  /// Writes a configuration and returns its path. @param capture further lines of [capture]. @param rest further
  /// tables.
  std::string Configure(const std::string& capture, const std::string& rest = {},
                        const std::filesystem::path& recording = DemoRecording()) const;
  const std::filesystem::path& path() const { return folder_.path(); }

 private:
  TemporaryDirectory folder_;
};

/// What a subscriber received, in order.
struct Received {
  std::vector<PosesMessage> poses;
  std::vector<StatusMessage> statuses;

  bool HasEnded() const { return !statuses.empty() && statuses.back().camera_state == CameraState::kEnded; }
  /// How many frames the last status says were dropped for that reason.
  std::uint64_t Dropped(const std::string& reason) const;
};

/// Conditions of Subscriber::ReceiveUntil: so many messages came, from the beginning; the last status says that the
/// daemon waits for its camera.
inline auto HasPoses(std::size_t count) {
  return [count](const Received& got) { return got.poses.size() >= count; };
}
inline bool Waits(const Received& got) {
  return !got.statuses.empty() && got.statuses.back().camera_state == CameraState::kWaiting;
}

/// Listens from construction on.
class Subscriber {
 public:
  explicit Subscriber(const std::string& url = DefaultListenUrl());

  /// Receives until a condition holds; false when it does not within the time.
  bool ReceiveUntil(const std::function<bool(const Received&)>& condition,
                    std::chrono::milliseconds timeout = std::chrono::seconds(30));
  const Received& received() const { return received_; }

 private:
  Received received_;
  LcmSubscriber subscriber_;
};

}  // namespace chequer::test
