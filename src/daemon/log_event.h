#pragma once

#include <span>
#include <string>
#include <string_view>

#include "daemon/log_options.h"

namespace chequer {

/// A field of a journal record, such as {"CHEQUER_FRAMES_DROPPED", "3"}; its name is of A-Z, 0-9 and _.
struct LogField {
  std::string_view name;
  std::string value;
};

/// Logs a record that programs look for: in the journal it carries CHEQUER_EVENT=`event` and the fields, elsewhere the
/// message alone. Any thread.
void LogEvent(LogLevel level, std::string_view event, const std::string& message,
              std::span<const LogField> fields = {});

}  // namespace chequer
