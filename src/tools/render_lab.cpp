#include "tools/render_lab.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "print/sheet.h"
#include "robot/robot_roster.h"
#include "simulate/random.h"
#include "world/references.h"
#include "world/world_file.h"

namespace chequer {
namespace {

/// The camera of a room without a world file looks down, tilted and turned by that: nobody mounts it level.
constexpr double kRoomTiltRad = 0.17, kRoomTurnRad = 0.05;
/// Robots drive round circles of that radius, so that none leaves its place.
constexpr double kRoomRoamM = 0.08;

RigidTransform FlatIn(const Eigen::Vector3d& position, double heading_rad) {
  return {RotationFromVector({0, 0, heading_rad}), position};
}

/// A marker of a family in one print; the same seed gives the same.
SceneMarker MakeLabMarker(const MarkerFamily& family, std::uint64_t id, const MarkerPrint& print, std::uint64_t seed,
                          const RigidTransform& camera_from_marker) {
  SceneMarker marker;
  marker.board = MakeBoard(family.code, id);
  marker.side_m = family.side_m;
  const Eigen::Vector2d cell_m = family.CellM(id);
  if (family.printed_by_id_m.contains(id))
    marker.side_m = std::max(marker.board.rows, marker.board.cols) * std::sqrt(cell_m.prod());
  marker.inks = print.inks;
  marker.ink_spread_cells = print.ink_spread_cells;
  marker.margin_cells = 1;
  Print(print.quality, seed, marker);
  // Of the size that was measured, the print is off by its own scale.
  marker.print.scale.array() *= cell_m.array() / marker.CellSize();
  marker.camera_from_marker = camera_from_marker;
  return marker;
}

void AddIfDrawable(std::vector<SceneMarker>& markers, SceneMarker marker, const CameraModel& camera) {
  if (IsDrawable(marker, camera)) markers.push_back(std::move(marker));
}

/// A family and the ids of it that are meant.
MarkerFamily FamilyWithIds(const RenderRequest& request, const char* why) {
  MarkerFamily family = ChooseMarkerFamilies(request.markers, request.setup, true).front();
  if (family.roster.empty()) throw CLI::ValidationError("--ids", why);
  return family;
}

double LongestSide(const std::vector<MarkerFamily>& families) {
  double side_m = 0;
  for (const MarkerFamily& family : families) side_m = std::max(side_m, family.side_m);
  return side_m;
}

/// A robot of the room and where its circle lies.
struct RoomRobot {
  std::uint64_t id = 0;
  int family = 0;
  RigidTransform body_from_marker;
  Eigen::Vector3d home_in_world = Eigen::Vector3d::Zero();  ///< on the floor
  double start_rad = 0;
};

/// The room with all that stands and drives in it.
class LabRoom {
 public:
  LabRoom(const RenderRequest& request, CameraModel camera)
      : camera_(std::move(camera)),
        families_(ChooseMarkerFamilies(request.markers, request.setup, true)),
        references_(LoadReferences(request.room).references),
        print_(PlanMarkerPrint(request, LongestSide(families_))),
        seed_(request.seed),
        speed_m_s_(request.max_speed_m_s) {
    for (const Reference& reference : references_) {
      if (static_cast<std::size_t>(reference.family) >= families_.size())
        throw std::runtime_error(request.room + ": there is no family " + std::to_string(reference.family));
      box_.extend(reference.position_in_world.head<2>());
    }
    PlaceCamera(request);
    TakeRobots(request);
    PlaceRobots();
  }

  std::vector<SceneMarker> At(double time_s) const {
    const RigidTransform camera_from_world = world_from_camera_.Inverse();
    std::vector<SceneMarker> markers;
    for (const Reference& reference : references_)
      AddIfDrawable(
          markers,
          MakeMarker(reference.family, reference.id,
                     camera_from_world * FlatIn(reference.position_in_world, reference.heading_rad.value_or(0))),
          camera_);
    for (const RoomRobot& robot : robots_)
      AddIfDrawable(
          markers,
          MakeMarker(robot.family, robot.id, camera_from_world * WorldFromBody(robot, time_s) * robot.body_from_marker),
          camera_);
    return markers;
  }

 private:
  /// Each is printed on its own.
  SceneMarker MakeMarker(int family, std::uint64_t id, const RigidTransform& camera_from_marker) const {
    const std::uint64_t of_family = DeriveSeed(seed_, static_cast<std::uint64_t>(family));
    return MakeLabMarker(FamilyOf(family), id, print_, DeriveSeed(of_family, id), camera_from_marker);
  }
  const MarkerFamily& FamilyOf(int family) const { return families_[static_cast<std::size_t>(family)]; }

  void PlaceCamera(const RenderRequest& request) {
    std::error_code unknown;
    std::filesystem::path world = request.world;
    if (world.empty() && request.setup && request.setup->world &&
        std::filesystem::exists(*request.setup->world, unknown))
      world = *request.setup->world;
    if (!world.empty()) {
      world_from_camera_ = LoadWorld(world).world_from_camera;
      return;
    }
    const Eigen::Vector2d middle = box_.center();
    // Tilted, it looks at the middle from beside it.
    world_from_camera_.translation = {middle.x(), middle.y() - std::sin(kRoomTiltRad) * request.distance_m,
                                      std::cos(kRoomTiltRad) * request.distance_m};
    // Half a turn about x looks down.
    world_from_camera_.rotation =
        RotationFromVector({M_PI + kRoomTiltRad, 0, 0}) * RotationFromVector({0, 0, kRoomTurnRad});
  }

  void TakeRobots(const RenderRequest& request) {
    std::error_code unknown;
    std::filesystem::path roster = request.robots;
    if (roster.empty() && request.setup && request.setup->robots &&
        std::filesystem::exists(*request.setup->robots, unknown))
      roster = *request.setup->robots;
    if (!roster.empty()) {
      const RobotRoster known = LoadRobotRoster(roster, families_);
      SetPrints(known, families_);
      for (const RosterRobot& robot : known.robots)
        for (const RosterMarker& marker : robot.markers)
          robots_.push_back({.id = marker.id, .family = marker.family, .body_from_marker = marker.body_from_marker});
      return;
    }
    for (const std::uint64_t id : families_.front().roster) {
      const bool lies = std::any_of(references_.begin(), references_.end(),
                                    [&](const Reference& r) { return r.family == 0 && r.id == id; });
      if (!lies) robots_.push_back({.id = id, .family = 0, .body_from_marker = FlatIn({0, 0, kRoomRobotHeightM}, 0)});
    }
  }

  /// In rows and columns within the references' rectangle, clear of its rim.
  void PlaceRobots() {
    const auto count = static_cast<int>(robots_.size());
    if (count == 0) return;
    const Eigen::Vector2d size = box_.sizes();
    const double side = FamilyOf(0).side_m;
    const int cols = std::max(1, static_cast<int>(std::ceil(std::sqrt(count * (size.x() + side) / (size.y() + side)))));
    const int rows = (count + cols - 1) / cols;
    for (int i = 0; i < count; ++i) {
      RoomRobot& robot = robots_[static_cast<std::size_t>(i)];
      robot.home_in_world = {box_.min().x() + size.x() * (i % cols + 1) / (cols + 1),
                             box_.min().y() + size.y() * (i / cols + 1) / (rows + 1), 0};
      robot.start_rad = 2 * M_PI * i / count;
    }
  }

  RigidTransform WorldFromBody(const RoomRobot& robot, double time_s) const {
    const double angle = robot.start_rad + speed_m_s_ / kRoomRoamM * time_s;
    const Eigen::Vector3d at = robot.home_in_world + kRoomRoamM * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    return FlatIn(at, angle + M_PI / 2);
  }

  CameraModel camera_;
  std::vector<MarkerFamily> families_;
  std::vector<Reference> references_;
  MarkerPrint print_;
  std::uint64_t seed_;
  Eigen::AlignedBox2d box_;
  RigidTransform world_from_camera_;
  std::vector<RoomRobot> robots_;
  double speed_m_s_;
};

/// Where a sheet is held: all parts of the image in turn, tilted to all sides, nearer and farther.
RigidTransform HoldSheet(const CameraModel& camera, const PaperSize& paper, int view, Random& random) {
  const double u = (view % 4 + random.Uniform(0.2, 0.8)) / 4, v = (view / 4 % 3 + random.Uniform(0.2, 0.8)) / 3;
  const Eigen::Vector2d aim = camera.Undistort({u * camera.width, v * camera.height}).value_or(Eigen::Vector2d::Zero());
  const double axis = random.Uniform(0, 2 * M_PI), tilt = random.Uniform(0.25, 0.65);
  RigidTransform camera_from_sheet;
  camera_from_sheet.rotation = RotationFromVector(tilt * Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
                               RotationFromVector({M_PI, 0, 0}) *
                               RotationFromVector({0, 0, random.Uniform(0, 2 * M_PI)});
  // The paper's diagonal is 0.5 to 0.8 of the image's height.
  const double share = random.Uniform(0.5, 0.8);
  const double distance = camera.fy * std::hypot(paper.width_m, paper.height_m) / (share * camera.height);
  camera_from_sheet.translation = distance * Eigen::Vector3d(aim.x(), aim.y(), 1);
  return camera_from_sheet;
}

}  // namespace

MarkersAt PlanSheetViews(const RenderRequest& request, const CameraModel& camera) {
  const MarkerFamily family = FamilyWithIds(request, "is missing: --sheet shows the markers of these ids");
  SheetOptions sheet;
  sheet.code = family.code;
  sheet.ids = family.roster;
  sheet.side_m = family.side_m;
  sheet.printed_m = family.printed_m;
  const SheetLayout layout = LayOutSheet(sheet);
  const Eigen::Vector2d cell = sheet.CellM();
  // A sheet is printed at once: all of it is off alike.
  const MarkerPrint print = PlanMarkerPrint(request, std::max(sheet.paper.width_m, sheet.paper.height_m));
  const SceneMarker one = MakeLabMarker(family, family.roster.front(), print, request.seed, {});
  const Eigen::Vector2d scale = one.print.scale.array() * one.CellSize() / family.CellM().array();
  std::vector<std::pair<std::uint64_t, RigidTransform>> boards;
  for (const PlacedMarker& placed : layout.pages.front()) {
    const double x = placed.x_m + cell.x() * family.code.size().cols / 2 - sheet.paper.width_m / 2;
    const double y = sheet.paper.height_m / 2 - placed.y_m - cell.y() * family.code.size().rows / 2;
    boards.emplace_back(placed.id, OnBentPaper({scale.x() * x, scale.y() * y}, one.bend_per_m, one.bend_angle_rad));
  }
  return [=, fps = request.fps, seed = request.seed](std::chrono::duration<double> time) {
    const int view = static_cast<int>(std::lround(time.count() * fps));
    Random random(DeriveSeed(seed, static_cast<std::uint64_t>(view)));
    const RigidTransform camera_from_sheet = HoldSheet(camera, sheet.paper, view, random);
    std::vector<SceneMarker> markers;
    for (const auto& [id, sheet_from_board] : boards)
      AddIfDrawable(markers, MakeLabMarker(family, id, print, seed, camera_from_sheet * sheet_from_board), camera);
    return markers;
  };
}

MarkersAt PlanRoom(const RenderRequest& request, const CameraModel& camera) {
  // Shared, as std::function copies what it holds.
  const auto room = std::make_shared<const LabRoom>(request, camera);
  return [room](std::chrono::duration<double> time) { return room->At(time.count()); };
}

}  // namespace chequer
