#include "publish/lcm_publisher.h"

#include <spdlog/spdlog.h>

#include <optional>
#include <stdexcept>
#include <utility>

#include "core/back_off.h"
#include "core/repeated_cause.h"
#include "publish/channels.h"
#include "publish/lcm_sink.h"
#include "publish/lcm_url.h"
#include "publish/sender_watch.h"
#include "publish/wire.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;

// The first retries come quickly, because at boot a route appears within seconds; later ones cost nothing noticeable.
constexpr milliseconds kFirstRetry{250};
constexpr milliseconds kLongestRetry{5000};
/// On a full disk a log still takes small messages between larger ones: it works again when none has failed for so
/// long.
constexpr milliseconds kSteady{2000};

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
  std::unique_ptr<LcmSink> sink;  ///< while it is open
  PublisherHealth health;
  PublisherHealth shown;  ///< health, or that there is another sender where nothing else is wrong
  std::uint64_t instance = 0;
  std::optional<SenderWatch> watch;
  std::string other_sender;
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
    std::string problem;
    sink = OpenLcmSink(url, clock, problem);
    if (sink) return;
    next_try = clock.monotonic() + back_off.Failed();
    Complain(PublisherState::kWaiting, problem);
  }

  void SendFailed(const std::string& why) {
    Complain(PublisherState::kFailing, "LCM at " + url.text + " did not take a message: " + why);
    if (sink->Recovers()) return;
    sink.reset();
    next_try = clock.monotonic() + back_off.Failed();
  }

  void LookForOtherSenders() {
    if (url.provider != LcmProvider::kUdpMulticast && url.provider != LcmProvider::kTcpQueue) return;
    const std::string other = watch->Look(clock.monotonic());
    if (!other.empty() && other_sender.empty()) spdlog::error("{}", other);
    if (other.empty() && !other_sender.empty()) spdlog::info("nobody else publishes on {} any more", status_channel);
    other_sender = other;
  }

  bool PublishStatus(StatusMessage message) {
    LookForOtherSenders();
    message.detections.push_back({std::string(kInstanceName), instance});
    if (message.publisher.message.empty()) message.publisher.message = other_sender;
    return Publish(status_channel, message);
  }

  template <typename Message>
  bool Publish(const std::string& channel, const Message& message) {
    const bool sent = Send(channel, message);
    shown = health;
    if (shown.message.empty()) shown.message = other_sender;
    return sent;
  }

  template <typename Message>
  bool Send(const std::string& channel, const Message& message) {
    if (!sink && clock.monotonic() >= next_try) Open();
    if (sink) {
      const std::string why = sink->Send(channel, encoder.Encode(message));
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
  impl_->instance = options.instance;
  impl_->watch.emplace(impl_->url, options.prefix, options.instance);
  // A log is opened by its first message: where a changed configuration makes a new publisher, the one before still
  // writes, and a file has one writer.
  if (impl_->url.provider != LcmProvider::kFile) impl_->Open();
  impl_->shown = impl_->health;
}

LcmPublisher::~LcmPublisher() = default;

bool LcmPublisher::Publish(const PosesMessage& message) { return impl_->Publish(impl_->poses_channel, message); }

bool LcmPublisher::Publish(const StatusMessage& message) { return impl_->PublishStatus(message); }

bool LcmPublisher::Publish(const RobotsMessage& message) { return impl_->Publish(impl_->robots_channel, message); }

bool LcmPublisher::Publish(const TracksMessage& message) { return impl_->Publish(impl_->tracks_channel, message); }

bool LcmPublisher::PublishInCamera(const PosesMessage& message) {
  return impl_->Publish(impl_->camera_channel, message);
}

PublisherHealth LcmPublisher::health() const { return impl_->shown; }

}  // namespace chequer
