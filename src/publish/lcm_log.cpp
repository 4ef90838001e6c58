#include "publish/lcm_log.h"

#include <utility>

#include "publish/lcm_log_events.h"

namespace chequer {

struct LcmLogReader::Impl {
  LogEventReader events;
  std::uint64_t skipped = 0;
};

LcmLogReader::LcmLogReader(const std::filesystem::path& path) : impl_(new Impl{LogEventReader(path)}) {}

LcmLogReader::~LcmLogReader() = default;

std::optional<LogRecord> LcmLogReader::Next() {
  while (auto event = impl_->events.Next()) {
    auto message = DecodeMessage(event->data);
    if (message) return LogRecord{event->logged, std::move(event->channel), std::move(*message)};
    ++impl_->skipped;
  }
  return std::nullopt;
}

std::uint64_t LcmLogReader::skipped() const { return impl_->skipped; }

bool LcmLogReader::damaged() const { return impl_->events.damaged(); }

}  // namespace chequer
