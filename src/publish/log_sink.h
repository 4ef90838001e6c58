#pragma once

#include "core/clock.h"
#include "publish/lcm_log_writer.h"
#include "publish/lcm_sink.h"

namespace chequer {

/// A log. LCM's own writer leaves half a message where a disk is full, and erases the log before.
class LogSink final : public LcmSink {
 public:
  /// Throws std::runtime_error naming the file and the cause. @param url of a file.
  LogSink(const LcmUrl& url, Clock clock);

  std::string Send(const std::string& channel, std::span<const std::uint8_t> message) override;
  // When there is room again, the same log goes on.
  bool Recovers() const override { return true; }

 private:
  LcmLogWriter writer_;
  Clock clock_;
};

}  // namespace chequer
