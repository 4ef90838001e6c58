#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <system_error>

#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "robot/marker_survey.h"
#include "tools/calibrate.h"
#include "tools/columns.h"
#include "tools/commands.h"
#include "tools/frame_feed.h"
#include "tools/marker_options.h"
#include "tools/setup_option.h"
#include "world/side_check.h"
#include "world/world_file.h"

namespace chequer {
namespace {

/// A marker that leans more lies on no upright robot; said, for its roster entry will not do.
constexpr double kLeansRad = 0.05;

/// The options as typed.
struct RobotsRequest {
  FrameFeedOptions feed;
  std::optional<CameraSetup> setup;  ///< once it is read
  MarkerOptions markers;
  std::string calibration;
  std::string world;
  std::string roster;
  int frames = 100;
  std::string out;
  bool force = false;
};

using Heights = std::map<std::pair<int, std::uint64_t>, MarkerHeight>;

/// The heights of all markers in the frames but the world's references.
Heights Watch(const RobotsRequest& request, const DetectorOptions& options, const WorldCalibration& world) {
  FrameFeed feed(request.feed, request.setup, &*options.camera);
  Detector detector(options);
  MarkerSurvey survey(world.world_from_camera);
  int frames = 0;
  for (; frames < request.frames; ++frames) {
    const auto frame = feed.Next();
    if (!frame) break;
    if (frame->image.width() != options.camera->width || frame->image.height() != options.camera->height)
      throw std::runtime_error(fmt::format("{} is {}x{}, but the calibration {} is for {}x{}", frame->name,
                                           frame->image.width(), frame->image.height(), request.calibration,
                                           options.camera->width, options.camera->height));
    survey.Add(detector.Detect(frame->image));
  }
  if (frames == 0) throw std::runtime_error("there are no frames");
  Heights heights = survey.Heights();
  std::erase_if(heights, [&](const auto& entry) {
    const MarkerFamily& family = options.families[static_cast<std::size_t>(entry.first.first)];
    return std::any_of(world.references.begin(), world.references.end(), [&](const WorldReference& reference) {
      return reference.id == entry.first.second && reference.size == family.code.size() &&
             reference.variant == family.code.variant();
    });
  });
  if (heights.empty())
    throw std::runtime_error(fmt::format("no marker but the world's references is seen in {} frames", frames));
  return heights;
}

/// Whether the frames showed every marker of a robot.
bool IsSeen(const RosterRobot& robot, const Heights& heights) {
  return std::all_of(robot.markers.begin(), robot.markers.end(), [&](const RosterMarker& marker) {
    return heights.contains({marker.family, marker.id});
  });
}

void PrintResult(const RobotRoster& roster, const Heights& heights) {
  std::vector<std::vector<std::string>> rows{{"robot", "marker", "frames", "height mm", "± mm", "leans deg", ""}};
  for (const RosterRobot& robot : roster.robots)
    for (const RosterMarker& marker : robot.markers) {
      const auto seen = heights.find({marker.family, marker.id});
      if (seen == heights.end()) {
        rows.push_back({robot.name, std::to_string(marker.id), "-", "-", "-", "-", "not seen"});
        continue;
      }
      const MarkerHeight& height = seen->second;
      rows.push_back({robot.name, std::to_string(marker.id), std::to_string(height.frames),
                      fmt::format("{:.2f}", 1000 * height.height_m), fmt::format("{:.2f}", 1000 * height.spread_m),
                      fmt::format("{:.2f}", height.tilt_rad * 180 / std::numbers::pi),
                      height.tilt_rad > kLeansRad ? "leans: enter its orientation, or mount it flat" : ""});
    }
  fmt::print("{}", Columns(rows, "<>>>>><"));
}

bool IsSameFile(const std::string& one, const std::string& other) {
  std::error_code unknown;
  return !one.empty() && std::filesystem::equivalent(one, other, unknown);
}

/// The roster that somebody edited and that would be lost.
RobotRoster LoadEdited(const std::string& file, std::span<const MarkerFamily> families) {
  try {
    return LoadRobotRoster(file, families);
  } catch (const std::runtime_error& error) {
    throw CLI::ValidationError(
        "--out", "'" + file + "' was edited, and cannot be merged with: " + error.what() + "; --force replaces it");
  }
}

/// Takes the files that are not typed from the configuration.
void TakeSetup(RobotsRequest& request) {
  request.setup = LoadSetup(request.feed.config);
  const CameraSetup said = request.setup.value_or(CameraSetup());
  request.calibration =
      FileOf("--calibration", request.calibration, request.setup, said.calibration, "calibration in [camera]");
  request.world = FileOf("--world", request.world, request.setup, said.world, "file in [world]");
  request.out = FileOf("--out", request.out, request.setup, said.robots, "file in [robots]");
}

void RunRobots(RobotsRequest& request) {
  if (request.frames < 1 || request.frames > 100'000)
    throw CLI::ValidationError("--frames", fmt::format("{} is outside 1 to 100000", request.frames));
  TakeSetup(request);
  // An edited roster at the same place is merged with, unless it is to be replaced.
  const bool merges = request.roster.empty() && !request.force && IsEdited(request.out);
  if (!merges) CheckOut(request.out, request.force || IsSameFile(request.roster, request.out));
  DetectorOptions options;
  options.families = ChooseMarkerFamilies(request.markers, request.setup, true);
  if (request.setup) options.color_space = request.setup->color_space;
  options.camera = LoadCamera(request.calibration);
  const WorldCalibration world = LoadWorld(request.world);
  if (const std::string wrong = SideContradiction(world, options.families); !wrong.empty())
    throw std::runtime_error(request.world + ": " + wrong);
  RobotRoster roster;
  if (merges)
    roster = LoadEdited(request.out, options.families);
  else if (!request.roster.empty())
    roster = LoadRobotRoster(request.roster, options.families);
  SetPrints(roster, options.families);
  const Heights heights = Watch(request, options, world);
  if (merges) fmt::print("{} was edited: its robots keep their names and places, others are added\n", request.out);
  roster = WithHeights(std::move(roster), heights);
  if (request.roster.empty()) AddNewcomers(roster, heights);
  PrintResult(roster, heights);
  if (std::none_of(roster.robots.begin(), roster.robots.end(),
                   [&](const RosterRobot& robot) { return IsSeen(robot, heights); }))
    throw std::runtime_error("no robot of " + request.roster + " is seen");
  WriteCalibration(request.out, FormatRobotRoster(roster));
  fmt::print("written: {}\n", request.out);
}

}  // namespace

void AddCalibrateRobotsCommand(CLI::App& calibrate) {
  CLI::App* command = calibrate.add_subcommand("robots", "Measures how high the robots' markers are, as a roster");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<RobotsRequest>();
  AddFrameFeedOptions(*command, request->feed, "the markers, the camera file, the world file and the file to write");
  AddMarkerOptions(*command, request->markers);
  command->add_option("--calibration", request->calibration, "Camera file [the configuration's]")->type_name("FILE");
  command->add_option("--world", request->world, "World file [the configuration's]")->type_name("FILE");
  command
      ->add_option("--roster", request->roster,
                   "Roster whose heights are measured anew; without it, one robot for each marker that is seen")
      ->type_name("FILE");
  command->add_option("--frames", request->frames, "Most frames that are averaged")->capture_default_str();
  command->add_option("--out", request->out, "Roster to write; may be the one that was read [the configuration's]")
      ->type_name("FILE");
  command->add_flag("--force", request->force, kForceHelp);
  command->footer(
      "The robots stand or drive about on the floor meanwhile. Names, and where the marker sits on the body, are then\n"
      "edited into the file (chequer-robots.toml(5)); --roster measures its heights again and leaves the rest. "
      "Without\n"
      "it, an edited file of --out keeps its names and places too, and robots that are new are added.\n\n"
      "  chequer calibrate robots --config north\n"
      "  chequer calibrate robots --calibration camera.toml --world world.toml --side 12cm frames/ --out robots.toml");
  command->callback([request] { RunRobots(*request); });
}

}  // namespace chequer
