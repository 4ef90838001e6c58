#include "capture/replay_source.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "capture/owned_pixels.h"
#include "core/number_text.h"

namespace chequer {
namespace {

using std::chrono::microseconds;

/// Keeps the preloaded frames.
struct SharedPixels final : FrameLease {
  explicit SharedPixels(std::shared_ptr<const void> pixels) : keep(std::move(pixels)) {}
  std::shared_ptr<const void> keep;
};

std::string Megabytes(std::size_t bytes) { return std::to_string((bytes >> 20) + 1) + " MB"; }

}  // namespace

std::string ReplayOptions::Check() const {
  if (path.empty() == images.empty()) return "either a path or a list of images must be given to replay";
  if (!(fps >= 0.001 && fps <= 10000)) return "replay fps = " + RoundText(fps) + ": must be from 0.001 to 10000";
  if (!(plain.fps >= 0.001 && plain.fps <= 10000))
    return "fps of images = " + RoundText(plain.fps) + ": must be from 0.001 to 10000";
  if (plain.one_channel != PixelFormat::kMono8 && !IsBayer(plain.one_channel))
    return "one-channel images can hold Mono8 or a Bayer format, not " +
           std::string(PixelFormatName(plain.one_channel));
  return {};
}

ReplaySource::ReplaySource(ReplayOptions options, std::shared_ptr<WaitingClock> clock)
    : options_(std::move(options)), clock_(std::move(clock)) {
  const std::string wrong = options_.Check();
  if (!wrong.empty()) throw std::runtime_error(wrong);
}

std::string ReplaySource::Open() {
  start_.reset();
  if (timeline_) return {};
  recording_ = options_.images.empty() ? OpenRecording(options_.path, options_.plain)
                                       : RecordingOfImages(options_.images, options_.plain);
  timeline_.emplace(recording_, options_.pace == ReplayPace::kFixedRate ? options_.fps : 0.0);
  if (WantsPreload() && !PreloadAll()) {
    timeline_.reset();
    return "opening the recording was interrupted";
  }
  return {};
}

std::size_t ReplaySource::DecodedBytes() const {
  const RecordingInfo& info = recording_.info;
  return recording_.frames.size() * PackedSize(info.pixel_format, info.width, info.height);
}

ReplaySource::Decoded ReplaySource::Decode(std::size_t index) const {
  try {
    return {LoadFrame(recording_, index), {}};
  } catch (const std::runtime_error& error) {
    return {{}, error.what()};
  }
}

bool ReplaySource::WantsPreload() const {
  if (options_.preload == Preload::kNo) return false;
  const bool fits = DecodedBytes() <= options_.preload_limit_bytes;
  if (options_.preload == Preload::kYes) {
    if (!fits)
      throw std::runtime_error("preloading the recording needs " + Megabytes(DecodedBytes()) + ", the limit is " +
                               Megabytes(options_.preload_limit_bytes) + ": raise it, or play without preloading");
    return true;
  }
  if (!fits || !IsPaced()) return fits && options_.loop;
  constexpr std::size_t kProbes = 3;
  const std::size_t probes = std::min(kProbes, recording_.frames.size());
  const MonotonicTime begin = clock_->Now();
  for (std::size_t i = 0; i < probes; ++i) Decode(i);
  const microseconds each = (clock_->Now() - begin) / static_cast<std::int64_t>(probes);
  // More than a third of the time for decoding leaves too little of it to the detector on a small machine.
  return 3 * each > timeline_->MeanPeriod();
}

bool ReplaySource::PreloadAll() {
  auto frames = std::make_shared<Decodeds>();
  frames->reserve(recording_.frames.size());
  for (std::size_t i = 0; i < recording_.frames.size(); ++i) {
    if (clock_->IsInterrupted()) return false;
    frames->push_back(Decode(i));
  }
  preloaded_ = std::move(frames);
  return true;
}

MonotonicTime ReplaySource::DueAt(std::uint64_t position) const { return *start_ + timeline_->DueAt(position); }

void ReplaySource::LoseWhatNoBufferHolds() {
  const MonotonicTime now = clock_->Now();
  while (!IsOver() && now >= DueAt(position_ + kBuffers)) {
    ++position_;
    ++frames_lost_;
    waiting_.reset();
  }
}

CaptureResult ReplaySource::Next(std::chrono::milliseconds timeout) {
  if (!timeline_) return {CaptureStatus::kDisconnected, {}, "the recording is not open"};
  const MonotonicTime deadline = clock_->Now() + timeout;
  if (IsPaced() && start_) LoseWhatNoBufferHolds();
  if (IsOver()) return {CaptureStatus::kEnd, {}, {}};
  if (!preloaded_ && !waiting_) waiting_ = Decode(timeline_->IndexAt(position_));
  if (!start_) start_ = clock_->Now() - timeline_->DueAt(position_);
  const MonotonicTime due = IsPaced() ? DueAt(position_) : clock_->Now();
  if (!clock_->WaitUntil(std::min(due, deadline)) || deadline < due) return {CaptureStatus::kTimeout, {}, {}};
  return Deliver(due);
}

CaptureResult ReplaySource::Deliver(MonotonicTime due) {
  const Decoded& decoded = preloaded_ ? (*preloaded_)[timeline_->IndexAt(position_)] : *waiting_;
  CaptureResult result;
  if (decoded.error.empty()) {
    result.status = CaptureStatus::kFrame;
    result.frame = MakeFrame(due);
  } else {
    result.status = CaptureStatus::kCorrupt;
    result.message = decoded.error;
  }
  waiting_.reset();
  ++position_;
  return result;
}

Frame ReplaySource::MakeFrame(MonotonicTime due) {
  const std::size_t index = timeline_->IndexAt(position_);
  Frame frame;
  if (preloaded_) {
    frame.image = (*preloaded_)[index].image.view();
    frame.lease = std::make_unique<SharedPixels>(preloaded_);
  } else {
    GiveOwnPixels(std::move(waiting_->image), frame);
  }
  if (options_.times == ReplayTimes::kPlayed) {
    frame.captured_monotonic = due;
    frame.captured_utc = clock_->NowUtc() - (clock_->Now() - due);
  } else {
    frame.captured_monotonic = timeline_->RecordedMonotonicAt(position_);
    frame.captured_utc = timeline_->RecordedUtcAt(position_);
  }
  frame.sequence = timeline_->SequenceAt(position_);
  frame.name = recording_.frames[index].file;
  return frame;
}

double ReplaySource::expected_rate_hz() const {
  switch (options_.pace) {
    case ReplayPace::kRecorded: return timeline_ ? recording_.info.fps : 0;
    case ReplayPace::kFixedRate: return options_.fps;
    case ReplayPace::kUnlimited: return 0;
  }
  return 0;
}

std::string ReplaySource::Describe() const {
  std::string text = options_.images.empty() ? "recording " + options_.path.string()
                                             : std::to_string(options_.images.size()) + " images";
  if (!timeline_) return text;
  const RecordingInfo& info = recording_.info;
  text += ", " + std::to_string(info.width) + "x" + std::to_string(info.height) + " " +
          std::string(PixelFormatName(info.pixel_format)) + ", ";
  switch (options_.pace) {
    case ReplayPace::kRecorded: text += RoundText(info.fps) + " fps"; break;
    case ReplayPace::kFixedRate: text += RoundText(options_.fps) + " fps"; break;
    case ReplayPace::kUnlimited: text += "as fast as it goes"; break;
  }
  if (options_.loop) text += ", in a loop";
  return text + (preloaded_ ? ", preloaded" : "");
}

}  // namespace chequer
