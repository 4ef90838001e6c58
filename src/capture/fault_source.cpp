#include "capture/fault_source.h"

#include <algorithm>
#include <random>
#include <utility>

#include "capture/owned_pixels.h"
#include "core/convert.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;

/// A copy whose middle third is noise; the same for the same seed.
Image WithNoise(const ImageView& view, std::uint64_t seed) {
  Image image = ConvertImage(view, view.format(), view.yuv_range());
  std::mt19937_64 random(seed);
  const std::span<std::uint8_t> bytes = image.bytes();
  for (std::uint8_t& byte : bytes.subspan(bytes.size() / 3, bytes.size() / 3))
    byte = static_cast<std::uint8_t>(random());
  return image;
}

std::string Named(const Frame& frame) {
  const std::string number = "frame " + std::to_string(frame.sequence);
  return frame.name.empty() ? number : number + " (" + frame.name + ")";
}

}  // namespace

FaultSource::FaultSource(std::unique_ptr<FrameSource> behind, std::vector<Fault> faults,
                         std::shared_ptr<WaitingClock> clock)
    : behind_(std::move(behind)), faults_(std::move(faults)), clock_(std::move(clock)) {
  std::stable_sort(faults_.begin(), faults_.end(), [](const Fault& a, const Fault& b) { return a.frame < b.frame; });
}

std::string FaultSource::Open() {
  if (is_gone_) {
    if (failed_opens_left_ > 0) {
      --failed_opens_left_;
      return "the camera is not there (scripted fault); attempts at opening it that will fail: " +
             std::to_string(failed_opens_left_);
    }
    if (const auto away = back_at_ - clock_->Now(); away.count() > 0)
      return "the camera is not there (scripted fault) for another " +
             std::to_string(std::chrono::ceil<milliseconds>(away).count()) + " ms";
  }
  is_gone_ = false;
  return behind_->Open();
}

void FaultSource::Interrupt() {
  behind_->Interrupt();
  clock_->Interrupt();
}

const Fault* FaultSource::NextFault() const {
  const bool is_due = next_fault_ < faults_.size() && faults_[next_fault_].frame <= frames_;
  return is_due ? &faults_[next_fault_] : nullptr;
}

bool FaultSource::WaitOut(const Fault& stall, MonotonicTime deadline) {
  if (!stalled_until_) stalled_until_ = clock_->Now() + stall.duration;
  if (!clock_->WaitUntil(std::min(*stalled_until_, deadline)) || deadline < *stalled_until_) return false;
  stalled_until_.reset();
  return true;
}

CaptureResult FaultSource::Vanish(const Fault& fault) {
  is_gone_ = true;
  failed_opens_left_ = fault.failed_opens;
  back_at_ = clock_->Now() + fault.duration;
  return {
      CaptureStatus::kDisconnected, {}, "the camera is gone (scripted fault at frame " + std::to_string(frames_) + ")"};
}

CaptureResult FaultSource::Spoil(const Fault& fault, CaptureResult result) const {
  if (result.status != CaptureStatus::kFrame) return result;
  Frame& frame = result.frame;
  if (fault.kind == FaultKind::kTruncate) {
    const std::size_t bytes = PackedSize(frame.image.format(), frame.image.width(), frame.image.height());
    return {CaptureStatus::kCorrupt,
            {},
            Named(frame) + ": only " + std::to_string(bytes / 2) + " of " + std::to_string(bytes) +
                " bytes came (scripted fault)"};
  }
  GiveOwnPixels(WithNoise(frame.image, fault.frame), frame);
  return result;
}

CaptureResult FaultSource::Next(milliseconds timeout) {
  if (is_gone_) return {CaptureStatus::kDisconnected, {}, "the camera is not open"};
  const MonotonicTime deadline = clock_->Now() + timeout;
  while (true) {
    const Fault* fault = NextFault();
    if (fault != nullptr && fault->kind == FaultKind::kStall) {
      if (!WaitOut(*fault, deadline)) return {CaptureStatus::kTimeout, {}, {}};
      ++next_fault_;
      continue;
    }
    if (fault != nullptr && fault->kind == FaultKind::kVanish) {
      ++next_fault_;
      return Vanish(*fault);
    }
    const auto left = std::chrono::ceil<milliseconds>(deadline - clock_->Now());
    CaptureResult result = behind_->Next(std::max(left, milliseconds(0)));
    if (result.status != CaptureStatus::kFrame && result.status != CaptureStatus::kCorrupt) return result;
    ++frames_;
    if (fault != nullptr) ++next_fault_;
    if (fault != nullptr && fault->kind == FaultKind::kDrop) drop_until_ = frames_ - 1 + fault->count;
    if (frames_ <= drop_until_) continue;
    return fault == nullptr ? std::move(result) : Spoil(*fault, std::move(result));
  }
}

std::string FaultSource::Describe() const {
  return behind_->Describe() + ", with " + std::to_string(faults_.size()) + " scripted faults";
}

}  // namespace chequer
