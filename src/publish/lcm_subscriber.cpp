#include "publish/lcm_subscriber.h"

#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <utility>

#include "publish/channels.h"
#include "publish/lcm_url.h"

namespace chequer {
namespace {

/// Two seconds at 60 frames a second; LCM's default of 30 loses messages while a terminal is slow.
constexpr int kQueuedMessages = 120;

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
  for (const std::string_view suffix : kChannelSuffixes) suffixes.append(suffixes.empty() ? "" : "|").append(suffix);
  return prefix + "(" + suffixes + ")";
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
  // The kernel grants what net.core.rmem_max allows and says nothing where that is less.
  return std::string(kDefaultLcmUrl) + "&recv_buf_size=4194304";
}

struct LcmSubscriber::Impl {
  Handler handler;
  std::unique_ptr<lcm::LCM> lcm;
  std::uint64_t unreadable = 0;

  void OnBytes(const lcm::ReceiveBuffer* buffer, const std::string& channel) {
    auto message = DecodeMessage({static_cast<const std::uint8_t*>(buffer->data), buffer->data_size});
    if (message)
      handler(channel, std::move(*message));
    else
      ++unreadable;
  }
};

LcmSubscriber::LcmSubscriber(const std::string& url, const ChannelFilter& filter, Handler handler)
    : impl_(std::make_unique<Impl>()) {
  if (const std::string wrong = filter.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  const LcmUrl parsed = ParseLcmUrl(url, LcmDirection::kSubscribe);
  if (const std::string problem = ProbeLcmUrl(parsed); !problem.empty()) throw std::runtime_error(problem);
  impl_->handler = std::move(handler);
  impl_->lcm = std::make_unique<lcm::LCM>(url);
  if (!impl_->lcm->good()) throw std::runtime_error("LCM at " + url + " cannot be opened; its own message says why");
  lcm::Subscription* subscription = impl_->lcm->subscribe(ChannelPattern(filter), &Impl::OnBytes, impl_.get());
  subscription->setQueueCapacity(kQueuedMessages);
}

LcmSubscriber::~LcmSubscriber() = default;

LcmSubscriber::Outcome LcmSubscriber::Wait(std::chrono::milliseconds timeout) {
  const int handled = impl_->lcm->handleTimeout(static_cast<int>(timeout.count()));
  if (handled < 0) return Outcome::kClosed;
  return handled == 0 ? Outcome::kTimeout : Outcome::kMessage;
}

std::uint64_t LcmSubscriber::unreadable() const { return impl_->unreadable; }

}  // namespace chequer
