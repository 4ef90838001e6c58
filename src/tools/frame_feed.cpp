#include "tools/frame_feed.h"

#include <fmt/format.h>

#include <chrono>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "capture/source_factory.h"
#include "core/suggestion.h"
#include "tools/number_check.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;

/// So long a camera may say nothing; most that start do within two seconds.
constexpr std::chrono::seconds kPatience{10};
/// How often an interruption is looked for.
constexpr std::chrono::milliseconds kGlance{200};

PlainImageOptions PlainOf(const FrameFeedOptions& options) {
  PlainImageOptions plain;
  const auto format = ParsePixelFormat(options.one_channel);
  if (!format || (*format != PixelFormat::kMono8 && !IsBayer(*format)))
    throw CLI::ValidationError("--one-channel", UnknownWord("what grey images hold", options.one_channel,
                                                            WordsOf("Mono8, BayerRG8, BayerGB8, BayerGR8, BayerBG8")));
  plain.one_channel = *format;
  if (options.gamma && !(*options.gamma >= 0.2 && *options.gamma <= 5))
    throw CLI::ValidationError("--gamma", fmt::format("{} is outside 0.2 to 5; 1 is linear", *options.gamma));
  if (options.gamma) plain.tone_curve = ToneCurve::Gamma(*options.gamma);
  return plain;
}

Recording OpenInputs(const FrameFeedOptions& options) {
  const PlainImageOptions plain = PlainOf(options);
  if (options.inputs.size() == 1) return OpenRecording(options.inputs.front(), plain);
  return RecordingOfImages({options.inputs.begin(), options.inputs.end()}, plain);
}

std::unique_ptr<FrameSource> OpenCamera(const CameraSetup& setup, const CameraModel* calibrated) {
  if (!setup.capture)
    throw std::runtime_error(setup.file.string() + ": a table [capture] must say where frames come from");
  CaptureOptions capture = *setup.capture;
  CameraOptions* camera = CameraOf(capture);
  if (camera != nullptr && !camera->width && calibrated != nullptr) {
    camera->width = calibrated->width;
    camera->height = calibrated->height;
  }
  auto source = MakeSource(capture);
  if (const std::string wrong = source->Open(); !wrong.empty()) throw std::runtime_error(wrong);
  return source;
}

}  // namespace

void AddFrameFeedOptions(CLI::App& command, FrameFeedOptions& options, const std::string& supplies) {
  command.add_option("INPUT", options.inputs,
                     "A recording, a folder of images, or images; without any, the configuration's camera");
  AddSetupOption(command, options.config, "the camera, " + supplies);
  const char* group = "Frames";
  command.add_option("--seconds", options.seconds, "Of a camera: end after so long; else Ctrl-C ends it")
      ->check(IsWithin(0.01, 86400))
      ->type_name("S")
      ->group(group);
  command
      .add_option("--one-channel", options.one_channel, "What grey images hold: Mono8, BayerRG8, BayerGB8, BayerGR8, …")
      ->type_name("FORMAT")
      ->capture_default_str()
      ->group(group);
  command.add_option("--gamma", options.gamma, "Curve of the values of images instead of sRGB; 1 is linear")
      ->type_name("G")
      ->group(group);
}

FrameFeed::FrameFeed(const FrameFeedOptions& options, const std::optional<CameraSetup>& setup,
                     const CameraModel* calibrated)
    : seconds_(options.seconds) {
  if (options.inputs.empty() && !setup)
    throw CLI::ValidationError("INPUT", "is missing: name a recording or images, or a camera by --config FILE");
  if (seconds_ && (!options.inputs.empty() || !(*seconds_ > 0)))
    throw CLI::ValidationError("--seconds", "is for a camera (--config), and must be above 0");
  if (options.inputs.empty())
    source_ = OpenCamera(*setup, calibrated);
  else
    recording_ = std::make_shared<Recording>(OpenInputs(options));
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  old_signals_ = std::make_unique<sigset_t>();
  pthread_sigmask(SIG_BLOCK, &signals, old_signals_.get());
}

FrameFeed::~FrameFeed() { pthread_sigmask(SIG_SETMASK, old_signals_.get(), nullptr); }

bool FrameFeed::IsInterrupted() const {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  const timespec at_once{};
  return sigtimedwait(&signals, nullptr, &at_once) > 0;
}

std::optional<FedFrame> FrameFeed::Next() {
  if (IsInterrupted()) return std::nullopt;
  return source_ ? NextLive() : NextRecorded();
}

std::optional<FedFrame> FrameFeed::NextRecorded() {
  while (next_ < recording_->frames.size()) {
    const std::size_t index = next_++;
    try {
      image_ = LoadFrame(*recording_, index);
    } catch (const std::runtime_error& error) {
      fmt::print(stderr, "chequer: {}\n", error.what());
      ++failed_;
      continue;
    }
    return FedFrame{image_.view(), recording_->frames[index].file,
                    [recording = recording_, index] { return LoadFrame(*recording, index); }};
  }
  return std::nullopt;
}

std::optional<FedFrame> FrameFeed::NextLive() {
  const auto now = std::chrono::steady_clock::now;
  if (!started_) started_ = now();
  for (auto last = now(); now() - last < kPatience;) {
    if (IsInterrupted()) return std::nullopt;
    if (seconds_ && now() - *started_ > std::chrono::duration<double>(*seconds_)) return std::nullopt;
    CaptureResult result = source_->Next(kGlance);
    switch (result.status) {
      case CaptureStatus::kFrame:
        frame_ = std::move(result.frame);
        return FedFrame{frame_.image, "frame " + std::to_string(frame_.sequence),
                        [copy = std::make_shared<Image>(CopyOf(frame_.image))] { return *copy; }};
      case CaptureStatus::kTimeout: break;
      case CaptureStatus::kCorrupt:
        fmt::print(stderr, "chequer: {}\n", result.message);
        ++failed_;
        break;
      case CaptureStatus::kDisconnected: throw std::runtime_error(result.message);
      case CaptureStatus::kEnd: return std::nullopt;
    }
  }
  throw std::runtime_error(fmt::format("no frame came for {} s from {}", kPatience.count(), source_->Describe()));
}

Image CopyOf(const ImageView& image) {
  Image copy(image.format(), image.width(), image.height(), image.tone_curve(), image.yuv_range());
  const auto shapes = PlaneShapes(image.format(), image.width(), image.height());
  std::uint8_t* out = copy.bytes().data();
  for (std::size_t plane = 0; plane < shapes.size(); ++plane)
    for (int row = 0; row < shapes[plane].rows; ++row) {
      const auto bytes = static_cast<std::size_t>(shapes[plane].row_bytes);
      std::memcpy(out, image.row(row, static_cast<int>(plane)), bytes);
      out += bytes;
    }
  return copy;
}

}  // namespace chequer
