#include "support/scripted_source.h"

#include <iterator>
#include <stdexcept>
#include <utility>

namespace chequer::test {
namespace {

using Kind = Step::Kind;

class CountedPixels final : public FrameLease {
 public:
  CountedPixels(Image image, std::shared_ptr<std::atomic<int>> count)
      : image_(std::move(image)), count_(std::move(count)) {
    ++*count_;
  }
  ~CountedPixels() override { --*count_; }
  ImageView view() const { return image_.view(); }

 private:
  Image image_;
  std::shared_ptr<std::atomic<int>> count_;
};

bool IsOpening(const Step& step) {
  return step.kind == Kind::kOpens || step.kind == Kind::kOpenFails || step.kind == Kind::kOpenThrows;
}

}  // namespace

Step Opens() { return {.kind = Kind::kOpens}; }
Step OpenFails(std::string message) { return {.kind = Kind::kOpenFails, .text = std::move(message)}; }
Step OpenThrows(std::string message) { return {.kind = Kind::kOpenThrows, .text = std::move(message)}; }
Step FrameNumber(std::uint64_t sequence, int width) {
  return {.kind = Kind::kFrame, .sequence = sequence, .width = width};
}
Step Gives(CaptureStatus status, std::string message) {
  return {.kind = Kind::kResult, .status = status, .text = std::move(message)};
}
Step WaitsForInterrupt() { return {.kind = Kind::kInterrupted}; }

std::vector<Step> Frames(std::uint64_t first, std::uint64_t last) {
  std::vector<Step> steps;
  for (std::uint64_t sequence = first; sequence <= last; ++sequence) steps.push_back(FrameNumber(sequence));
  return steps;
}

std::vector<Step> operator+(std::vector<Step> first, std::vector<Step> second) {
  first.insert(first.end(), std::make_move_iterator(second.begin()), std::make_move_iterator(second.end()));
  return first;
}

ScriptedSource::ScriptedSource(std::vector<Step> script)
    : script_(std::make_move_iterator(script.begin()), std::make_move_iterator(script.end())) {}

std::string ScriptedSource::Open() {
  ++opened_;
  if (script_.empty() || !IsOpening(script_.front())) return {};
  const Step step = std::move(script_.front());
  script_.pop_front();
  if (step.kind == Kind::kOpenThrows) throw std::runtime_error(step.text);
  return step.text;
}

CaptureResult ScriptedSource::Next(std::chrono::milliseconds /*timeout*/) {
  if (script_.empty()) return WaitForInterrupt();
  const Step step = std::move(script_.front());
  if (IsOpening(step)) return {CaptureStatus::kDisconnected, {}, "the script says that it is opened now"};
  script_.pop_front();
  switch (step.kind) {
    case Kind::kFrame: return MakeFrame(step);
    case Kind::kInterrupted: return WaitForInterrupt();
    default: return {step.status, {}, step.text};
  }
}

CaptureResult ScriptedSource::MakeFrame(const Step& step) {
  Image image(PixelFormat::kMono8, step.width, 2);
  for (std::size_t i = 0; i < 8 && i < image.bytes().size(); ++i)
    image.bytes()[i] = static_cast<std::uint8_t>(step.sequence >> (8 * i));
  auto pixels = std::make_unique<CountedPixels>(std::move(image), leases_);
  CaptureResult result;
  result.status = CaptureStatus::kFrame;
  result.frame.image = pixels->view();
  result.frame.lease = std::move(pixels);
  result.frame.sequence = step.sequence;
  const std::chrono::milliseconds time(step.sequence);
  result.frame.captured_monotonic = MonotonicTime(time);
  result.frame.captured_utc = UtcTime(std::chrono::seconds(1'700'000'000) + time);
  result.frame.instant = ExposureInstant::kMiddle;
  return result;
}

CaptureResult ScriptedSource::WaitForInterrupt() {
  std::unique_lock lock(mutex_);
  interrupt_.wait(lock, [this] { return interrupted_; });
  interrupted_ = false;
  return {CaptureStatus::kTimeout, {}, {}};
}

void ScriptedSource::Interrupt() {
  {
    const std::lock_guard lock(mutex_);
    interrupted_ = true;
  }
  interrupt_.notify_all();
}

std::uint64_t SequenceIn(const ImageView& image) {
  std::uint64_t sequence = 0;
  for (int i = 7; i >= 0; --i) sequence = sequence << 8 | image.row(i / image.width())[i % image.width()];
  return sequence;
}

}  // namespace chequer::test
