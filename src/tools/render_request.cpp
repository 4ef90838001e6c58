#include "tools/render_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string_view>
#include <system_error>
#include <utility>

#include "chequer/camera_file.h"
#include "core/length.h"
#include "core/suggestion.h"
#include "simulate/layouts.h"
#include "simulate/print_quality.h"
#include "tools/render_lab.h"

namespace chequer {
namespace {

/// Markers that lean more can hide behind their neighbours; SwarmOptions has the same limit in radians.
constexpr double kMostSwarmTiltDeg = 68;

double Radians(double degrees) { return degrees * M_PI / 180; }

[[noreturn]] void Refuse(const char* option, const std::string& message) {
  throw CLI::ValidationError(option, message);
}

/// "1920x1080" → width and height.
std::pair<int, int> ParseImageSize(const std::string& text) {
  const std::size_t times = text.find('x');
  int width = 0, height = 0;
  if (times != std::string::npos) {
    std::from_chars(text.data(), text.data() + times, width);
    std::from_chars(text.data() + times + 1, text.data() + text.size(), height);
  }
  if (text != std::to_string(width) + "x" + std::to_string(height) || width < 1 || height < 1 ||
      width > kMaxImageSide || height > kMaxImageSide)
    Refuse("--size", "'" + text + "' must be WIDTHxHEIGHT in pixels, such as 1920x1080, at most " +
                         std::to_string(kMaxImageSide) + " each");
  return {width, height};
}

double RenderFocalPx(const RenderRequest& request, int width) {
  if (request.focal_px && (request.lens_mm || request.pixel_pitch_um))
    Refuse("--focal", "says the same as --lens with --pixel-pitch; give one of them");
  if (request.lens_mm.has_value() != request.pixel_pitch_um.has_value())
    Refuse("--lens", "needs --pixel-pitch, and the other way round: 6 mm with pixels of 3.45 um");
  const double focal = request.focal_px  ? *request.focal_px
                       : request.lens_mm ? *request.lens_mm * 1000 / *request.pixel_pitch_um
                                         : 0.75 * width;
  if (!(focal > 0 && std::isfinite(focal))) Refuse(request.lens_mm ? "--lens" : "--focal", "must be above 0");
  return focal;
}

Background PlanBackground(const std::string& text, std::uint64_t seed) {
  Background background;
  background.seed = seed;
  if (const auto kind = ParseBackground(text); kind && *kind != BackgroundKind::kImage) {
    background.kind = *kind;
    return background;
  }
  if (!std::filesystem::exists(text))
    Refuse("--background", "'" + text + "' is neither a file nor one of " + BackgroundNames() +
                               DidYouMean(text, WordsOf(BackgroundNames())));
  background.kind = BackgroundKind::kImage;
  background.file = text;
  return background;
}

/// A board with its side.
struct SizedBoard {
  Board board;
  double side_m = 0;
};

/// `count` different boards, the families taking turns.
std::vector<SizedBoard> CheckerboardBoards(const RenderRequest& request, int count) {
  const std::vector<MarkerFamily> families = ChooseMarkerFamilies(request.markers, request.setup, true);
  std::vector<std::uint64_t> used(families.size(), 0);
  std::vector<SizedBoard> prints;
  for (int i = 0; i < count; ++i) {
    const std::size_t index = static_cast<std::size_t>(i) % families.size();
    const MarkerFamily& family = families[index];
    const std::uint64_t number = used[index]++;
    const bool enough = family.roster.empty() ? number <= family.code.max_id() : number < family.roster.size();
    if (!enough)
      Refuse(family.roster.empty() ? "--marker" : "--ids",
             "has only " + std::to_string(number) + " ids of " + ToString(family.code.size()) + " " +
                 std::string(VariantName(family.code.variant())) + "; --swarm " + std::to_string(request.swarm) +
                 " needs one a marker");
    const std::uint64_t id = family.roster.empty() ? number : family.roster[number];
    prints.push_back({MakeBoard(family.code, id), family.side_m});
  }
  return prints;
}

std::vector<SizedBoard> PeerBoards(const RenderRequest& request, int count) {
  if (request.peer != "tag36h11" && request.peer != "aruco4x4")
    Refuse("--peer", "'" + request.peer + "' must be tag36h11 or aruco4x4" +
                         DidYouMean(request.peer, WordsOf("tag36h11, aruco4x4")));
  if (!request.markers.side_m || !(*request.markers.side_m > 0))
    Refuse("--side", "is missing: --peer needs the side of the black square in metres, such as --side 0.12");
  std::vector<std::uint64_t> ids;
  if (!request.markers.ids.empty()) ids = ParseRoster(request.markers.ids);
  for (std::uint64_t id = 0; request.markers.ids.empty() && id < static_cast<std::uint64_t>(count); ++id)
    ids.push_back(id);
  if (ids.size() < static_cast<std::size_t>(count))
    Refuse("--ids",
           "names " + std::to_string(ids.size()) + " ids; --swarm " + std::to_string(count) + " needs one a marker");
  std::vector<SizedBoard> prints;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t id = ids[static_cast<std::size_t>(i)];
    prints.push_back({request.peer == "tag36h11" ? AprilTag36h11(id) : Aruco4x4(id), *request.markers.side_m});
  }
  return prints;
}

/// What --bend says, in place of the kind's.
void PlanBend(const RenderRequest& request, PrintQuality& quality) {
  constexpr const char* kForm = " must be 0 (flat), or a radius such as 1m, from 0.01 to 1000 m; -1m is hollow";
  if (!request.bend.empty()) {
    const auto radius_m = ParseLength(request.bend);
    if (!radius_m) Refuse("--bend", "'" + request.bend + "'" + kForm);
    quality.bend_radius_m = *radius_m;
    if (!quality.Check().empty()) Refuse("--bend", "'" + request.bend + "'" + kForm);
  }
  if (!request.bend_angle_deg) return;
  if (quality.bend_radius_m == 0) Refuse("--bend-angle", "needs paper that bends: --bend RADIUS, such as 1m");
  quality.bend_angle_rad = Radians(*request.bend_angle_deg);
}

PrintKind PlanPrint(const RenderRequest& request) {
  auto kind = NamedPrint(request.print);
  if (!kind) Refuse("--print", UnknownWord("known", request.print, WordsOf(PrintKindNames())));
  PrintQuality& quality = kind->quality;
  if (!request.print_scale.empty()) quality.scale = {request.print_scale[0], request.print_scale[1]};
  quality.register_m = request.register_m.value_or(quality.register_m);
  quality.fading = request.fading.value_or(quality.fading);
  quality.dirt = request.dirt.value_or(quality.dirt);
  quality.gloss = request.gloss.value_or(quality.gloss);
  if (const std::string wrong = quality.Check(); !wrong.empty()) throw CLI::ValidationError(wrong);
  PlanBend(request, quality);
  return *kind;
}

InkSet PlanInks(const RenderRequest& request) {
  const std::string name = request.ink.value_or(std::string(PlanPrint(request).ink));
  const auto inks = NamedInks(name);
  if (!inks) Refuse("--ink", UnknownWord("known", name, WordsOf(InkNames())));
  return *inks;
}

}  // namespace

MarkerPrint PlanMarkerPrint(const RenderRequest& request, double widest_m) {
  const PrintQuality quality = PlanPrint(request).quality;
  if (quality.bend_radius_m != 0 && std::abs(quality.bend_radius_m) < widest_m)
    Refuse("--bend",
           fmt::format("must be 0 (flat), or a radius of at least {:g} m, the longest side of what is printed "
                       "in one piece, not {:g} m",
                       widest_m, quality.bend_radius_m));
  return {PlanInks(request), request.ink_spread_cells, quality};
}

namespace {

Eigen::Vector3d ParsePosition(const std::vector<std::string>& typed) {
  Eigen::Vector3d position;
  for (int i = 0; i < 3; ++i) {
    const std::string& text = typed[static_cast<std::size_t>(i)];
    const auto metres = ParseLength(text);
    if (!metres) Refuse("--position", "'" + text + "' is not a length; write it as " + std::string(kLengthForms));
    position[i] = *metres;
  }
  return position;
}

/// One marker that stands still.
RenderJob PlanOne(const RenderRequest& request, RenderJob job, SizedBoard print) {
  SceneMarker marker;
  marker.board = std::move(print.board);
  marker.side_m = print.side_m;
  const MarkerPrint how = PlanMarkerPrint(request, print.side_m);
  marker.inks = how.inks;
  marker.margin_cells = request.margin_cells;
  marker.ink_spread_cells = how.ink_spread_cells;
  Print(how.quality, request.seed, marker);
  const Eigen::Vector3d position =
      request.position.empty() ? Eigen::Vector3d(0, 0, request.distance_m) : ParsePosition(request.position);
  marker.camera_from_marker =
      FacingPose(position, Radians(request.heading_deg), Radians(request.tilt_deg), Radians(request.tilt_axis_deg));
  if (!IsDrawable(marker, job.options.camera))
    Refuse("--position", "and --tilt must leave the whole marker before the camera, with its face towards it");
  job.markers_at = [marker](std::chrono::duration<double>) { return std::vector<SceneMarker>{marker}; };
  return job;
}

RenderJob PlanSwarm(const RenderRequest& request, RenderJob job, std::vector<SizedBoard> prints) {
  if (!request.position.empty()) Refuse("--position", "is for one marker; a swarm has --distance");
  SwarmOptions options;
  options.camera = job.options.camera;
  for (SizedBoard& print : prints) {
    options.boards.push_back(std::move(print.board));
    options.sides_m.push_back(print.side_m);
  }
  options.distance_m = request.distance_m;
  // Robots differ in height by little, and never by more than a tenth of the way to the camera.
  options.height_spread_m = std::min(0.1, 0.1 * request.distance_m);
  options.max_tilt_rad = request.tilt_deg > 0 ? Radians(request.tilt_deg) : options.max_tilt_rad;
  options.max_speed_m_s = request.max_speed_m_s;
  const MarkerPrint how = PlanMarkerPrint(request, *std::max_element(options.sides_m.begin(), options.sides_m.end()));
  options.inks = how.inks;
  options.margin_cells = request.margin_cells;
  options.ink_spread_cells = how.ink_spread_cells;
  options.print = how.quality;
  const auto swarm = std::make_shared<const Swarm>(options, request.seed);
  // Shared, as std::function copies what it holds.
  job.markers_at = [swarm](std::chrono::duration<double> time) { return swarm->At(time); };
  return job;
}

CameraPreset PlanPreset(const RenderRequest& request) {
  if (request.preset.empty()) return {};
  const auto preset = FindCameraPreset(request.preset);
  if (!preset) Refuse("--camera", UnknownWord("known", request.preset, WordsOf(CameraPresetNames())));
  return *preset;
}

/// JPEG's quality, where the frames are to be JPEG.
std::optional<int> PlanQuality(const RenderRequest& request) {
  if (request.jpeg_quality) return request.jpeg_quality;
  // A preset's JPEG goes with its own format.
  return request.pixel_format.empty() ? PlanPreset(request).jpeg_quality : std::nullopt;
}

/// What the camera's processor does, and the format that it gives.
void PlanProcessing(const RenderRequest& request, RenderOptions& options) {
  const CameraPreset preset = PlanPreset(request);
  ProcessingOptions& processing = options.processing = preset.processing;
  const auto take = [](const std::optional<double>& typed, double& value) { value = typed.value_or(value); };
  take(request.chromatic_aberration_px, processing.chromatic_aberration_px);
  take(request.denoising_levels, processing.denoising_levels);
  take(request.sharpening, processing.sharpening);
  take(request.saturation, processing.saturation);
  take(request.upscaling, processing.upscaling);
  if (!request.camera_curve.empty()) {
    const auto curve = ParseCameraCurve(request.camera_curve);
    if (!curve) Refuse("--camera-curve", "'" + request.camera_curve + "' must be one of " + kCameraCurveForms);
    processing.curve = *curve;
  }
  options.format = preset.format;
  if (request.pixel_format.empty()) return;
  const auto format = ParsePixelFormat(request.pixel_format);
  if (!format) Refuse("--pixel-format", UnknownWord("known", request.pixel_format, WordsOf(PixelFormatNames())));
  options.format = *format;
}

/// The options that RenderOptions has under other names or units.
RenderOptions PlanOptions(const RenderRequest& request) {
  RenderOptions options = request.camera;
  options.camera = PlanCamera(request);
  options.motion_angle_rad = Radians(request.motion_angle_deg);
  options.lighting.gradient_angle_rad = Radians(request.gradient_angle_deg);
  std::copy(request.white_balance.begin(), request.white_balance.end(), options.sensor.white_balance.begin());
  if (request.gamma) {
    if (!(*request.gamma >= 0.2 && *request.gamma <= 5)) Refuse("--gamma", "must be from 0.2 to 5 (1 is linear)");
    options.tone_curve = ToneCurve::Gamma(*request.gamma);
  }
  PlanProcessing(request, options);
  if (std::string wrong = options.Check(); !wrong.empty()) throw CLI::ValidationError(wrong);
  return options;
}

/// PNG where it can be: anything opens it.
FrameFileOptions PlanFiles(const RenderRequest& request, const RenderOptions& options) {
  FrameFileOptions files;
  if (const auto quality = PlanQuality(request)) {
    if (*quality < 1 || *quality > 100) Refuse("--jpeg", "must be a quality from 1 to 100");
    files.kind = FrameFileKind::kJpeg;
    files.jpeg.quality = *quality;
    const std::string wrong = CheckFrameFiles(files.kind, options.format, options.yuv_range);
    if (!wrong.empty())
      Refuse("--jpeg", "does not go with " + std::string(PixelFormatName(options.format)) + ": " + wrong);
  } else if (!CheckFrameFiles(files.kind, options.format, options.yuv_range).empty()) {
    files.kind = FrameFileKind::kRaw;
  }
  return files;
}

}  // namespace

CameraModel PlanCamera(const RenderRequest& request) {
  const bool names_camera = request.focal_px || request.lens_mm || request.pixel_pitch_um || request.size_typed;
  std::error_code unknown;
  if (request.camera_file.empty() && !names_camera && request.setup && request.setup->calibration &&
      std::filesystem::exists(*request.setup->calibration, unknown))
    return LoadCamera(*request.setup->calibration);
  if (!request.camera_file.empty()) {
    if (request.focal_px || request.lens_mm || request.pixel_pitch_um)
      Refuse("--camera-file", "already says the focal length; leave out --focal, --lens and --pixel-pitch");
    return LoadCamera(request.camera_file);
  }
  const auto [width, height] = ParseImageSize(request.size);
  const double focal = RenderFocalPx(request, width);
  return {
      .width = width, .height = height, .fx = focal, .fy = focal, .cx = 0.5 * (width - 1), .cy = 0.5 * (height - 1)};
}

RenderJob PlanRender(const RenderRequest& request) {
  if (request.frames < 1) Refuse("--frames", "must be at least 1");
  if (!(request.fps > 0 && request.fps <= 10000)) Refuse("--fps", "must be above 0, at most 10000");
  if (!(request.distance_m > 0)) Refuse("--distance", "must be above 0");
  if (request.swarm > 0 && !(request.tilt_deg >= 0 && request.tilt_deg <= kMostSwarmTiltDeg))
    Refuse("--tilt",
           fmt::format("{:g} must be a number from 0 to {:g} in a swarm", request.tilt_deg, kMostSwarmTiltDeg));
  if (request.sheet + !request.room.empty() + (request.swarm > 0) > 1)
    Refuse("--sheet", "and --room and --swarm are three scenes; choose one");
  if (request.swarm < 0) Refuse("--swarm", "must be at least 0");
  RenderJob job;
  job.options = PlanOptions(request);
  job.files = PlanFiles(request, job.options);
  job.background = PlanBackground(request.background, request.seed);
  job.frames = request.frames;
  job.fps = request.fps;
  job.seed = request.seed;
  if (request.sheet || !request.room.empty()) {
    job.markers_at =
        request.sheet ? PlanSheetViews(request, job.options.camera) : PlanRoom(request, job.options.camera);
    return job;
  }
  const int count = std::max(1, request.swarm);
  std::vector<SizedBoard> prints =
      request.peer.empty() ? CheckerboardBoards(request, count) : PeerBoards(request, count);
  job = request.swarm > 0 ? PlanSwarm(request, std::move(job), std::move(prints))
                          : PlanOne(request, std::move(job), std::move(prints[0]));
  if (std::string wrong = Scene{job.markers_at({}), job.background}.Check(); !wrong.empty())
    throw CLI::ValidationError(wrong);
  return job;
}

}  // namespace chequer
