#include "support/tcp_server.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <system_error>

#include "support/deadline.h"

namespace chequer::test {

TcpServer::TcpServer(Manner manner, std::string greeting)
    : listening_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)), greeting_(std::move(greeting)) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  if (bind(listening_.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
      listen(listening_.get(), 8) != 0 ||
      getsockname(listening_.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
    throw std::system_error(errno, std::generic_category(), "a server for a test");
  port_ = ntohs(address.sin_port);
  if (manner == Manner::kSilent) return;
  thread_ = std::thread([this, reads = manner == Manner::kListens] { Serve(reads); });
}

TcpServer::~TcpServer() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    if (client_ >= 0) shutdown(client_, SHUT_RDWR);
  }
  came_.notify_all();
  shutdown(listening_.get(), SHUT_RDWR);  // ends accept
  if (thread_.joinable()) thread_.join();
}

void TcpServer::SetGreeting(std::string greeting) {
  const std::lock_guard lock(mutex_);
  greeting_ = std::move(greeting);
}

void TcpServer::Serve(bool reads) {
  while (true) {
    const UniqueFd client(accept(listening_.get(), nullptr, nullptr));
    std::string greeting;
    {
      const std::lock_guard lock(mutex_);
      if (stop_ || !client.valid()) return;
      client_ = client.get();
      greeting = greeting_;
    }
    send(client.get(), greeting.data(), greeting.size(), MSG_NOSIGNAL);
    if (!reads) {
      std::unique_lock lock(mutex_);
      came_.wait(lock, [&] { return stop_; });
      client_ = -1;
      return;
    }
    std::array<char, 4096> part{};
    for (ssize_t count = 0; (count = recv(client.get(), part.data(), part.size(), 0)) > 0;) {
      const std::lock_guard lock(mutex_);
      bytes_.append(part.data(), static_cast<std::size_t>(count));
      came_.notify_all();
    }
    const std::lock_guard lock(mutex_);
    client_ = -1;
  }
}

std::string TcpServer::WaitForBytes(std::size_t count) {
  std::unique_lock lock(mutex_);
  came_.wait_for(lock, kPatience, [&] { return bytes_.size() >= count; });
  return bytes_;
}

std::string LcmGreeting() { return std::string("\x28\x76\x17\xfa\0\0\1\0", 8); }

}  // namespace chequer::test
