#include "publish/calibration_channel.h"

#include <utility>

#include "publish/channels.h"
#include "publish/wire_view.h"

namespace chequer {
namespace {

/// More than all who look send between two frames.
constexpr int kAsksAtOnce = 16;

}  // namespace

CalibrationChannel::CalibrationChannel(const LcmUrl& url, std::string prefix, Clock clock)
    : url_(url), prefix_(std::move(prefix)), clock_(std::move(clock)), asks_(url, std::string(kCalibrationPrefix)) {}

bool CalibrationChannel::IsAsked() {
  const MonotonicTime now = clock_.monotonic();
  for (int i = 0; i < kAsksAtOnce; ++i) {
    const auto ask = asks_.Next();
    if (!ask) break;
    if (ask->wants_calibration) asked_until_ = now + kAskLasts;
  }
  return asked_until_ && now < *asked_until_;
}

bool CalibrationChannel::IsDue() { return IsAsked() && (!next_ || clock_.monotonic() >= *next_); }

void CalibrationChannel::Send(const CalibrationMessage& message) {
  next_ = clock_.monotonic() + kPeriod;
  std::string problem;
  if (!sink_) sink_ = OpenLcmSink(url_, clock_, problem);
  if (sink_) sink_->Send(ChannelName(prefix_, kSetupSuffix), EncodeView(message));
}

}  // namespace chequer
