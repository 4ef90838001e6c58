#include "publish/lcm_log.h"

#include <lcm/eventlog.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace chequer {
namespace {

struct CloseLog {
  void operator()(lcm_eventlog_t* log) const { lcm_eventlog_destroy(log); }
};
struct FreeEvent {
  void operator()(lcm_eventlog_event_t* event) const { lcm_eventlog_free_event(event); }
};
using EventPtr = std::unique_ptr<lcm_eventlog_event_t, FreeEvent>;

}  // namespace

struct LcmLogReader::Impl {
  std::unique_ptr<lcm_eventlog_t, CloseLog> log;
  long size = 0;  ///< of the file, bytes
  std::uint64_t skipped = 0;
  bool damaged = false;

  /// The next event of any type. LCM gives none both at the end and where it finds no whole event any more; the place
  /// it began to look at tells them apart.
  EventPtr NextEvent() {
    const long before = std::ftell(log->f);
    EventPtr event(lcm_eventlog_read_next_event(log.get()));
    if (!event && before < size) damaged = true;
    return event;
  }
};

LcmLogReader::LcmLogReader(const std::filesystem::path& path) : impl_(std::make_unique<Impl>()) {
  if (std::filesystem::is_directory(path))
    throw std::runtime_error(path.string() + " is a folder; an LCM log is one file");
  impl_->log.reset(lcm_eventlog_create(path.c_str(), "r"));
  if (!impl_->log) throw std::runtime_error(path.string() + " cannot be read: " + std::strerror(errno));
  std::fseek(impl_->log->f, 0, SEEK_END);
  impl_->size = std::ftell(impl_->log->f);
  std::rewind(impl_->log->f);
}

LcmLogReader::~LcmLogReader() = default;

std::optional<LogRecord> LcmLogReader::Next() {
  while (const EventPtr event = impl_->NextEvent()) {
    auto message =
        DecodeMessage({static_cast<const std::uint8_t*>(event->data), static_cast<std::size_t>(event->datalen)});
    if (message)
      return LogRecord{UtcTime(std::chrono::microseconds(event->timestamp)), event->channel, std::move(*message)};
    ++impl_->skipped;
  }
  return std::nullopt;
}

std::uint64_t LcmLogReader::skipped() const { return impl_->skipped; }

bool LcmLogReader::damaged() const { return impl_->damaged; }

}  // namespace chequer
