#include "publish/sender_claim.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>

namespace chequer {
namespace {

/// More is not read in one call: somebody who floods the socket does not keep the daemon.
constexpr int kMostReadAtOnce = 64;

struct Address {
  sockaddr_un address{};
  socklen_t bytes = 0;
};

/// In the abstract name space: it begins with a zero byte, needs no folder, and goes with the process.
Address AddressOf(const std::string& name) {
  Address result;
  result.address.sun_family = AF_UNIX;
  const std::size_t length = std::min(name.size(), sizeof result.address.sun_path - 1);
  std::memcpy(result.address.sun_path + 1, name.data(), length);
  result.bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  return result;
}

}  // namespace

SenderClaim::SenderClaim(const std::string& what, std::uint64_t instance)
    : name_("chequer/" + what),
      instance_(instance),
      socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {}

void SenderClaim::Claim() {
  const Address own = AddressOf(name_);
  is_holder_ = ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&own.address), own.bytes) == 0;
}

bool SenderClaim::Hears() {
  bool heard = false;
  for (int i = 0; i < kMostReadAtOnce; ++i) {
    std::uint64_t other = 0;
    const ssize_t bytes = ::recv(socket_.get(), &other, sizeof other, 0);
    if (bytes < 0) break;
    heard = heard || (bytes == sizeof other && other != instance_);
  }
  return heard;
}

bool SenderClaim::SeesAnother() {
  if (!socket_.valid()) return false;
  if (!is_holder_) Claim();
  if (is_holder_) return Hears();
  const Address holder = AddressOf(name_);
  const ssize_t sent = ::sendto(socket_.get(), &instance_, sizeof instance_, 0,
                                reinterpret_cast<const sockaddr*>(&holder.address), holder.bytes);
  // A holder that does not read any more is there all the same.
  return sent >= 0 || errno == EAGAIN;
}

}  // namespace chequer
