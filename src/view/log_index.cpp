#include "view/log_index.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace chequer {
namespace {

constexpr std::chrono::milliseconds kGrid{250};

}  // namespace

LogIndex::LogIndex(const std::filesystem::path& path) : path_(path) {
  LogEventReader reader(path);
  std::int64_t place = reader.place();
  while (const auto event = reader.Next()) {
    if (entries_.empty() || event->logged >= entries_.back().time + kGrid) entries_.push_back({event->logged, place});
    if (entries_.size() == 1) first_ = last_ = entries_.front().time;
    last_ = std::max(last_, event->logged);
    place = reader.place();
  }
  if (entries_.empty())
    throw std::runtime_error(path.string() + ": holds no message of LCM; is it a log of lcm-logger?");
}

std::int64_t LogIndex::PlaceBefore(UtcTime time) const {
  const auto after = std::upper_bound(entries_.begin(), entries_.end(), time,
                                      [](UtcTime wanted, const Entry& entry) { return wanted < entry.time; });
  return after == entries_.begin() ? entries_.front().place : std::prev(after)->place;
}

}  // namespace chequer
