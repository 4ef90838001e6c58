#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "tools/calibrate.h"
#include "tools/commands.h"
#include "tools/frame_feed.h"
#include "tools/marker_options.h"
#include "tools/setup_option.h"
#include "tools/world_progress.h"
#include "world/estimate.h"
#include "world/world_file.h"

namespace chequer {
namespace {

/// The options as typed.
struct WorldRequest {
  FrameFeedOptions feed;
  std::optional<CameraSetup> setup;  ///< once it is read
  MarkerOptions markers;
  std::string calibration;
  std::string references;
  std::string l_of_three;
  std::string origin;
  int frames = 50;
  std::string out;
  bool force = false;
};

/// A list of references may stand among the inputs: frames never are TOML.
void TakeReferencesFromInputs(WorldRequest& request) {
  std::vector<std::string>& inputs = request.feed.inputs;
  const auto list = std::find_if(inputs.begin(), inputs.end(), [](const std::string& input) {
    std::error_code unknown;
    return input.ends_with(".toml") && !std::filesystem::is_directory(input, unknown);
  });
  if (list == inputs.end()) return;
  if (!request.references.empty())
    throw CLI::ValidationError("--references", request.references + " and " + *list + " are two lists; give one");
  request.references = *list;
  inputs.erase(list);
}

void CheckWays(const WorldRequest& request) {
  const int ways = !request.references.empty() + !request.l_of_three.empty() + !request.origin.empty();
  if (ways != 1)
    throw CLI::ValidationError("--references",
                               "or --l or --origin: give exactly one of them, to say where the world is");
  if (request.frames < 1 || request.frames > 10'000)
    throw CLI::ValidationError("--frames", fmt::format("{} is outside 1 to 10000", request.frames));
}

/// Of the families together, the one marker that has that id.
const StillMarker& Find(const std::vector<StillMarker>& seen, std::uint64_t id) {
  const auto is_it = [&](const StillMarker& marker) { return marker.id == id; };
  const auto found = std::find_if(seen.begin(), seen.end(), is_it);
  if (found == seen.end()) {
    std::vector<std::uint64_t> ids;
    for (const StillMarker& marker : seen) ids.push_back(marker.id);
    throw std::runtime_error(fmt::format("marker {} is not seen; seen are {}", id,
                                         ids.empty() ? std::string("none") : fmt::format("{}", fmt::join(ids, ", "))));
  }
  if (std::count_if(seen.begin(), seen.end(), is_it) > 1)
    throw std::runtime_error(fmt::format("there are markers {} of several kinds; name one kind by --marker", id));
  return *found;
}

std::vector<std::uint64_t> ParseIds(const char* option, const std::string& text, std::size_t count) {
  std::vector<std::uint64_t> ids;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    try {
      std::size_t used = 0;
      const std::string part = text.substr(start, end - start);
      if (part.empty() || part[0] < '0' || part[0] > '9') throw std::invalid_argument(part);
      ids.push_back(std::stoull(part, &used));
      if (used != part.size()) throw std::invalid_argument(part);
    } catch (const std::logic_error&) {
      ids.clear();
      break;
    }
    start = end + 1;
  }
  std::vector<std::uint64_t> different = ids;
  std::sort(different.begin(), different.end());
  if (ids.size() != count || std::adjacent_find(different.begin(), different.end()) != different.end())
    throw CLI::ValidationError(
        option, fmt::format("'{}' must be {}", text,
                            count == 1 ? "the id of a marker"
                                       : "three different ids: of the "
                                         "marker at the corner, on the x axis, on the y axis, such as 0,1,2"));
  return ids;
}

/// What stands still in the frames.
std::vector<StillMarker> Watch(const WorldRequest& request, const DetectorOptions& options, FrameFeed& feed,
                               WorldProgress& shown) {
  Detector detector(options);
  StillMarkers still;
  const CameraModel& camera = *options.camera;
  while (still.frames() < request.frames) {
    const auto frame = feed.Next();
    if (!frame) break;
    if (frame->image.width() != camera.width || frame->image.height() != camera.height)
      throw std::runtime_error(fmt::format("{} is {}x{}, but the calibration {} is for {}x{}", frame->name,
                                           frame->image.width(), frame->image.height(), request.calibration,
                                           camera.width, camera.height));
    still.Add(detector.Detect(frame->image));
    shown.Look(still, request.frames);
  }
  if (still.frames() == 0) throw std::runtime_error("there are no frames");
  return still.Means();
}

/// Where the world is, in one of the three ways of saying it.
struct WorldWay {
  std::vector<std::uint64_t> ids;  ///< of the references
  WorldProgress::Solver solve;
};

WorldWay ByReferences(const WorldRequest& request, const DetectorOptions& options) {
  const ReferenceList list = LoadReferences(request.references);
  WorldWay way;
  for (const Reference& reference : list.references) {
    way.ids.push_back(reference.id);
    if (static_cast<std::size_t>(reference.family) >= options.families.size())
      throw std::runtime_error(fmt::format("{}: reference {}: family = {}: must be below {}, the number of --marker",
                                           request.references, reference.id, reference.family,
                                           options.families.size()));
  }
  way.solve = [list, name = request.references](const std::vector<StillMarker>& seen) {
    try {
      return WorldResult{EstimateFromReferences(list, seen), seen};
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(name + ": " + error.what());
    }
  };
  return way;
}

WorldWay ByMarkers(const char* option, const std::string& text, std::size_t count) {
  const std::vector<std::uint64_t> ids = ParseIds(option, text, count);
  return {ids, [ids](const std::vector<StillMarker>& seen) {
            std::vector<StillMarker> markers;
            for (const std::uint64_t id : ids) markers.push_back(Find(seen, id));
            WorldEstimate estimate = markers.size() == 1
                                         ? EstimateFromMarker(markers[0])
                                         : EstimateFromL(std::span<const StillMarker, 3>(markers.begin(), 3));
            return WorldResult{std::move(estimate), std::move(markers)};
          }};
}

WorldResult Estimate(const WorldRequest& request, const DetectorOptions& options, FrameFeed& feed) {
  const WorldWay way = !request.references.empty() ? ByReferences(request, options)
                       : !request.origin.empty()   ? ByMarkers("--origin", request.origin, 1)
                                                   : ByMarkers("--l", request.l_of_three, 3);
  WorldProgress shown(request.setup, *options.camera, way.ids, way.solve);
  try {
    WorldResult result = way.solve(Watch(request, options, feed, shown));
    shown.Finish(result);
    return result;
  } catch (const std::runtime_error& error) {
    shown.Fail(error.what());
    throw;
  }
}

WorldCalibration MakeWorld(const WorldResult& result, const DetectorOptions& options) {
  WorldCalibration world;
  world.world_from_camera = result.estimate.world_from_camera;
  world.covariance = result.estimate.covariance;
  world.rms_m = result.estimate.rms_m;
  world.date = NowInUtc();
  for (const ReferenceResidual& residual : result.estimate.residuals) {
    const StillMarker& marker = result.markers[residual.seen];
    WorldReference reference;
    reference.id = marker.id;
    reference.size = marker.size;
    reference.variant = marker.variant;
    reference.side_m = options.families[static_cast<std::size_t>(marker.family)].side_m;
    reference.world_from_marker = world.world_from_camera * marker.camera_from_marker;
    reference.residual_m = residual.offset_m;
    world.references.push_back(reference);
  }
  return world;
}

std::string Degrees(const std::optional<double>& angle_rad) {
  return angle_rad ? fmt::format("{:8.2f}", *angle_rad * 180 / M_PI) : fmt::format("{:>8}", "-");
}

void PrintResult(const WorldResult& result) {
  fmt::print("reference  frames   dx mm   dy mm   dz mm   off mm  tilt deg  heading deg\n");
  for (const ReferenceResidual& residual : result.estimate.residuals) {
    const StillMarker& marker = result.markers[residual.seen];
    const Eigen::Vector3d mm = residual.offset_m * 1000;
    fmt::print("{:>9}  {:>6}  {:6.2f}  {:6.2f}  {:6.2f}  {:7.2f}  {}     {}\n", marker.id, marker.frames, mm.x(),
               mm.y(), mm.z(), mm.norm(), Degrees(residual.tilt_rad), Degrees(residual.heading_rad));
  }
  for (const std::uint64_t id : result.estimate.unseen) fmt::print("{:>9}  not seen\n", id);
  const RigidTransform& pose = result.estimate.world_from_camera;
  const Eigen::Matrix<double, 6, 1> sigma = result.estimate.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::Vector3d& p = pose.translation;
  fmt::print("camera at ({:.4f}, {:.4f}, {:.4f}) m ± ({:.1f}, {:.1f}, {:.1f}) mm, turned ± {:.3f} deg; RMS {:.2f} mm\n",
             p.x(), p.y(), p.z(), sigma[0] * 1000, sigma[1] * 1000, sigma[2] * 1000,
             sigma.tail<3>().maxCoeff() * 180 / M_PI, result.estimate.rms_m * 1000);
}

void RunWorld(WorldRequest& request) {
  TakeReferencesFromInputs(request);
  CheckWays(request);
  if (!request.origin.empty()) ParseIds("--origin", request.origin, 1);
  if (!request.l_of_three.empty()) ParseIds("--l", request.l_of_three, 3);
  request.setup = LoadSetup(request.feed.config);
  const auto& setup = request.setup;
  request.calibration = FileOf("--calibration", request.calibration, setup, setup ? setup->calibration : std::nullopt,
                               "calibration in [camera]");
  request.out = FileOf("--out", request.out, setup, setup ? setup->world : std::nullopt, "file in [world]");
  CheckOut(request.out, request.force);
  DetectorOptions options;
  options.families = ChooseMarkerFamilies(request.markers, setup, true);
  if (setup) options.color_space = setup->color_space;
  options.camera = LoadCamera(request.calibration);
  if (request.feed.gamma) options.camera->tone_curve.reset();
  FrameFeed feed(request.feed, setup, &*options.camera);
  const WorldResult result = Estimate(request, options, feed);
  PrintResult(result);
  WriteCalibration(request.out, FormatWorld(MakeWorld(result, options)));
  fmt::print("written: {}\n", request.out);
  if (feed.failed() > 0) throw CLI::RuntimeError(kExitInput);
}

void AddWorldOptions(CLI::App& command, WorldRequest& request) {
  AddFrameFeedOptions(command, request.feed, "the markers, the camera file and the file to write");
  AddMarkerOptions(command, request.markers);
  command.add_option("--calibration", request.calibration, "Camera file [the configuration's]")->type_name("FILE");
  command
      .add_option("--references", request.references,
                  "List of markers at known places (TOML); may also stand without the option")
      ->type_name("FILE");
  command.add_option("--l", request.l_of_three, "Three markers on the floor: corner, on the x axis, on the y axis")
      ->type_name("ID,ID,ID");
  command.add_option("--origin", request.origin, "One marker, whose frame is the world's")->type_name("ID");
  command.add_option("--frames", request.frames, "Most frames that are averaged")->capture_default_str();
  command.add_option("--out", request.out, "World file to write [the configuration's]")->type_name("FILE");
  command.add_flag("--force", request.force, kForceHelp);
}

}  // namespace

void AddCalibrateWorldCommand(CLI::App& calibrate) {
  CLI::App* command = calibrate.add_subcommand("world", "Finds where the camera stands in the room");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<WorldRequest>();
  AddWorldOptions(*command, *request);
  command->footer(
      "The world frame: metres, z up from the floor. A list of references has, for each marker,\n"
      "  [[reference]]\n"
      "  id = 3\n"
      "  position = [1.2, 0.0]   # of its centre; a third number is its height\n"
      "  heading = 90            # may be left out: of its x axis, degrees, counter-clockwise\n"
      "and may begin with sigma = 0.001, how exact the places are (metres, standard deviation): references that are\n"
      "farther off than five of it contradict the others and are named.\n\n"
      "  chequer calibrate world --config north room.toml\n"
      "  chequer calibrate world --config north --l 0,1,2\n"
      "  chequer calibrate world --calibration camera.toml --side 12cm --references room.toml frames/ --out "
      "world.toml");
  command->callback([request] { RunWorld(*request); });
}

}  // namespace chequer
