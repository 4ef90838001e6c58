#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "core/clock.h"
#include "daemon/log_event.h"
#include "publish/messages.h"

namespace chequer {

/// What the log says of a whole run, such as "60 frames published, 3 dropped: superseded 3".
std::string Summary(const StatusMessage& status);

/// The figures of a status as fields of a journal record: CHEQUER_FRAMES_PUBLISHED and others.
std::vector<LogField> ReportFields(const StatusMessage& status);

/// Logs how the daemon fares, with its figures as fields: once all is well for the first time, then every hour, so that
/// the journal tells the story of a month without filling up. One thread.
class Report {
 public:
  explicit Report(Clock clock) : clock_(std::move(clock)) {}

  void Take(const StatusMessage& status);

 private:
  Clock clock_;
  MonotonicTime next_{};
};

}  // namespace chequer
