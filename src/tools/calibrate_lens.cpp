#include "lens/calibrate_lens.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>

#include "chequer/camera_file.h"
#include "core/file.h"
#include "core/suggestion.h"
#include "lens/lens_picture.h"
#include "lens/lens_target.h"
#include "lens/tone_search.h"
#include "lens/view_collector.h"
#include "tools/calibrate.h"
#include "tools/commands.h"
#include "tools/frame_feed.h"
#include "tools/length_option.h"
#include "tools/lens_progress.h"
#include "tools/lens_watch.h"
#include "tools/marker_options.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

/// Corners move no more than that between two readings with what is known of the lens: it is known well enough.
constexpr double kSettledPx = 0.02;
/// A sheet that bends less, 1/m, is as flat as glued paper gets.
constexpr double kBendToTell = 0.1;
constexpr int kMostReadings = 4;
/// A tone curve is the same in all views, so some of them tell it.
constexpr std::size_t kViewsForTone = 8;

/// The options as typed.
struct LensRequest {
  FrameFeedOptions feed;
  std::optional<CameraSetup> setup;  ///< once it is read
  MarkerOptions markers;
  std::string chessboard;
  std::string square = "25mm";
  bool loose = false;
  std::string model = "brown_conrady";
  std::size_t views = 60;
  std::string out;
  bool force = false;
  std::string picture;
  bool keep_all = false;
};

CameraModel::Kind ParseModel(const std::string& name) {
  if (name == "brown_conrady") return CameraModel::Kind::kBrownConrady;
  if (name == "fisheye") return CameraModel::Kind::kFisheye;
  throw CLI::ValidationError("--model", "'" + name + "' is not known; it must be brown_conrady or fisheye" +
                                            DidYouMean(name, WordsOf("brown_conrady, fisheye")));
}

std::unique_ptr<LensTarget> MakeChessboard(const LensRequest& request) {
  Chessboard chessboard;
  const char *text = request.chessboard.data(), *end = text + request.chessboard.size();
  const auto cols = std::from_chars(text, end, chessboard.cols);
  const bool has_x = cols.ec == std::errc() && cols.ptr != end && *cols.ptr == 'x';
  const auto rows = has_x ? std::from_chars(cols.ptr + 1, end, chessboard.rows) : cols;
  if (!has_x || rows.ec != std::errc() || rows.ptr != end || std::min(chessboard.cols, chessboard.rows) < 3 ||
      std::max(chessboard.cols, chessboard.rows) > 100)
    throw CLI::ValidationError(
        "--chessboard",
        "'" + request.chessboard + "' must be COLUMNSxROWS of inner corners, such as 9x6, 3 to 100 each");
  chessboard.square_m = ParseLengthOption("--square", request.square);
  return MakeChessboardTarget(chessboard);
}

std::unique_ptr<LensTarget> MakeTarget(const LensRequest& request) {
  if (!request.chessboard.empty()) return MakeChessboard(request);
  const bool in_setup = request.setup && !request.setup->families.empty() && !request.markers.names_kind;
  if (!request.markers.side_m && !in_setup &&
      std::any_of(request.markers.markers.begin(), request.markers.markers.end(),
                  [](const std::string& text) { return text.find(':') == std::string::npos; }))
    throw CLI::ValidationError("--side", "is missing: the side of the markers, such as 60mm");
  return MakeMarkerTarget(ChooseMarkerFamilies(request.markers, request.setup, true), request.loose);
}

/// Tells the one who holds the target how it goes; over itself on a terminal, a line a view elsewhere.
class Feedback {
 public:
  explicit Feedback(bool live) : over_itself_(live && isatty(STDOUT_FILENO) != 0) {}

  void Tell(const ViewCollector& collector, const LensView& view, ViewVerdict verdict) {
    const std::string line = fmt::format(
        "{} view{}, {} tilted; coverage {:.0f} %; edges {}; {}", collector.views().size(),
        collector.views().size() == 1 ? "" : "s", collector.tilted(), 100 * collector.coverage().Share(),
        view.edge_px > 0 ? fmt::format("{:.1f} px", view.edge_px) : std::string("-"), collector.Hint(verdict));
    if (over_itself_) {
      if (lines_ > 0) fmt::print("\x1b[{}A", lines_);
      fmt::print("\x1b[J{}{}\n", collector.coverage().Picture(), line);
      lines_ = Coverage::kRows + 1;
    } else if (verdict == ViewVerdict::kTaken) {
      fmt::print("{}\n", line);
    }
    std::fflush(stdout);
  }

 private:
  bool over_itself_;
  int lines_ = 0;
};

/// Why no view was taken, as far as the frames show.
std::string NothingSeen(const LensRequest& request, std::size_t frames, int gave_up) {
  if (request.chessboard.empty())
    return fmt::format(
        "no marker of the sheet was seen in {} frames, and at least 4 are needed: are --marker, --variant "
        "and --ids right? `chequer explain` on one of them tells",
        frames);
  return fmt::format(
      "no chessboard of {} inner corners was seen whole in {} frames{}, and at least 4 are needed: count "
      "the corners where four squares meet, columns first",
      request.chessboard, frames,
      gave_up > 0 ? fmt::format(" ({} of them were too cluttered to search)", gave_up) : "");
}

/// Collects views until the frames end, or, of a camera, until there is enough.
/// @param stated gets the tone curve that the images state.
ViewCollector Collect(const LensRequest& request, LensTarget& target, FrameFeed& feed, LensProgress& shown,
                      ToneCurve& stated) {
  std::optional<ViewCollector> collector;
  int width = 0, height = 0;
  int gave_up = 0;
  Feedback feedback(feed.is_live());
  SearchProgress progress(feed.total());
  std::optional<MarkerWatch> markers;  // where a chessboard is sought
  if (!request.chessboard.empty()) markers.emplace(ChooseMarkerFamilies(request.markers, request.setup, false));
  while (const auto frame = feed.Next()) {
    if (!collector) {
      width = frame->image.width();
      height = frame->image.height();
      collector.emplace(ViewCollectorOptions{width, height, request.views, request.keep_all});
    }
    if (frame->image.width() != width || frame->image.height() != height)
      throw std::runtime_error(fmt::format("{} is {}x{}, those before are {}x{}; a calibration is for one size",
                                           frame->name, frame->image.width(), frame->image.height(), width, height));
    LensView view;
    if (!markers || !markers->Sees(frame->image, collector->views().size())) view = target.Read(frame->image);
    view.name = frame->name;
    gave_up += view.gave_up ? 1 : 0;
    const ViewVerdict verdict = collector->Offer(view, frame->reload);
    stated = frame->image.tone_curve();
    feedback.Tell(*collector, view, verdict);
    shown.Look(*collector, view.edge_px, collector->Hint(verdict));
    // A view that was taken has its own line.
    if (!feed.is_live() && verdict != ViewVerdict::kTaken)
      progress.Tell(collector->offered(), collector->views().size());
    if (collector->is_full() || (feed.is_live() && collector->Hint(verdict) == "enough")) break;
  }
  if (!collector) throw std::runtime_error("there are no frames");
  fmt::print("{} of {} frames taken\n{}", collector->views().size(), collector->offered(),
             collector->coverage().Picture());
  if (collector->views().empty()) throw std::runtime_error(NothingSeen(request, collector->offered(), gave_up));
  if (const std::string lacking = collector->Lacking(); lacking.empty())
    fmt::print("These views are enough.\n");
  else
    fmt::print("More views would make it more exact: {}.{}\n", lacking,
               collector->alike() == 0
                   ? ""
                   : fmt::format(" {} frames look like others; --keep-all takes them too.", collector->alike()));
  return std::move(*collector);
}

/// Reads the views again with what is known of the lens.
std::vector<LensView> ReadAgain(const ViewCollector& collector, LensTarget& target, const CameraModel& camera) {
  target.SetCamera(camera);
  std::vector<LensView> views;
  for (std::size_t i = 0; i < collector.views().size(); ++i) {
    const Image image = collector.reloads()[i]();
    LensView view = target.Read(image.view());
    view.name = collector.views()[i].name;
    views.push_back(std::move(view));
  }
  return views;
}

/// The farthest that a point of the plane z = 1 moves from one camera to another, over the image.
double Change(const CameraModel& from, const CameraModel& to) {
  double most = 0;
  for (int x = 0; x <= 8; ++x)
    for (int y = 0; y <= 8; ++y)
      if (const auto point = from.Undistort({from.width * x / 8.0, from.height * y / 8.0}))
        most = std::max(most, (to.Distort(*point) - from.Distort(*point)).norm());
  return most;
}

/// The curve with which boards fit better than with the stated one; nothing where that is as good, or for chessboards,
/// whose corners do not hang on it.
std::optional<ToneCurve> FindToneCurve(const ViewCollector& collector, LensTarget& target, const ToneCurve& stated,
                                       CameraModel camera) {
  if (!target.WantsCamera()) return std::nullopt;
  std::vector<Image> images;
  const std::size_t every = 1 + collector.views().size() / kViewsForTone;
  for (std::size_t i = 0; i < collector.views().size(); i += every) images.push_back(collector.reloads()[i]());
  return SearchToneCurve(stated, [&](const ToneCurve& curve) {
    camera.tone_curve = curve;
    target.SetCamera(camera);
    double sum = 0, seen_in = 0;
    for (const Image& image : images)
      if (const LensView view = target.Read(image.view()); !view.points.empty()) sum += view.flat_rms_px, ++seen_in;
    // No board is the worst of all.
    return seen_in > 0 ? sum / seen_in : 1e3;
  });
}

LensCalibration Calibrate(const LensRequest& request, const ViewCollector& collector, LensTarget& target,
                          const ToneCurve& stated) {
  const ViewCollectorOptions& images = collector.options();
  const LensCalibrationOptions options{images.width, images.height, ParseModel(request.model)};
  LensCalibration calibration = CalibrateLens(collector.views(), options);
  const std::optional<ToneCurve> curve = FindToneCurve(collector, target, stated, calibration.camera);
  calibration.camera.tone_curve = curve;
  for (int reading = 1; reading < kMostReadings && target.WantsCamera(); ++reading) {
    const CameraModel before = calibration.camera;
    calibration = CalibrateLens(ReadAgain(collector, target, before), options);
    calibration.camera.tone_curve = curve;
    if (Change(before, calibration.camera) < kSettledPx) break;
  }
  return calibration;
}

struct CollectedLens {
  ViewCollector collector;
  LensCalibration calibration;
  ToneCurve stated = ToneCurve::Srgb();
};

CollectedLens CollectAndCalibrate(const LensRequest& request, LensTarget& target, FrameFeed& feed,
                                  LensProgress& shown) {
  try {
    ToneCurve stated = ToneCurve::Srgb();
    ViewCollector collector = Collect(request, target, feed, shown, stated);
    shown.Solve(collector);
    LensCalibration calibration = Calibrate(request, collector, target, stated);
    calibration.record.date = NowInUtc();
    shown.Finish(collector, calibration);
    return {std::move(collector), std::move(calibration), stated};
  } catch (const std::runtime_error& error) {
    shown.Fail(error.what());
    throw;
  }
}

void PrintTone(const ToneCurve& curve, const ToneCurve& stated) {
  fmt::print(
      "The values follow another tone curve than the images state: {}, not {}. The camera file has it, and what "
      "reads that takes it.\n",
      curve.Name(), stated.Name());
}

void PrintResult(const LensCalibration& calibration, const Coverage& coverage) {
  const CameraModel& c = calibration.camera;
  const CalibrationRecord& r = calibration.record;
  for (const CalibratedView& view : calibration.views)
    if (!view.used) fmt::print("left out: {}: {}\n", view.name, view.why_not);
  if (calibration.loose_boards > 0)
    fmt::print("left out: {} of {} markers, which no view shows together with the others\n", calibration.loose_boards,
               calibration.boards);
  fmt::print("fx {:.3f} ± {:.3f}, fy {:.3f} ± {:.3f}, cx {:.3f} ± {:.3f}, cy {:.3f} ± {:.3f} px\n", c.fx,
             r.uncertainty[0], c.fy, r.uncertainty[1], c.cx, r.uncertainty[2], c.cy, r.uncertainty[3]);
  fmt::print("RMS {:.3f} px over {} points of {} views\n", r.rms_px, calibration.residuals.size(), r.views);
  if (calibration.print.matters())
    fmt::print(
        "The print is {:.2f} ± {:.2f} % {} than it should be for its width; the calibration allows for it. "
        "Measure a marker both ways and write side = [width, height], or --side WIDTHxHEIGHT.\n",
        100 * std::abs(calibration.print.stretch), 100 * calibration.print.deviation,
        calibration.print.stretch > 0 ? "taller" : "lower");
  if (const double bend = calibration.bend.LargestPerM(); bend > kBendToTell)
    fmt::print("The sheet bends, to a radius of about {:.1f} m; the calibration allows for it.\n", 1 / bend);
  if (coverage.Share() < 0.6)
    fmt::print("Only {:.0f} % of the image is covered: the distortion elsewhere is a guess. Hold the target there.\n",
               100 * coverage.Share());
}

/// What the camera file that is replaced says and no calibration measures, if it is of frames as large.
void KeepRowsRead(const std::filesystem::path& replaced, CameraModel& camera) {
  if (!std::filesystem::exists(replaced)) return;
  try {
    const CameraModel before = LoadCamera(replaced);
    if (before.width != camera.width || before.height != camera.height || before.rows_read_ms == 0) return;
    camera.rows_read_ms = before.rows_read_ms;
    fmt::print("kept from the file before: rows_read_ms = {}\n", before.rows_read_ms);
  } catch (const std::runtime_error&) {
    // What cannot be read says nothing, and is replaced.
  }
}

void RunLens(LensRequest& request) {
  ParseModel(request.model);
  if (request.views < 4 || request.views > 500) throw CLI::ValidationError("--views", "must be from 4 to 500");
  request.setup = LoadSetup(request.feed.config);
  const std::filesystem::path out =
      FileOf("--out", request.out, request.setup, request.setup ? request.setup->calibration : std::nullopt,
             "calibration in [camera]");
  const std::filesystem::path picture = request.picture.empty() ? std::filesystem::path(out).replace_extension(".png")
                                                                : std::filesystem::path(request.picture);
  if (picture == out)
    throw CLI::ValidationError("--picture", "and --out are both '" + out.string() + "'; camera files end in .toml");
  CheckOut(out, request.force);
  CheckFolderOf("--picture", picture);
  const std::unique_ptr<LensTarget> target = MakeTarget(request);
  FrameFeed feed(request.feed, request.setup, nullptr);
  LensProgress shown(request.setup, ParseModel(request.model));
  auto [collector, calibration, stated] = CollectAndCalibrate(request, *target, feed, shown);
  KeepRowsRead(out, calibration.camera);
  PrintResult(calibration, collector.coverage());
  if (calibration.camera.tone_curve) PrintTone(*calibration.camera.tone_curve, stated);
  WriteCalibration(out, FormatCamera(calibration.camera, &calibration.record));
  WriteFileAtomically(picture, DrawLensPicture(calibration));
  fmt::print("written: {}, {}\n", out.string(), picture.string());
  if (feed.failed() > 0) throw CLI::RuntimeError(kExitInput);
}

void AddLensOptions(CLI::App& command, LensRequest& request) {
  AddFrameFeedOptions(command, request.feed, "the markers and the file to write");
  AddMarkerOptions(command, request.markers);
  command.add_flag("--loose", request.loose, "The markers move one by one; without, they are fixed to one flat sheet");
  command
      .add_option("--chessboard", request.chessboard, "Instead of markers: a chessboard's inner corners, such as 9x6")
      ->type_name("COLSxROWS");
  command.add_option("--square", request.square, "Of the chessboard")->type_name("LENGTH")->capture_default_str();
  command.add_option("--model", request.model, "brown_conrady or fisheye")->capture_default_str();
  command.add_option("--views", request.views, "Most views that are used, 4 to 500")->capture_default_str();
  command.add_flag("--keep-all", request.keep_all, "Use also views that look like one before");
  command.add_option("--out", request.out, "Camera file to write [the configuration's]")->type_name("FILE");
  command.add_flag("--force", request.force, kForceHelp);
  command.add_option("--picture", request.picture, "Picture of coverage and residuals [--out with .png]")
      ->type_name("FILE");
}

}  // namespace

void AddCalibrateLensCommand(CLI::App& calibrate) {
  CLI::App* command = calibrate.add_subcommand("lens", "Calibrates a camera's lens from views of a flat target");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<LensRequest>();
  AddLensOptions(*command, *request);
  command->footer(
      "Show a sheet of markers (chequer print) glued to something flat to all parts of the image, tilted by 20 to 45\n"
      "degrees to all sides, near and far; sheets seen in part count. Blurred and doubtful views are left out.\n\n"
      "From the camera of a configuration, from a recording, from photographs of a chessboard:\n"
      "  chequer calibrate lens --config north\n"
      "  chequer calibrate lens --marker 6x6:secded:0.06 recording --out camera.toml\n"
      "  chequer calibrate lens --chessboard 9x6 --square 25mm photos/*.jpg --out camera.toml");
  command->callback([request] { RunLens(*request); });
}

}  // namespace chequer
