#pragma once

#include <cstdint>

namespace chequer {

enum class LogLevel : std::uint8_t { kDebug, kInfo, kWarning, kError };
enum class LogTarget : std::uint8_t {
  kAuto,     ///< the journal where systemd connected it to standard error, else the console
  kConsole,  ///< standard error
  kJournal,
};

struct LogOptions {
  LogLevel level = LogLevel::kInfo;
  LogTarget target = LogTarget::kAuto;
};

}  // namespace chequer
