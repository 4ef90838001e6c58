#include "daemon/journal_sink.h"

// The records are of the whole program: that they pass through this file says nothing.
#define SD_JOURNAL_SUPPRESS_LOCATION

#include <pthread.h>
#include <sys/uio.h>
#include <syslog.h>
#include <systemd/sd-journal.h>

#include <array>

namespace chequer {
namespace {

std::string ThreadName() {
  std::array<char, 16> name{};  // the kernel's limit
  return pthread_getname_np(pthread_self(), name.data(), name.size()) == 0 ? name.data() : std::string();
}

}  // namespace

int JournalPriority(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::critical: return LOG_CRIT;
    case spdlog::level::err: return LOG_ERR;
    case spdlog::level::warn: return LOG_WARNING;
    case spdlog::level::info: return LOG_INFO;
    default: return LOG_DEBUG;
  }
}

std::vector<std::string> JournalRecord(spdlog::level::level_enum level, std::string_view message,
                                       std::string_view thread, std::span<const LogField> fields) {
  std::vector<std::string> record{std::string("MESSAGE=").append(message),
                                  "PRIORITY=" + std::to_string(JournalPriority(level)), "SYSLOG_IDENTIFIER=chequerd",
                                  std::string("CHEQUER_THREAD=").append(thread)};
  for (const LogField& field : fields) record.push_back(std::string(field.name).append("=").append(field.value));
  return record;
}

void JournalSink::Send(spdlog::level::level_enum level, std::string_view message, std::span<const LogField> fields) {
  std::vector<LogField> all(common_);
  all.insert(all.end(), fields.begin(), fields.end());
  std::vector<std::string> record = JournalRecord(level, message, ThreadName(), all);
  std::vector<iovec> parts;
  for (std::string& part : record) parts.push_back({part.data(), part.size()});
  sd_journal_sendv(parts.data(), static_cast<int>(parts.size()));
}

void JournalSink::sink_it_(const spdlog::details::log_msg& message) {
  Send(message.level, {message.payload.data(), message.payload.size()}, {});
}

}  // namespace chequer
