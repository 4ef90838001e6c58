#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "core/clock.h"
#include "core/file.h"
#include "core/suggestion.h"
#include "tools/commands.h"
#include "tools/number_check.h"
#include "tools/record_limit.h"
#include "tools/source_options.h"
#include "tools/undistort.h"

namespace chequer {
namespace {

constexpr const char* kCalibrationFile = "camera.toml";

struct RecordRequest {
  SourceRequest source;
  std::string out;
  std::string undistorted;
  std::string files = "raw";
  std::uint64_t frames = 0;  ///< 0: no limit
  double seconds = 0;
  std::string bytes;
};

FrameFileKind KindNamed(const std::string& name) {
  if (name == "raw") return FrameFileKind::kRaw;
  if (name == "png") return FrameFileKind::kPng;
  if (name == "jpeg") return FrameFileKind::kJpeg;
  throw CLI::ValidationError("--files",
                             name + ": must be raw, png or jpeg" + DidYouMean(name, WordsOf("raw, png, jpeg")));
}

/// Whether someone wants it to end. The signals are blocked, so that what is being written is finished first.
class EndSignals {
 public:
  EndSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  }
  bool Came() const {
    const timespec now{};
    return sigtimedwait(&signals_, nullptr, &now) > 0;
  }

 private:
  sigset_t signals_{};
};

/// Writes a source's frames until a limit is reached.
class Recorder {
 public:
  Recorder(const RecordRequest& request, const RecordLimit& limit)
      : request_(request), chosen_(ChooseSource(request.source)), limit_(limit) {
    files_.kind = KindNamed(request.files);
    if (!request.undistorted.empty() && !chosen_.calibration)
      throw CLI::ValidationError("--undistorted",
                                 "needs a calibration: give --calibration, or one in the configuration");
    // The disk may be slower than the camera for a while.
    if (CameraOptions* camera = CameraOf(chosen_.capture)) camera->buffers = std::max(camera->buffers, 24);
    if (chosen_.calibration) camera_ = LoadCamera(*chosen_.calibration);
  }

  void Run() {
    const EndSignals end;
    const std::unique_ptr<FrameSource> source = OpenSource(chosen_, "record");
    std::fprintf(stderr, "recording from %s\n", source->Describe().c_str());
    std::string lost;
    while (!end.Came() && !IsEnough() && lost.empty()) {
      const CaptureResult result = source->Next(std::chrono::milliseconds(250));
      switch (result.status) {
        case CaptureStatus::kFrame: Write(result.frame, source->rate_hz()); break;
        case CaptureStatus::kCorrupt: ++corrupt_; break;
        case CaptureStatus::kTimeout: break;
        case CaptureStatus::kDisconnected: lost = "the camera was lost: " + result.message; break;
        case CaptureStatus::kEnd: limit_.frames = count_; break;
      }
      ShowProgress(false);
    }
    Finish();
    if (!lost.empty()) throw std::runtime_error(lost);
  }

 private:
  bool IsEnough() const {
    return (limit_.frames && count_ >= *limit_.frames) || (limit_.seconds && seconds() >= *limit_.seconds) ||
           (limit_.bytes && bytes_ >= *limit_.bytes);
  }
  double seconds() const { return std::chrono::duration<double>(last_ - first_).count(); }

  void Begin(const ImageView& image, double rate_hz) {
    if (camera_ && (camera_->width != image.width() || camera_->height != image.height()))
      throw std::runtime_error(chosen_.calibration->string() + ": is for " + std::to_string(camera_->width) + "x" +
                               std::to_string(camera_->height) + ", the frames are " + std::to_string(image.width()) +
                               "x" + std::to_string(image.height()));
    RecordingInfo info;
    info.camera = chosen_.camera;
    info.width = image.width();
    info.height = image.height();
    info.pixel_format = image.format();
    info.tone_curve = image.tone_curve();
    info.yuv_range = image.yuv_range();
    if (rate_hz > 0) info.fps = rate_hz;
    if (camera_) info.calibration = kCalibrationFile;
    writer_.emplace(request_.out, info, files_);
    if (camera_) WriteCamera(std::filesystem::path(request_.out) / kCalibrationFile, *camera_);
    if (request_.undistorted.empty()) return;
    undistorter_.emplace(*camera_);
    info.pixel_format = PixelFormat::kBgr8;
    info.yuv_range = YuvRange::kFull;
    FrameFileOptions straight_files;
    straight_files.kind = files_.kind;
    straight_writer_.emplace(request_.undistorted, info, straight_files);
    WriteCamera(std::filesystem::path(request_.undistorted) / kCalibrationFile, undistorter_->pinhole());
  }

  void Write(const Frame& frame, double rate_hz) {
    if (!writer_) Begin(frame.image, rate_hz);
    if (count_ > 0 && frame.captured_monotonic <= last_) {
      ++corrupt_;
      return;
    }
    // Some drivers do not count.
    const std::uint64_t sequence = count_ == 0 ? frame.sequence : std::max(frame.sequence, sequence_ + 1);
    if (count_ > 0) lost_ += sequence - sequence_ - 1;
    const std::vector<std::uint8_t> file = EncodeFrame(frame.image, files_);
    writer_->AddEncoded(file, frame.captured_utc, frame.captured_monotonic, sequence);
    if (straight_writer_)
      straight_writer_->Add(undistorter_->Undistort(frame.image).view(), frame.captured_utc, frame.captured_monotonic,
                            sequence);
    if (count_ == 0) first_ = frame.captured_monotonic;
    last_ = frame.captured_monotonic;
    sequence_ = sequence;
    bytes_ += file.size();
    ++count_;
  }

  std::string Progress() const {
    char text[200];
    std::snprintf(text, sizeof text, "%llu frames, %.1f s, %.1f MB, %llu lost, %llu unusable",
                  static_cast<unsigned long long>(count_), seconds(), static_cast<double>(bytes_) / 1e6,
                  static_cast<unsigned long long>(lost_), static_cast<unsigned long long>(corrupt_));
    return text;
  }

  /// Once a second; on a terminal always in the same line.
  void ShowProgress(bool last) {
    const MonotonicTime now = clock_.monotonic();
    if (!last && now < next_progress_) return;
    next_progress_ = now + std::chrono::seconds(1);
    const bool is_terminal = isatty(STDERR_FILENO) != 0;
    std::fprintf(stderr, is_terminal ? "\r\x1b[K%s%s" : "%s%s", Progress().c_str(), is_terminal && !last ? "" : "\n");
  }

  void Finish() {
    ShowProgress(true);
    if (!writer_) throw std::runtime_error("no frame came; nothing was written");
    writer_->Finish();
    if (straight_writer_) straight_writer_->Finish();
    std::printf("%s: %s\n", request_.out.c_str(), Progress().c_str());
  }

  const RecordRequest& request_;
  ChosenSource chosen_;
  RecordLimit limit_;
  FrameFileOptions files_;
  std::optional<CameraModel> camera_;
  std::optional<RecordingWriter> writer_;
  std::optional<Undistorter> undistorter_;
  std::optional<RecordingWriter> straight_writer_;
  Clock clock_ = Clock::System();
  MonotonicTime next_progress_{};
  MonotonicTime first_{};
  MonotonicTime last_{};
  std::uint64_t sequence_ = 0;
  std::uint64_t count_ = 0;
  std::uint64_t bytes_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t corrupt_ = 0;
};

}  // namespace

void AddRecordCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("record", "Writes the frames of a camera, or of any source, as a recording");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<RecordRequest>();
  command->add_option("--out", request->out, "Folder of the new recording")->type_name("DIR")->required();
  command->add_option("--frames", request->frames, "End after so many")->check(IsAboveZero)->check(IsWhole());
  command->add_option("--seconds", request->seconds, "End when they span so many")->check(IsAboveZero);
  command->add_option("--bytes", request->bytes, "End when their files have so many, such as 500M or 20G")
      ->type_name("N");
  command->add_option("--files", request->files, "raw, the fastest, png or jpeg")
      ->type_name("KIND")
      ->capture_default_str();
  command
      ->add_option("--undistorted", request->undistorted, "Folder of a second recording without the lens's distortion")
      ->type_name("DIR");
  AddSourceOptions(*command, request->source);
  command->footer(
      "Frames keep their pixel format, capture times and numbers. It ends with a limit, the source, or Ctrl-C; what "
      "is\n"
      "written until then is a whole recording. chequerd, chequer convert and all others read it.\n\n"
      "A minute of a webcam, and what the daemon sees until it is 2 GB:\n"
      "  chequer record --device /dev/video0 --size 1280x720 --seconds 60 --out swarm\n"
      "  chequer record --config /etc/chequer/chequerd.toml --bytes 2G --out swarm");
  command->callback(
      [request] { Recorder(*request, MakeRecordLimit(request->frames, request->seconds, request->bytes)).Run(); });
}

}  // namespace chequer
