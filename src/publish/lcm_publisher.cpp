#include "publish/lcm_publisher.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/back_off.h"
#include "core/repeated_cause.h"
#include "publish/channels.h"
#include "publish/lcm_url.h"
#include "publish/wire.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;

// The first retries come quickly, because at boot a route appears within seconds; later ones cost nothing noticeable.
constexpr milliseconds kFirstRetry{250};
constexpr milliseconds kLongestRetry{5000};
/// A log on a full disk takes one message into its buffer for each that fails: it works again when none has failed for
/// so long.
constexpr milliseconds kSteady{2000};

/// Whether that error is why a message did not go out; LCM leaves others behind in passing.
bool LosesMessages(int error) {
  constexpr std::array kLosing{ENETUNREACH, EHOSTUNREACH, ENETDOWN, EINVAL, EPERM, ENOBUFS,
                               ENODEV,      ENOSPC,       EDQUOT,   EFBIG,  EIO};
  return std::find(kLosing.begin(), kLosing.end(), error) != kLosing.end();
}

/// Empty if the bytes went out, else why not.
std::string Send(lcm::LCM& lcm, const std::string& channel, std::span<const std::uint8_t> bytes) {
  // LCM 1.3.1 answers 0 for a message of several datagrams even where sending them failed, and for a log on a full
  // disk; errno alone tells.
  errno = 0;
  const int status = lcm.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  const int error = errno;
  if (status == 0 && !LosesMessages(error)) return {};
  return error == 0 ? "LCM refused it" : std::strerror(error);
}

}  // namespace

std::string LcmPublisherOptions::Check() const {
  if (!IsValidPrefix(prefix))
    return "channel prefix '" + prefix + "' must be 1 to " + std::to_string(kMaxPrefixLength) +
           " of the characters A-Z a-z 0-9 _ -";
  try {
    ParseLcmUrl(url, LcmDirection::kPublish);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

struct LcmPublisher::Impl {
  LcmUrl url;
  std::string poses_channel;
  std::string camera_channel;
  std::string status_channel;
  std::string robots_channel;
  std::string tracks_channel;
  Clock clock;
  WireEncoder encoder;
  std::unique_ptr<lcm::LCM> lcm;
  PublisherHealth health;
  RepeatedCause trouble;
  BackOff back_off{kFirstRetry, kLongestRetry};
  MonotonicTime next_try{};
  std::uint64_t failed_before = 0;  ///< the present trouble
  bool in_trouble = false;          ///< as far as the log knows
  MonotonicTime steady_at{};        ///< when the trouble is over, if nothing fails before

  void Complain(PublisherState state, const std::string& message) {
    health.state = state;
    health.message = message;
    in_trouble = true;
    const std::string log = trouble.Occurred(message, {}, clock.monotonic());
    if (!log.empty()) spdlog::error("{}", log);
  }

  void Sent() {
    ++health.sent;
    if (health.state != PublisherState::kReady) {
      steady_at = clock.monotonic() + (health.state == PublisherState::kFailing ? kSteady : milliseconds{0});
      health.state = PublisherState::kReady;
      health.message.clear();
      back_off.Succeeded();
    }
    if (!in_trouble || clock.monotonic() < steady_at) return;
    in_trouble = false;
    trouble.Ended();
    spdlog::info("LCM at {} works again; {} messages were lost", url.text, health.failed - failed_before);
    failed_before = health.failed;
  }

  void Open() {
    std::string problem = ProbeLcmUrl(url);
    if (problem.empty()) {
      lcm = std::make_unique<lcm::LCM>(url.text);
      if (lcm->good()) return;
      lcm.reset();
      problem = "LCM at " + url.text + " cannot be opened; LCM's own message says why";
    }
    next_try = clock.monotonic() + back_off.Failed();
    Complain(PublisherState::kWaiting, problem);
  }

  void SendFailed(const std::string& why) {
    Complain(PublisherState::kFailing, "LCM at " + url.text + " did not take a message: " + why);
    // A lost multicast route needs no new LCM: the same one works when the route is back. A lost TCP server does, and
    // asking LCM itself would print lines at every message.
    if (url.provider != LcmProvider::kTcpQueue) return;
    lcm.reset();
    next_try = clock.monotonic() + back_off.Failed();
  }

  template <typename Message>
  bool Publish(const std::string& channel, const Message& message) {
    if (!lcm && clock.monotonic() >= next_try) Open();
    if (lcm) {
      const std::string why = Send(*lcm, channel, encoder.Encode(message));
      if (why.empty()) {
        Sent();
        return true;
      }
      SendFailed(why);
    }
    ++health.failed;
    return false;
  }
};

LcmPublisher::LcmPublisher(LcmPublisherOptions options, Clock clock) : impl_(std::make_unique<Impl>()) {
  if (const std::string wrong = options.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  impl_->url = ParseLcmUrl(options.url, LcmDirection::kPublish);
  impl_->poses_channel = PosesChannel(options.prefix);
  impl_->camera_channel = ChannelName(options.prefix, kCameraSuffix);
  impl_->status_channel = StatusChannel(options.prefix);
  impl_->robots_channel = ChannelName(options.prefix, kRobotsSuffix);
  impl_->tracks_channel = ChannelName(options.prefix, kTracksSuffix);
  impl_->clock = std::move(clock);
  impl_->Open();
}

LcmPublisher::~LcmPublisher() = default;

bool LcmPublisher::Publish(const PosesMessage& message) { return impl_->Publish(impl_->poses_channel, message); }

bool LcmPublisher::Publish(const StatusMessage& message) { return impl_->Publish(impl_->status_channel, message); }

bool LcmPublisher::Publish(const RobotsMessage& message) { return impl_->Publish(impl_->robots_channel, message); }

bool LcmPublisher::Publish(const TracksMessage& message) { return impl_->Publish(impl_->tracks_channel, message); }

bool LcmPublisher::PublishInCamera(const PosesMessage& message) {
  return impl_->Publish(impl_->camera_channel, message);
}

const PublisherHealth& LcmPublisher::health() const { return impl_->health; }

}  // namespace chequer
