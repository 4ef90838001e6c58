#include "daemon/notify.h"

#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <systemd/sd-daemon.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <mutex>
#include <string_view>
#include <utility>

#include "core/unique_fd.h"

namespace chequer {
namespace {

std::string_view VariableOf(std::string_view message) { return message.substr(0, message.find('=')); }

/// Messages to the service manager, in their order. sd_notify() waits while the manager's queue is full, for ever where
/// the manager hangs. Here a message waits until the next one is sent, and of each variable the newest alone.
class Messages {
 public:
  void Send(std::string message) {
    const char* name = std::getenv("NOTIFY_SOCKET");
    if (name == nullptr) return;
    const std::string_view path = name;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    // Those of virtual machines (vsock:) are sd_notify's.
    if ((!path.starts_with('/') && !path.starts_with('@')) || path.size() >= sizeof address.sun_path) {
      sd_notify(0, message.c_str());
      return;
    }
    path.copy(address.sun_path, path.size());
    const bool abstract = path.starts_with('@');
    if (abstract) address.sun_path[0] = '\0';
    // The zero behind a path is a part of it, that behind an abstract name is not.
    const std::size_t size = offsetof(sockaddr_un, sun_path) + path.size() + (abstract ? 0 : 1);

    const std::lock_guard lock(mutex_);
    std::erase_if(waiting_, [&](const std::string& other) { return VariableOf(other) == VariableOf(message); });
    waiting_.push_back(std::move(message));
    const UniqueFd fd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    for (; !waiting_.empty(); waiting_.pop_front()) {
      const std::string& first = waiting_.front();
      const ssize_t sent = sendto(fd.get(), first.data(), first.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                                  reinterpret_cast<const sockaddr*>(&address), static_cast<socklen_t>(size));
      if (sent < 0 && errno == EAGAIN) return;
    }
  }

 private:
  std::mutex mutex_;
  std::deque<std::string> waiting_;
};

void Notify(std::string message) {
  static Messages messages;
  messages.Send(std::move(message));
}

}  // namespace

void NotifyReady() { Notify("READY=1"); }

void NotifyReloading() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  // Later versions of systemd want to know which reload it was.
  Notify(fmt::format("RELOADING=1\nMONOTONIC_USEC={}", now.tv_sec * 1'000'000 + now.tv_nsec / 1000));
}

void NotifyStopping() { Notify("STOPPING=1"); }

void NotifyStatus(const std::string& line) { Notify("STATUS=" + line); }

void NotifyStarting(std::chrono::microseconds may_take) {
  Notify(fmt::format("EXTEND_TIMEOUT_USEC={}", may_take.count()));
}

void NotifyAlive() { Notify("WATCHDOG=1"); }

std::optional<std::chrono::microseconds> WatchdogPeriod() {
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) <= 0) return std::nullopt;
  return std::chrono::microseconds(period_us);
}

std::string StatusLine(const StatusMessage& status) {
  if (status.camera_state == CameraState::kWaiting)
    return status.camera_message.empty() ? "waiting for the camera"
                                         : "waiting for the camera: " + status.camera_message;
  if (!status.publisher.message.empty()) return status.publisher.message;
  if (!status.camera_message.empty()) return status.camera_message;
  std::string line = fmt::format("{:.1f} frames/s, {:.1f} markers a frame, {} frames dropped", status.publish_rate_hz,
                                 status.markers_mean, status.frames_dropped);
  for (const StageLatency& stage : status.stages)
    if (stage.stage == "total" && stage.frames > 0)
      line += fmt::format(", latency {:.1f} ms (99 %: {:.1f} ms)", static_cast<double>(stage.median.count()) / 1000,
                          static_cast<double>(stage.p99.count()) / 1000);
  return line;
}

}  // namespace chequer
