#include "publish/lcm_sink.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>

#include "publish/log_sink.h"
#include "publish/tcpq_connection.h"

namespace chequer {
namespace {

/// Whether that error is why a message did not go out; LCM leaves others behind in passing.
bool LosesMessages(int error) {
  constexpr std::array kLosing{ENETUNREACH, EHOSTUNREACH, ENETDOWN, EINVAL, EPERM, ENOBUFS, ENODEV, EIO};
  return std::find(kLosing.begin(), kLosing.end(), error) != kLosing.end();
}

/// Whatever LCM itself can write to without waiting.
class LibrarySink final : public LcmSink {
 public:
  explicit LibrarySink(const LcmUrl& url) : lcm_(url.text) {}

  bool good() { return lcm_.good(); }

  std::string Send(const std::string& channel, std::span<const std::uint8_t> message) override {
    // LCM 1.3.1 answers 0 for a message of several datagrams even where sending them failed; errno alone tells.
    errno = 0;
    const int status = lcm_.publish(channel, message.data(), static_cast<unsigned>(message.size()));
    const int error = errno;
    if (status == 0 && !LosesMessages(error)) return {};
    return error == 0 ? "LCM refused it" : std::strerror(error);
  }

  // A lost multicast route needs no new LCM: the same one works when the route is back.
  bool Recovers() const override { return true; }

 private:
  lcm::LCM lcm_;
};

class TcpqSink final : public LcmSink {
 public:
  explicit TcpqSink(const LcmUrl& url) : connection_(url) {}

  std::string Send(const std::string& channel, std::span<const std::uint8_t> message) override {
    return connection_.Send(channel, message);
  }
  bool Recovers() const override { return false; }

 private:
  TcpqConnection connection_;
};

}  // namespace

std::unique_ptr<LcmSink> OpenLcmSink(const LcmUrl& url, const Clock& clock, std::string& problem) {
  if (url.provider == LcmProvider::kTcpQueue) {
    try {
      return std::make_unique<TcpqSink>(url);
    } catch (const std::runtime_error& error) {
      problem = TcpqComplaint(url, error.what());
      return nullptr;
    }
  }
  problem = ProbeLcmUrl(url);
  if (!problem.empty()) return nullptr;
  if (url.provider == LcmProvider::kFile) {
    try {
      return std::make_unique<LogSink>(url, clock);
    } catch (const std::runtime_error& error) {
      problem = "LCM at " + url.text + " cannot be opened: " + error.what();
      return nullptr;
    }
  }
  auto sink = std::make_unique<LibrarySink>(url);
  if (sink->good()) return sink;
  problem = "LCM at " + url.text + " cannot be opened; LCM's own message says why";
  return nullptr;
}

}  // namespace chequer
