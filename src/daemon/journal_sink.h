#pragma once

#include <spdlog/sinks/base_sink.h>

#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/log_event.h"

namespace chequer {

/// The syslog priority (PRIORITY=) of a level.
int JournalPriority(spdlog::level::level_enum level);

/// What goes into the journal, each as "NAME=value": the message, its priority, who says it, and the fields.
std::vector<std::string> JournalRecord(spdlog::level::level_enum level, std::string_view message,
                                       std::string_view thread, std::span<const LogField> fields);

/// Sends records to the journal with fields to search for: CHEQUER_THREAD, those of the constructor in each record,
/// those of an event in its own.
class JournalSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  /// @param common in each record.
  explicit JournalSink(std::vector<LogField> common) : common_(std::move(common)) {}

  void Send(spdlog::level::level_enum level, std::string_view message, std::span<const LogField> fields);

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

 private:
  const std::vector<LogField> common_;
};

}  // namespace chequer
