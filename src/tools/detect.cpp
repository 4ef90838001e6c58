#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "capture/image_file.h"
#include "capture/recording.h"
#include "chequer/detector.h"
#include "core/convert.h"
#include "core/file.h"
#include "tools/calibrate.h"
#include "tools/commands.h"
#include "tools/detect_options.h"
#include "tools/detection_picture.h"
#include "tools/detection_report.h"
#include "tools/likely_kind.h"

namespace chequer {
namespace {

/// Between images that have no times.
constexpr std::chrono::milliseconds kPlainInterval{33};

/// The options as typed.
struct DetectRequest {
  std::vector<std::string> files;
  DetectOptions options;
  int repeat = 1;
  std::uint64_t budget = 0;
  bool sequence = false, learn_levels = false;
  bool json = false;
  std::string picture;
};

DetectorOptions DetectorOptionsOf(const DetectRequest& request) {
  DetectorOptions options = MakeDetectorOptions(request.options);
  options.learn_levels = request.learn_levels;
  return options;
}

/// Goes through files and recordings and prints what the detector finds.
class DetectRun {
 public:
  explicit DetectRun(const DetectRequest& request)
      : request_(request),
        one_channel_(ParseOneChannel(request.options.pixel_format)),
        curve_(ParseGamma(request.options.gamma)),
        detector_(DetectorOptionsOf(request)),
        is_drawn_(request.picture.empty()),
        kind_is_named_(request.json || request.options.NamesKind()) {
    if (!request.picture.empty()) CheckPngName("--picture", request.picture);
    CheckRange("--repeat", request.repeat, 1, std::numeric_limits<int>::max());
    if (request.budget != 0 && request.budget < kLeastBudget)
      throw CLI::ValidationError("--budget",
                                 fmt::format("{} is below {}; 0 is no limit", request.budget, kLeastBudget));
    detector_.set_budget(request.budget);
  }

  /// False if an image could not be used; each has had its message then.
  bool Run() {
    for (const std::string& file : request_.files) {
      std::error_code not_there;
      captured_ += kPlainInterval;
      if (std::filesystem::is_directory(file, not_there))
        Guarded([&] { TakeFolder(file); });
      else
        Guarded([&] { Take(file, LoadImage(file, {one_channel_, JpegColour::kYuv, ToneCurve::Srgb()})); });
    }
    if (std::ferror(stdout) != 0) throw std::runtime_error("standard output could not be written to the end");
    return all_good_;
  }

 private:
  /// Turns what is wrong with one image into a message; the others are still to be processed.
  template <typename Action>
  void Guarded(Action action) {
    try {
      action();
    } catch (const std::runtime_error& error) {
      fmt::print(stderr, "chequer detect: {}\n", error.what());
      all_good_ = false;
    }
  }

  void TakeFolder(const std::string& folder) {
    const PlainImageOptions plain{.one_channel = one_channel_, .jpeg_colour = JpegColour::kYuv};
    const Recording recording = OpenRecording(folder, plain);
    memory_.Clear();
    for (std::size_t i = 0; i < recording.frames.size(); ++i) {
      captured_ = recording.frames[i].captured_monotonic.time_since_epoch();
      Guarded(
          [&] { Take((std::filesystem::path(folder) / recording.frames[i].file).string(), LoadFrame(recording, i)); });
    }
    memory_.Clear();
  }

  void Take(const std::string& name, const Image& image) {
    CheckCalibrationFits(detector_.options(), request_.options, name, image.view());
    if (!std::exchange(kind_is_named_, true)) NameLikelyKind(name, image.view());
    const double detect_ms = Detect(WithToneCurve(image.view(), curve_));
    if (!std::exchange(is_drawn_, true))
      WriteFileAtomically(request_.picture, DrawDetection(ToBgr(image.view()).view(), markers_));
    const ImageReport report{name, image.width(), image.height(), detect_ms, detector_.stats().work, markers_};
    const std::string text = request_.json ? JsonLine(report) + "\n" : Table(report);
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  }

  /// For whoever has a picture and does not know yet what is in it.
  void NameLikelyKind(const std::string& name, const ImageView& image) const {
    const Image picture = ToBgr(image);
    const auto likely = GuessKind(picture.view(), detector_.options());
    if (likely)
      fmt::print(stderr, "chequer detect: {} looks like markers of the kind {}; --marker {} seeks them\n", name,
                 likely->Text(), likely->Option());
    else
      fmt::print(stderr, "chequer detect: {} shows no marker of any kind; chequer explain says what was seen\n", name);
  }

  /// Leaves the markers in markers_; milliseconds of the fastest run.
  double Detect(const ImageView& image) {
    using Clock = std::chrono::steady_clock;
    auto fastest = Clock::duration::max();
    for (int i = 0; i < request_.repeat; ++i) {
      if (request_.sequence) after_ = memory_;
      const auto start = Clock::now();
      if (request_.sequence)
        detector_.Detect(image, captured_, after_, markers_);
      else
        detector_.Detect(image, markers_);
      fastest = std::min(fastest, Clock::now() - start);
    }
    std::swap(memory_, after_);
    return std::chrono::duration<double, std::milli>(fastest).count();
  }

  const DetectRequest& request_;
  PixelFormat one_channel_;
  std::optional<ToneCurve> curve_;
  Detector detector_;
  DetectorMemory memory_;  ///< of the frames before; empty without --sequence
  DetectorMemory after_;   ///< and of the last one too
  std::chrono::nanoseconds captured_{};
  std::vector<MarkerPose> markers_;
  bool is_drawn_;       ///< the first image, or none is to be
  bool kind_is_named_;  ///< by the options; or the likeliest was, of the first image
  bool all_good_ = true;
};

void AddOptions(CLI::App& command, DetectRequest& request) {
  command.add_option("FILE", request.files, "Images (PNG, JPEG, BMP, PGM, PPM), recordings, folders of images")
      ->required();
  AddDetectOptions(command, request.options);
  command.add_option("--threads", request.options.threads, "Threads for one image")
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--repeat", request.repeat, "Detect N times an image and report the fastest time")
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option("--budget", request.budget,
                  "Units of work an image may take, of about 1000 instructions; what it does not last for is left for "
                  "the next image. 0: no limit")
      ->type_name("N")
      ->capture_default_str();
  CLI::Option* sequence =
      command.add_flag("--sequence", request.sequence,
                       "The images are frames of a stream: each is begun with what those before it taught");
  command
      .add_flag("--learn-levels", request.learn_levels,
                "Poses rest on what those frames have shown of the levels of the markers' cells, too")
      ->needs(sequence);
  command.add_option("--picture", request.picture, "Also the first image with what was read drawn in, .png")
      ->type_name("FILE");
  command.add_flag("--json", request.json, "One JSON object a line and image instead of a table");
}

}  // namespace

void AddDetectCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("detect", "Finds the markers in images");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<DetectRequest>();
  AddOptions(*command, *request);
  command->footer(
      "Status 1 if an image could not be used; the others are processed all the same.\n\n"
      "What does this picture show? The likeliest kind is named on standard error:\n"
      "  chequer detect photo.png\n"
      "As the camera north would see it:\n"
      "  chequer detect --config north photo.png\n"
      "Markers of 12 cm, with their poses:\n"
      "  chequer detect --calibration camera.toml --marker 6x6 --variant secded --side 0.12 --json a.png b.png\n"
      "Two kinds at once, in raw frames of an industrial camera with linear values:\n"
      "  chequer detect --marker 6x6:secded:0.12 --marker 8x8:golay:0.2 --calibration camera.toml \\\n"
      "    --pixel-format BayerRG8 --gamma 1 frames/\n"
      "A recording as chequerd goes through it:\n"
      "  chequer detect --sequence --marker 6x6 --variant secded --json recording/");
  command->callback([request] {
    TakeSetup(request->options, "detect");
    if (!DetectRun(*request).Run()) throw CLI::RuntimeError(kExitInput);
  });
}

}  // namespace chequer
