#include "daemon/capture_loop.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/log_event.h"

namespace chequer {
namespace {

/// How long one wait for a frame lasts; a stop interrupts it.
constexpr std::chrono::milliseconds kFrameTimeout{250};
/// As often as the status is published.
constexpr std::chrono::seconds kHealthPeriod{1};

std::string Text(FrameSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

}  // namespace

CaptureLoop::CaptureLoop(CaptureLoopOptions options, FrameSource& source, std::function<bool(CapturedFrame)> pass,
                         Shared<CaptureReport>& report, SequenceCounter& sequence, CaptureActivity& activity,
                         Clock clock)
    : options_(std::move(options)),
      source_(source),
      pass_(std::move(pass)),
      report_(report),
      sequence_(sequence),
      activity_(activity),
      clock_(std::move(clock)),
      back_off_(options_.first_reopen, options_.longest_reopen) {}

void CaptureLoop::Run(std::stop_token stop) {
  last_frame_ = clock_.monotonic();
  while (!stop.stop_requested()) {
    Next next = Next::kReopen;
    if (is_open_ || Open(stop)) do {
        activity_.capturing.Begin(clock_.monotonic());
        next = Take(source_.Next(kFrameTimeout));
      } while (next == Next::kGoOn && !stop.stop_requested());
    activity_.capturing.End();
    if (next == Next::kFinish) return;
    if (next == Next::kReopen) {
      is_open_ = false;
      WaitToReopen(stop);
    }
  }
}

bool CaptureLoop::Open(const std::stop_token& stop) {
  activity_.opening.Begin(clock_.monotonic());
  const std::string problem = source_.Open();
  activity_.opening.End();
  is_open_ = problem.empty();
  if (stop.stop_requested()) return false;
  if (!problem.empty()) {
    Complain("the camera cannot be opened", problem);
    return false;
  }
  last_frame_ = clock_.monotonic();
  const std::string description = source_.Describe();
  report_.Update([&](CaptureReport& report) {
    report.state = CameraState::kRunning;
    report.source = description;
    report.message.clear();
  });
  TellRemarks();
  return true;
}

void CaptureLoop::TellRemarks() {
  std::vector<std::string> remarks = source_.Remarks();
  // A camera that comes and goes is not to fill the log with the same again.
  if (remarks != remarks_)
    for (const std::string& remark : remarks) spdlog::warn("{}", remark);
  remarks_ = std::move(remarks);
}

void CaptureLoop::TellHealth() {
  if (last_frame_ - health_told_ < kHealthPeriod) return;
  health_told_ = last_frame_;
  const std::string health = source_.Health();
  if (health.empty()) return;
  const std::string description = source_.Describe() + " (" + health + ")";
  report_.Update([&](CaptureReport& report) { report.source = description; });
}

CaptureLoop::Next CaptureLoop::Take(CaptureResult result) {
  switch (result.status) {
    case CaptureStatus::kFrame: return TakeFrame(std::move(result.frame));
    case CaptureStatus::kTimeout: NoFrame(); return Next::kGoOn;
    case CaptureStatus::kCorrupt: Unusable(result.message); return Next::kGoOn;
    case CaptureStatus::kDisconnected:
      if (had_frame_ && !away_since_) away_since_ = last_frame_;
      Complain("the camera was lost", result.message);
      return Next::kReopen;
    case CaptureStatus::kEnd:
      report_.Update([](CaptureReport& report) { report.state = CameraState::kEnded; });
      return Next::kFinish;
  }
  return Next::kReopen;
}

CaptureLoop::Next CaptureLoop::TakeFrame(Frame frame) {
  last_frame_ = clock_.monotonic();
  had_frame_ = true;
  last_was_unusable_ = false;
  CountMissed();
  Recover();
  TellHealth();
  const FrameSize size{frame.image.width(), frame.image.height()};
  if (options_.size && size != *options_.size) {
    sequence_.UnusableFrame();
    const std::string message = "the camera delivers " + Text(size) + ", its calibration is for " +
                                Text(*options_.size) + "; calibrate at that size, or set the camera to that size";
    report_.Update([&](CaptureReport& report) {
      ++report.wrong_size;
      report.message = message;
    });
    if (const std::string log = bad_frames_.Occurred(message, {}, clock_.monotonic()); !log.empty())
      spdlog::error("{}", log);
    return Next::kGoOn;
  }
  const SequenceCounter::Counted counted = sequence_.Frame(frame.sequence);
  frame.sequence = counted.sequence;
  CapturedFrame captured{std::move(frame), last_frame_, 0, source_.expected_rate_hz()};
  report_.Update([&](CaptureReport& report) {
    report.lost_before += counted.lost;
    report.message.clear();
    captured.dropped_before = report.unusable();
  });
  return pass_(std::move(captured)) ? Next::kGoOn : Next::kFinish;
}

void CaptureLoop::Unusable(const std::string& why) {
  last_frame_ = clock_.monotonic();  // the camera is not silent
  sequence_.UnusableFrame();
  const bool again = std::exchange(last_was_unusable_, true);
  report_.Update([&](CaptureReport& report) {
    ++report.corrupt;
    // Among usable frames, one alone is counted; where there is nothing else, it must be said.
    if (again || !had_frame_) report.message = "frames are unusable: " + why;
  });
  if (const std::string log = bad_frames_.Occurred("a frame is unusable", why, last_frame_); !log.empty())
    spdlog::warn("{}", log);
}

void CaptureLoop::CountMissed() {
  const auto since = std::exchange(away_since_, std::nullopt);
  const double rate_hz = source_.rate_hz();
  if (!since || rate_hz <= 0) return;
  const double periods = rate_hz * std::chrono::duration<double>(last_frame_ - *since).count();
  sequence_.Missed(static_cast<std::uint64_t>(std::max(1.0, std::round(periods) - 1)));
}

void CaptureLoop::NoFrame() {
  const auto silent = clock_.monotonic() - last_frame_;
  if (silent < options_.stall) return;
  const std::string message = "no frame comes from " + source_.Describe();
  report_.Update([&](CaptureReport& report) { report.message = message; });
  if (const std::string log = trouble_.Occurred(message, {}, clock_.monotonic()); !log.empty())
    LogEvent(LogLevel::kError, "camera_silent", log);
}

void CaptureLoop::Recover() {
  back_off_.Succeeded();
  if (trouble_.Ended() > 0) LogEvent(LogLevel::kInfo, "camera_back", "frames come from " + source_.Describe());
}

void CaptureLoop::Complain(std::string_view cause, std::string_view detail) {
  const std::string log = trouble_.Occurred(cause, detail, clock_.monotonic());
  report_.Update([&](CaptureReport& report) {
    report.state = CameraState::kWaiting;
    report.message = std::string(cause).append(": ").append(detail);
  });
  if (!log.empty()) LogEvent(LogLevel::kError, "camera_lost", log + "; trying again");
}

void CaptureLoop::WaitToReopen(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  wake_.wait_for(lock, stop, back_off_.Failed(), [] { return false; });
}

}  // namespace chequer
