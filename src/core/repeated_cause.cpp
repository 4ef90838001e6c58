#include "core/repeated_cause.h"

#include <algorithm>
#include <utility>

namespace chequer {
namespace {

// Often enough that somebody who looks into the log sees what is wrong now, seldom enough not to fill it.
constexpr std::chrono::seconds kFirstReminder{60};
constexpr std::chrono::seconds kLastReminder{3600};

std::string Text(std::string_view cause, std::string_view detail) {
  std::string text(cause);
  if (!detail.empty()) text.append(": ").append(detail);
  return text;
}

}  // namespace

std::string RepeatedCause::Occurred(std::string_view cause, std::string_view detail, MonotonicTime now) {
  ++occurrences_;
  if (occurrences_ == 1 || cause != cause_) {
    cause_ = cause;
    unlogged_ = 0;
    logged_at_ = now;
    reminder_ = kFirstReminder;
    return Text(cause, detail);
  }
  ++unlogged_;
  if (now - logged_at_ < reminder_) return {};
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(now - logged_at_).count();
  std::string text =
      Text(cause, detail) + " (" + std::to_string(unlogged_) + " times in the last " + std::to_string(seconds) + " s)";
  unlogged_ = 0;
  logged_at_ = now;
  reminder_ = std::min(2 * reminder_, kLastReminder);
  return text;
}

std::uint64_t RepeatedCause::Ended() {
  unlogged_ = 0;
  return std::exchange(occurrences_, 0);
}

}  // namespace chequer
