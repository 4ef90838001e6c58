#include "publish/lcm_subscriber.h"

#include <algorithm>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "publish/channels.h"
#include "publish/lcm_url.h"
#include "publish/log_player.h"
#include "publish/wire_view.h"

namespace chequer {
namespace {

/// Two seconds at 60 frames a second; LCM's default of 30 loses messages while a terminal is slow.
constexpr int kQueuedMessages = 120;
/// A viewer takes the channels of all cameras in one queue: a quarter of a second of ten at 60 frames a second.
constexpr int kQueuedForView = 600;

/// LCM reads channel names as regular expressions.
std::string Quoted(const std::string& name) {
  std::string quoted;
  for (const char c : name) {
    if (std::string_view("\\^$.|?*+()[]{}").find(c) != std::string_view::npos) quoted.push_back('\\');
    quoted.push_back(c);
  }
  return quoted;
}

std::string ChannelPattern(const ChannelFilter& filter) {
  if (!filter.channel.empty()) return Quoted(filter.channel);
  const std::string prefix = filter.prefix.empty() ? ".*" : Quoted(filter.prefix);
  std::string suffixes;
  const auto append = [&](std::string_view suffix) { suffixes.append(suffixes.empty() ? "" : "|").append(suffix); };
  for (const std::string_view suffix : kChannelSuffixes) append(suffix);
  if (filter.view)
    for (const std::string_view suffix : kViewSuffixes) append(suffix);
  return prefix + "(" + suffixes + ")";
}

/// What ChannelPattern says, without LCM.
bool Matches(const ChannelFilter& filter, std::string_view channel) {
  if (!filter.channel.empty()) return channel == filter.channel;
  const auto matches = [&](std::string_view suffix) {
    if (filter.prefix.empty()) return channel.ends_with(suffix);
    return channel == ChannelName(filter.prefix, suffix);
  };
  return std::any_of(kChannelSuffixes.begin(), kChannelSuffixes.end(), matches) ||
         (filter.view && std::any_of(kViewSuffixes.begin(), kViewSuffixes.end(), matches));
}

}  // namespace

std::string ChannelFilter::Check() const {
  if (!prefix.empty() && !channel.empty()) return "a prefix and a channel exclude each other; give one of them";
  if (channel.size() > kMaxChannelLength)
    return "channel '" + channel + "' is longer than the " + std::to_string(kMaxChannelLength) + " bytes LCM carries";
  if (!prefix.empty() && !IsValidPrefix(prefix))
    return "channel prefix '" + prefix + "' must be 1 to " + std::to_string(kMaxPrefixLength) +
           " of the characters A-Z a-z 0-9 _ -";
  return {};
}

std::string DefaultListenUrl() {
  const char* from_environment = std::getenv("LCM_DEFAULT_URL");
  if (from_environment != nullptr && *from_environment != '\0') return from_environment;
  return ListenUrlFor(std::string(kDefaultLcmUrl));
}

std::string ListenUrlFor(const std::string& published) {
  if (!published.starts_with("udpm://") || published.find("recv_buf_size") != std::string::npos) return published;
  // The kernel grants what net.core.rmem_max allows and says nothing where that is less.
  return published + (published.find('?') == std::string::npos ? '?' : '&') + "recv_buf_size=4194304";
}

struct LcmSubscriber::Impl {
  ChannelFilter filter;
  BytesHandler handler;
  std::unique_ptr<lcm::LCM> lcm;
  std::optional<LogPlayer> log;  ///< instead of LCM, whose own reader of logs trusts them
  bool damage_counted = false;
  std::uint64_t unreadable = 0;

  void Open(const std::string& url);

  void OnBytes(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    handler(channel, {static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
  }

  Outcome WaitForLog(std::chrono::milliseconds timeout) {
    while (const auto event = log->Next(timeout)) {
      if (!Matches(filter, event->channel)) continue;
      handler(event->channel, event->data);
      return Outcome::kMessage;
    }
    if (!log->is_over()) return Outcome::kTimeout;
    if (log->damaged() && !std::exchange(damage_counted, true)) ++unreadable;
    return Outcome::kClosed;
  }
};

void LcmSubscriber::Impl::Open(const std::string& url) {
  if (const std::string wrong = filter.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  const LcmUrl parsed = ParseLcmUrl(url, LcmDirection::kSubscribe);
  if (parsed.provider == LcmProvider::kFile) {
    log.emplace(parsed);
    return;
  }
  if (const std::string problem = ProbeLcmUrl(parsed); !problem.empty()) throw std::runtime_error(problem);
  lcm = std::make_unique<lcm::LCM>(url);
  if (!lcm->good()) throw std::runtime_error("LCM at " + url + " cannot be opened; its own message says why");
  lcm::Subscription* subscription = lcm->subscribe(ChannelPattern(filter), &Impl::OnBytes, this);
  subscription->setQueueCapacity(filter.view ? kQueuedForView : kQueuedMessages);
}

LcmSubscriber::LcmSubscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LcmSubscriber::LcmSubscriber(const std::string& url, const ChannelFilter& filter, Handler handler)
    : impl_(std::make_unique<Impl>()) {
  impl_->filter = filter;
  impl_->handler = [impl = impl_.get(), handler = std::move(handler)](const std::string& channel,
                                                                      std::span<const std::uint8_t> bytes) {
    if (auto message = DecodeMessage(bytes))
      handler(channel, std::move(*message));
    else if (!IsViewMessage(bytes))  // a camera_t comes on a channel that also carries poses
      ++impl->unreadable;
  };
  impl_->Open(url);
}

LcmSubscriber LcmSubscriber::OfBytes(const std::string& url, const ChannelFilter& filter, BytesHandler handler) {
  auto impl = std::make_unique<Impl>();
  impl->filter = filter;
  impl->handler = std::move(handler);
  impl->Open(url);
  return LcmSubscriber(std::move(impl));
}

LcmSubscriber::LcmSubscriber(LcmSubscriber&&) noexcept = default;
LcmSubscriber& LcmSubscriber::operator=(LcmSubscriber&&) noexcept = default;
LcmSubscriber::~LcmSubscriber() = default;

LcmSubscriber::Outcome LcmSubscriber::Wait(std::chrono::milliseconds timeout) {
  if (impl_->log) return impl_->WaitForLog(timeout);
  const int handled = impl_->lcm->handleTimeout(static_cast<int>(timeout.count()));
  if (handled < 0) return Outcome::kClosed;
  return handled == 0 ? Outcome::kTimeout : Outcome::kMessage;
}

int LcmSubscriber::fd() const { return impl_->lcm ? impl_->lcm->getFileno() : -1; }

std::uint64_t LcmSubscriber::unreadable() const { return impl_->unreadable; }

}  // namespace chequer
