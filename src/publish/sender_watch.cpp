#include "publish/sender_watch.h"

#include "publish/channels.h"
#include "publish/instance.h"

namespace chequer {
namespace {

using std::chrono::seconds;

/// As long a silence as makes `chequer status` take a daemon for gone.
constexpr seconds kForgetAfter{3};
/// One status may be the last of a daemon that was ended to make room for this one.
constexpr int kTimesToBelieve = 2;
/// Statuses that are looked at in one call, and senders that are remembered: whoever forges them gets no more.
constexpr int kMostHeardAtOnce = 64;
constexpr std::size_t kMostSigns = 16;

constexpr const char* kOnThisHost = "on this host";

/// What goes over the loopback comes from its address, or from none.
std::string Where(const std::string& address) {
  const bool is_here = address.starts_with("127.") || address == "0.0.0.0";
  return is_here ? kOnThisHost : "at " + address;
}

}  // namespace

SenderWatch::SenderWatch(const LcmUrl& url, const std::string& prefix, std::uint64_t instance)
    : prefix_(prefix),
      instance_(instance),
      claim_(url.address + ":" + std::to_string(url.port) + "/" + prefix, instance) {
  if (url.LeavesTheHost()) listener_.emplace(url, StatusChannel(prefix));
}

void SenderWatch::Note(const std::string& where, MonotonicTime now) {
  if (!signs_.contains(where) && signs_.size() >= kMostSigns) return;
  Sign& sign = signs_[where];
  ++sign.seen;
  sign.last = now;
}

std::string SenderWatch::Look(MonotonicTime now) {
  std::erase_if(signs_, [&](const auto& sign) { return now - sign.second.last > kForgetAfter; });
  for (int i = 0; listener_ && i < kMostHeardAtOnce; ++i) {
    const auto heard = listener_->Next();
    if (!heard) break;
    if (InstanceOf(heard->status) != instance_) Note(Where(heard->from), now);
  }
  if (claim_.SeesAnother()) Note(kOnThisHost, now);
  for (const auto& [where, sign] : signs_)
    if (sign.seen >= kTimesToBelieve)
      return "another program publishes as " + prefix_ + " too, " + where +
             ": its poses and these are mixed; give each camera a name of its own ([camera] name)";
  return {};
}

}  // namespace chequer
