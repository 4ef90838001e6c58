#include "daemon/logging.h"

#include <fcntl.h>
#include <poll.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "core/printable.h"
#include "core/unique_fd.h"
#include "daemon/journal_sink.h"
#include "daemon/log_event.h"

namespace chequer {
namespace {

spdlog::level::level_enum SpdlogLevel(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug: return spdlog::level::debug;
    case LogLevel::kInfo: return spdlog::level::info;
    case LogLevel::kWarning: return spdlog::level::warn;
    case LogLevel::kError: return spdlog::level::err;
  }
  return spdlog::level::info;
}

/// The message, without what a terminal obeys: it may quote what devices and files say.
class PrintableMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/, spdlog::memory_buf_t& out) override {
    const std::string text = PrintableLines({message.payload.data(), message.payload.size()});
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override { return std::make_unique<PrintableMessage>(); }
};

/// Writes to standard error, and leaves out what its reader does not take: a daemon must not hang on who reads its log.
/// When the reader goes on, a line says how many are missing.
class ConsoleSink : public spdlog::sinks::stderr_color_sink_mt {
  using Console = spdlog::sinks::stderr_color_sink_mt;

 public:
  void log(const spdlog::details::log_msg& message) override {
    if (pollfd console{STDERR_FILENO, POLLOUT, 0}; ::poll(&console, 1, 0) == 0) {
      ++lost_;
      return;
    }
    if (const std::uint64_t lost = lost_.exchange(0); lost > 0) {
      const std::string text = std::to_string(lost) + " lines of the log were lost: nobody read them in time";
      Console::log({message.logger_name, spdlog::level::warn, text});
    }
    Console::log(message);
  }

 private:
  std::atomic<std::uint64_t> lost_{0};
};

std::unique_ptr<spdlog::formatter> ConsoleFormatter() {
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintableMessage>('*').set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %*");
  return formatter;
}

}  // namespace

bool StandardErrorIsJournal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  // A child inherits the variable, but maybe not the stream: device and inode must be those of standard error.
  return stream != nullptr && fstat(STDERR_FILENO, &status) == 0 &&
         std::string(stream) == std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

void NeverWaitForStandardError() {
  struct stat status {};
  if (::fstat(STDERR_FILENO, &status) != 0 || S_ISREG(status.st_mode)) return;
  // An open file of its own: what others do with the one that they share with this process stays as it is. A socket has
  // no other, and a terminal of another user may not be opened; the log looks before it writes in any case.
  const UniqueFd own(::open("/proc/self/fd/2", O_WRONLY | O_APPEND | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (own.valid()) ::dup2(own.get(), STDERR_FILENO);
}

void SetUpLogging(const LogOptions& options, const std::string& camera, const std::string& version) {
  const bool journal =
      options.target == LogTarget::kJournal || (options.target == LogTarget::kAuto && StandardErrorIsJournal());
  std::shared_ptr<spdlog::logger> logger;
  if (journal) {
    logger = std::make_shared<spdlog::logger>(
        "chequerd",
        std::make_shared<JournalSink>(std::vector<LogField>{{"CHEQUER_CAMERA", camera}, {"CHEQUER_VERSION", version}}));
  } else {
    logger = std::make_shared<spdlog::logger>("chequerd", std::make_shared<ConsoleSink>());
    logger->set_formatter(ConsoleFormatter());
  }
  logger->set_level(SpdlogLevel(options.level));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

void LogEvent(LogLevel level, std::string_view event, const std::string& message, std::span<const LogField> fields) {
  spdlog::logger& logger = *spdlog::default_logger_raw();
  if (!logger.should_log(SpdlogLevel(level))) return;
  for (const spdlog::sink_ptr& sink : logger.sinks())
    if (auto* journal = dynamic_cast<JournalSink*>(sink.get()); journal != nullptr) {
      std::vector<LogField> all{{"CHEQUER_EVENT", std::string(event)}};
      all.insert(all.end(), fields.begin(), fields.end());
      journal->Send(SpdlogLevel(level), message, all);
      return;
    }
  logger.log(SpdlogLevel(level), "{}", message);
}

}  // namespace chequer
