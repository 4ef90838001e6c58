#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "core/unique_fd.h"

namespace chequer::test {

/// A service manager that is told how the daemon fares (sd_notify(3)).
class ServiceManager {
 public:
  explicit ServiceManager(const std::filesystem::path& path) : path_(path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.string().copy(address.sun_path, sizeof address.sun_path - 1);
    if (bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error("cannot bind " + path.string());
    const timeval timeout{20, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  }
  std::string variable() const { return "NOTIFY_SOCKET=" + path_.string(); }

  /// Waits until it is told something that begins so; empty when it is not in time.
  std::string WaitFor(const std::string& begin) {
    std::array<char, 4096> bytes{};
    while (true) {
      const ssize_t count = recv(socket_.get(), bytes.data(), bytes.size(), 0);
      if (count < 0) return {};
      const std::string text(bytes.data(), static_cast<std::size_t>(count));
      if (text.starts_with(begin)) return text;
    }
  }

  /// Reads what has come, if it is this; false where nothing has come, or something else, which is lost.
  bool Reads(const std::string& message) {
    std::array<char, 4096> bytes{};
    const ssize_t count = recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    return count >= 0 && std::string(bytes.data(), static_cast<std::size_t>(count)) == message;
  }

 private:
  std::filesystem::path path_;
  UniqueFd socket_{socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
};

}  // namespace chequer::test
