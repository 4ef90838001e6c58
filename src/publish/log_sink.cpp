#include "publish/log_sink.h"

#include <spdlog/spdlog.h>

#include <utility>

namespace chequer {

LogSink::LogSink(const LcmUrl& url, Clock clock)
    : writer_(url.path, url.arguments.at("mode") == "a" ? EarlierLog::kAppend : EarlierLog::kSetAside),
      clock_(std::move(clock)) {
  if (!writer_.set_aside().empty())
    spdlog::info("the log {} is begun anew; the earlier one is {} now", url.path, writer_.set_aside().string());
}

std::string LogSink::Send(const std::string& channel, std::span<const std::uint8_t> message) {
  return writer_.Write(clock_.utc(), channel, message);
}

}  // namespace chequer
