#pragma once

#include <unistd.h>

#include <utility>

namespace chequer {

/// Owns a file descriptor; −1 is none. Move-only.
class UniqueFd {
 public:
  UniqueFd() = default;
  explicit UniqueFd(int fd) : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~UniqueFd() {
    if (fd_ >= 0) ::close(fd_);
  }

  int get() const { return fd_; }
  bool valid() const { return fd_ >= 0; }
  /// Closes it now; 0, or the errno of close(2), which is where some file systems first tell of a full disk.
  int Close();

 private:
  int fd_ = -1;
};

}  // namespace chequer
