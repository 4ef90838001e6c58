#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "core/unique_fd.h"

namespace chequer::test {

/// A TCP server on a free port of the loopback interface, for one client at a time.
class TcpServer {
 public:
  enum class Manner {
    kSilent,   ///< the kernel accepts; nobody says or reads anything
    kGreets,   ///< says what it was told to, and then reads nothing
    kListens,  ///< says it, and reads all that comes
  };
  explicit TcpServer(Manner manner, std::string greeting = {});
  ~TcpServer();

  std::uint16_t port() const { return port_; }
  std::string url() const { return "tcpq://127.0.0.1:" + std::to_string(port_); }
  /// Says that to clients from now on.
  void SetGreeting(std::string greeting);
  /// All bytes that came so far, once there are that many of them; fewer only if they do not come.
  std::string WaitForBytes(std::size_t count);

 private:
  void Serve(bool reads);

  UniqueFd listening_;
  std::uint16_t port_ = 0;
  std::mutex mutex_;
  std::condition_variable came_;
  std::string greeting_, bytes_;
  int client_ = -1;  ///< that is being served
  bool stop_ = false;
  std::thread thread_;
};

/// What an LCM TCP server greets its clients with.
std::string LcmGreeting();

}  // namespace chequer::test
