#include "publish/tcpq_connection.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace chequer {
namespace {

using Instant = std::chrono::steady_clock::time_point;

// LCM's protocol: numbers of 32 bits, the highest byte first. Each side begins with its magic number and a version; a
// message is its kind, the channel and the payload, each of these two behind its length.
constexpr std::uint32_t kMagicServer = 0x287617fa;
constexpr std::uint32_t kMagicClient = 0x287617fb;
constexpr std::uint32_t kVersion = 0x0100;
constexpr std::uint32_t kPublish = 1;

[[noreturn]] void Fail(int error) { throw std::runtime_error(std::strerror(error)); }

/// Waits until the socket is ready for `events`. Throws when the time is over.
void Wait(const UniqueFd& socket, short events, Instant deadline, const char* when_late) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd waiting{socket.get(), events, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (ready > 0) return;
    if (ready == 0) throw std::runtime_error(when_late);
    if (errno != EINTR) Fail(errno);
  }
}

UniqueFd Connect(const LcmUrl& url, Instant deadline) {
  UniqueFd fd(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!fd.valid()) Fail(errno);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url.port);
  inet_pton(AF_INET, url.address.c_str(), &address.sin_addr);
  if (connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  if (errno != EINPROGRESS) Fail(errno);
  Wait(fd, POLLOUT, deadline, std::strerror(ETIMEDOUT));
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &size);
  if (error != 0) Fail(error);
  return fd;
}

void SendAll(const UniqueFd& socket, std::span<const std::uint8_t> bytes, Instant deadline) {
  while (!bytes.empty()) {
    const ssize_t count = send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count >= 0)
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    else if (errno == EAGAIN || errno == EWOULDBLOCK)
      Wait(socket, POLLOUT, deadline, "the server does not read what it is sent");
    else if (errno != EINTR)
      Fail(errno);
  }
}

void ReceiveAll(const UniqueFd& socket, std::span<std::uint8_t> bytes, Instant deadline) {
  while (!bytes.empty()) {
    const ssize_t count = recv(socket.get(), bytes.data(), bytes.size(), 0);
    if (count > 0)
      bytes = bytes.subspan(static_cast<std::size_t>(count));
    else if (count == 0)
      throw std::runtime_error("the server closed the connection");
    else if (errno == EAGAIN || errno == EWOULDBLOCK)
      Wait(socket, POLLIN, deadline, "the server accepts and says nothing");
    else if (errno != EINTR)
      Fail(errno);
  }
}

void Append(std::uint32_t number, std::vector<std::uint8_t>& bytes) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
}

template <typename Text>
void AppendCounted(const Text& text, std::vector<std::uint8_t>& bytes) {
  Append(static_cast<std::uint32_t>(text.size()), bytes);
  bytes.insert(bytes.end(), text.begin(), text.end());
}

}  // namespace

TcpqConnection::TcpqConnection(const LcmUrl& url) {
  const Instant deadline = std::chrono::steady_clock::now() + kPatience;
  socket_ = Connect(url, deadline);
  const int yes = 1;  // a message is sent at once, however short
  setsockopt(socket_.get(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  Append(kMagicClient, bytes_);
  Append(kVersion, bytes_);
  SendAll(socket_, bytes_, deadline);
  std::array<std::uint8_t, 8> greeting{};
  ReceiveAll(socket_, greeting, deadline);
  std::uint32_t magic = 0;
  for (int i = 0; i < 4; ++i) magic = magic << 8 | greeting[static_cast<std::size_t>(i)];
  if (magic != kMagicServer) throw std::runtime_error("what answers is no LCM TCP server");
}

std::string TcpqConnection::Send(const std::string& channel, std::span<const std::uint8_t> message) {
  bytes_.clear();
  Append(kPublish, bytes_);
  AppendCounted(channel, bytes_);
  AppendCounted(message, bytes_);
  try {
    SendAll(socket_, bytes_, std::chrono::steady_clock::now() + kPatience);
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace chequer
