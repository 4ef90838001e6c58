#include "simulate/scenario.h"

#include <cmath>
#include <stdexcept>

#include "capture/size_text.h"
#include "chequer/camera_file.h"
#include "core/file.h"
#include "core/number_text.h"
#include "core/toml_reader.h"
#include "simulate/scenario_phases.h"

namespace chequer {
namespace {

constexpr std::size_t kMaxPhases = 1000;
constexpr IntegerRange kId{0, 9'007'199'254'740'991};  // what every JSON reader keeps exactly

/// "1280x720". The message is the table's, as all of a file's.
void ReadSize(TomlTable& table, CameraModel& camera) {
  std::string text = SizeText(camera.width, camera.height);
  table.Read("size", text);
  const std::size_t times = text.find('x');
  try {
    camera.width = std::stoi(text.substr(0, times));
    camera.height = times == std::string::npos ? 0 : std::stoi(text.substr(times + 1));
  } catch (const std::logic_error&) {
    camera.width = 0;
  }
  if (text != SizeText(camera.width, camera.height) || camera.width < 16 || camera.height < 16 ||
      camera.width > kMaxImageSide || camera.height > kMaxImageSide)
    table.Fail("size", "must be WIDTHxHEIGHT in pixels, such as \"1280x720\", from 16 to " +
                           std::to_string(kMaxImageSide) + " each");
}

/// A calibration, or size and focal length.
CameraModel ReadCameraModel(TomlTable& table, const std::filesystem::path& folder) {
  std::string file;
  if (table.Read("calibration", file)) {
    for (const char* key : {"size", "focal_px"})
      if (table.Has(key)) table.Fail(key, "must be left out where calibration is given, which says it");
    return LoadCamera(folder / file);
  }
  CameraModel camera{.width = 1280, .height = 720, .fx = 1800};
  ReadSize(table, camera);
  table.Read("focal_px", camera.fx, NumberRange{1, 1e6});
  camera.fy = camera.fx;
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

void ReadSensor(TomlTable& table, RenderOptions& render) {
  table.Read("blur_px", render.blur_sigma_px, NumberRange{0, 20});
  table.Read("vignetting", render.lighting.vignetting, NumberRange{0, 1});
  table.Read("haze", render.lighting.haze, NumberRange{0, 0.95});
  table.Read("brightness", render.sensor.exposure, NumberRange{0.001, 100});
  table.Read("full_well", render.sensor.full_well_electrons, NumberRange{1, 1e9});
  table.Read("read_noise", render.sensor.read_noise_electrons, NumberRange{0, 1e6});
  std::string name(PixelFormatName(render.format));
  table.Read("pixel_format", name);
  const auto format = ParsePixelFormat(name);
  if (!format) table.Fail("pixel_format", "must be one of " + PixelFormatNames());
  if (!SizeIsValid(*format, render.camera.width, render.camera.height))
    table.Fail("pixel_format", "needs an even width, NV12 also an even height");
  render.format = *format;
}

Background ReadBackground(TomlTable& table, const std::filesystem::path& folder, std::uint64_t seed) {
  Background background;
  background.seed = seed;
  std::string name(BackgroundName(background.kind));
  table.Read("background", name);
  if (const auto kind = ParseBackground(name); kind && *kind != BackgroundKind::kImage) {
    background.kind = *kind;
    return background;
  }
  background.kind = BackgroundKind::kImage;
  background.file = (folder / name).string();
  if (!std::filesystem::exists(background.file))
    table.Fail("background", "must be an image file or one of " + BackgroundNames());
  return background;
}

void ReadCamera(TomlTable table, const std::filesystem::path& folder, std::uint64_t seed, ScenarioCamera& camera) {
  camera.render.camera = ReadCameraModel(table, folder);
  ReadSensor(table, camera.render);
  camera.background = ReadBackground(table, folder, seed);
  table.Read("fps", camera.fps, NumberRange{0.1, 10000});
  table.Read("exposure_ms", camera.exposure_ms, NumberRange{0.001, 1000});
  const double frame_ms = 1000 / camera.fps;
  if (camera.exposure_ms > frame_ms) table.Fail("exposure_ms", "must be at most a frame's time, 1000 / fps");
  table.ReadLength("distance", camera.distance_m, NumberRange{0.01, 1000});
  table.Read("rows_read_ms", camera.render.camera.rows_read_ms, NumberRange{0, frame_ms});
  if (!table.Has("auto_exposure")) return;
  TomlTable automatic = table.Table("auto_exposure");
  AutoExposure exposure{.longest_ms = frame_ms};
  automatic.Read("lag_s", exposure.lag_s, NumberRange{0.001, 60});
  automatic.Read("longest_ms", exposure.longest_ms, NumberRange{camera.exposure_ms, frame_ms});
  automatic.Read("largest_gain", exposure.largest_gain, NumberRange{1, 1000});
  camera.auto_exposure = exposure;
}

void ReadBend(TomlTable& table, double side_m, PrintQuality& print) {
  const bool has_bend = table.ReadLength("bend", print.bend_radius_m, NumberRange{-1000, 1000});
  const double least_m = std::max(side_m, 0.01);
  if (print.bend_radius_m != 0 && std::abs(print.bend_radius_m) < least_m)
    table.Fail(has_bend ? "bend" : "print", "must be 0 (flat), or a radius of at least " + ExactText(least_m) +
                                                " m, the marker's side; negative where the paper is hollow");
  double angle_deg = 0;
  if (!table.Read("bend_angle_deg", angle_deg, NumberRange{-360, 360})) return;
  if (print.bend_radius_m == 0) table.Fail("bend_angle_deg", "needs paper that bends: bend = \"1m\", say");
  print.bend_angle_rad = angle_deg * M_PI / 180;
}

/// A kind of print, and what is different from it. Returns the name of its inks.
std::string ReadPrint(TomlTable& table, double side_m, PrintQuality& print) {
  std::string name = "ideal";
  table.Read("print", name);
  const auto kind = NamedPrint(name);
  if (!kind) table.Fail("print", "must be one of " + PrintKindNames());
  print = kind->quality;
  std::vector<double> scale{print.scale.x(), print.scale.y()};
  table.Read("print_scale", scale, LengthRange{2, 2}, NumberRange{0.9, 1.1});
  print.scale = {scale[0], scale[1]};
  table.ReadLength("register", print.register_m, NumberRange{0, 0.005});
  table.Read("fading", print.fading, NumberRange{0, 0.9});
  table.Read("dirt", print.dirt, NumberRange{0, 0.3});
  table.Read("gloss", print.gloss, NumberRange{0, 5});
  ReadBend(table, side_m, print);
  return std::string(kind->ink);
}

void ReadMarkers(TomlTable& table, ScenarioSwarm& swarm) {
  std::string size = ToString(swarm.size), variant(VariantName(swarm.variant)), ink;
  table.Read("size", size);
  const auto parsed = ParseMarkerSize(size);
  if (!parsed) table.Fail("size", "must be ROWSxCOLS such as \"6x6\", at least 3x3, with at most 64 cells inside");
  swarm.size = *parsed;
  table.Read("variant", variant);
  const auto known = ParseVariant(variant);
  if (!known || *known == Variant::kTable)
    table.Fail("variant",
               "must be one of unconstrained, saturation_constrained, color_constrained, secded, golay, "
               "nordstrom_robinson, reed_muller");
  swarm.variant = *known;
  table.ReadLength("side", swarm.side_m, NumberRange{0.001, 99});
  table.Read("first_id", swarm.first_id, kId);
  table.Read("margin_cells", swarm.margin_cells, NumberRange{0, 20});
  ink = ReadPrint(table, swarm.side_m, swarm.print);
  table.Read("ink", ink);
  const auto inks = NamedInks(ink);
  if (!inks) table.Fail("ink", "must be one of " + InkNames());
  swarm.inks = *inks;
  table.Read("ink_spread_cells", swarm.ink_spread_cells, NumberRange{0, 0.4});
  if (swarm.margin_cells > 0 && swarm.margin_cells < swarm.ink_spread_cells)
    table.Fail("margin_cells", "must be 0 or at least ink_spread_cells");
}

/// The largest id. A variant that does not exist at the size is the table's fault.
std::uint64_t LargestId(const TomlTable& table, const ScenarioSwarm& swarm) {
  try {
    return MarkerCode(swarm.size, swarm.variant).max_id();
  } catch (const std::runtime_error& error) {
    table.Fail("variant", error.what());
  }
}

void CheckIds(const TomlTable& table, const ScenarioSwarm& swarm) {
  const std::uint64_t largest = LargestId(table, swarm);
  const auto others = static_cast<std::uint64_t>(swarm.robots) - 1;
  if (largest < others || swarm.first_id > largest - others)
    table.Fail(table.Has("first_id") ? "first_id" : "robots",
               "must leave each robot an id up to " + std::to_string(largest) + ", the variant's largest");
}

void ReadSwarm(TomlTable table, double distance_m, ScenarioSwarm& swarm) {
  table.Read("robots", swarm.robots, IntegerRange{1, 10000});
  ReadMarkers(table, swarm);
  CheckIds(table, swarm);
  table.Read("speed", swarm.speed_m_s, NumberRange{0, 20});
  table.Read("acceleration", swarm.acceleration_m_s2, NumberRange{0.1, 100});
  table.ReadLength("gap", swarm.gap_m, NumberRange{0.01, 10});
  table.ReadLength("height_spread", swarm.height_spread_m, NumberRange{0, 0.5 * distance_m});
  double tilt_deg = swarm.max_tilt_rad * 180 / M_PI;
  table.Read("tilt_deg", tilt_deg, NumberRange{0, 60});
  swarm.max_tilt_rad = tilt_deg * M_PI / 180;
  std::vector<double> arena;
  if (table.ReadLengths("arena", arena, LengthRange{2, 2}, NumberRange{0.01, 1000}))
    swarm.arena_m = {arena[0], arena[1]};
}

Scenario FromFile(TomlFile file, const std::filesystem::path& folder) {
  Scenario scenario;
  TomlTable root = file.root();
  root.Read("seed", scenario.seed, kId);
  ReadCamera(root.Table("camera"), folder, scenario.seed, scenario.camera);
  ReadSwarm(root.Table("swarm"), scenario.camera.distance_m, scenario.swarm);
  if (!root.Has("phase")) root.FailMissing("phase");
  for (TomlTable& table : root.Tables("phase", kMaxPhases))
    scenario.phases.push_back(ReadPhase(table, scenario.camera.fps, scenario.swarm));
  NamePhases(scenario.phases);
  std::int64_t frames = 0;
  for (const Phase& phase : scenario.phases) frames += phase.frames;
  if (frames > kMaxStreamFrames)
    root.Fail("phase", "the phases must have at most " + std::to_string(kMaxStreamFrames) + " frames in all");
  if (scenario.FrameCount() == 0) root.Fail("phase", "the phases must have a frame");
  file.CheckAllKeysRead();
  return scenario;
}

}  // namespace

int Scenario::FrameCount() const {
  int count = 0;
  for (const Phase& phase : phases)
    if (phase.kind != PhaseKind::kGap && phase.kind != PhaseKind::kReopen) count += phase.frames;
  return count;
}

Scenario LoadScenario(const std::filesystem::path& path) { return FromFile(TomlFile::Load(path), path.parent_path()); }

Scenario ParseScenario(std::string_view text, const std::string& name, const std::filesystem::path& folder) {
  return FromFile(TomlFile::Parse(text, name), folder);
}

}  // namespace chequer
