#include "publish/log_player.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>

namespace chequer {
namespace {

using std::chrono::steady_clock;

/// Times of a damaged or forged log may be anything; nobody waits longer than that between two messages.
constexpr std::chrono::hours kLongestGap{24};

std::string Argument(const LcmUrl& url, const char* name, const char* otherwise) {
  const auto found = url.arguments.find(name);
  return found == url.arguments.end() ? otherwise : found->second;
}

}  // namespace

LogPlayer::LogPlayer(const LcmUrl& url)
    : events_(url.path),
      speed_(std::atof(Argument(url, "speed", "1").c_str())),
      start_(std::chrono::microseconds(std::atoll(Argument(url, "start_timestamp", "0").c_str()))) {}

void LogPlayer::Fetch() {
  while (!next_ && !is_over_) {
    next_ = events_.Next();
    is_over_ = !next_;
    if (next_ && next_->logged < start_) next_.reset();
  }
}

std::optional<LogEvent> LogPlayer::Next(std::chrono::milliseconds timeout) {
  const steady_clock::time_point latest = steady_clock::now() + timeout;
  Fetch();
  if (!next_) return std::nullopt;
  if (speed_ > 0) {
    if (!first_logged_) {
      first_logged_ = next_->logged;
      began_ = steady_clock::now();
    }
    // In floating point: times of a damaged log may lie too far apart for integers.
    const double since_first_s = (static_cast<double>(next_->logged.time_since_epoch().count()) -
                                  static_cast<double>(first_logged_->time_since_epoch().count())) /
                                 1e6 / speed_;
    const double longest_s = std::chrono::duration<double>(steady_clock::now() - began_ + kLongestGap).count();
    const auto due = began_ + std::chrono::duration_cast<steady_clock::duration>(
                                  std::chrono::duration<double>(std::clamp(since_first_s, 0.0, longest_s)));
    std::this_thread::sleep_until(std::min(due, latest));
    if (due > latest) return std::nullopt;
  }
  return std::exchange(next_, std::nullopt);
}

}  // namespace chequer
