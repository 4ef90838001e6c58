#include "support/room.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <stdexcept>

#include "capture/recording_writer.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "simulate/truth.h"

namespace chequer::test {
namespace {

using Seconds = std::chrono::duration<double>;

const MarkerCode& Code() {
  static const MarkerCode code(MarkerSize{}, Variant::kSecded);
  return code;
}

SceneMarker MarkerOf(std::uint64_t id, const RigidTransform& camera_from_marker) {
  SceneMarker marker;
  marker.board = MakeBoard(Code(), id);
  marker.side_m = kRoomSideM;
  marker.margin_cells = 0.5;
  marker.camera_from_marker = camera_from_marker;
  return marker;
}

SceneMarker InRoom(std::uint64_t id, const RigidTransform& world_from_marker) {
  return MarkerOf(id, WorldFromRoomCamera().Inverse() * world_from_marker);
}

RigidTransform Flat(const Eigen::Vector3d& position, double heading_rad) {
  return {RotationFromVector({0, 0, heading_rad}), position};
}

/// An industrial camera: raw Bayer, linear, with the noise of a good sensor.
RenderOptions CameraOptions(const CameraModel& camera) {
  RenderOptions options;
  options.camera = camera;
  options.format = PixelFormat::kBayerRg8;
  options.tone_curve = ToneCurve::Linear();
  return options;
}

void Record(const std::filesystem::path& folder, const CameraModel& camera, int frames, double fps, std::uint64_t seed,
            const std::function<std::vector<SceneMarker>(Seconds)>& markers_at) {
  const RenderOptions options = CameraOptions(camera);
  const Renderer renderer(options, Background{.kind = BackgroundKind::kWood, .seed = seed});
  RecordingInfo info;
  info.camera = "room";
  info.width = options.camera.width;
  info.height = options.camera.height;
  info.pixel_format = options.format;
  info.tone_curve = options.tone_curve;
  info.fps = fps;
  info.truth = "truth.jsonl";
  RecordingWriter writer(folder, info, {.kind = FrameFileKind::kRaw, .jpeg = {}});
  std::vector<FrameTruth> truth;
  for (int i = 0; i < frames; ++i) {
    const auto since_first = std::chrono::round<std::chrono::microseconds>(Seconds(i / fps));
    const std::vector<SceneMarker> markers = markers_at(since_first);
    const auto number = static_cast<std::uint64_t>(i);
    const Image image = renderer.Render(markers, DeriveSeed(seed, number));
    FrameTruth frame;
    frame.file = writer.Add(image.view(), UtcTime(std::chrono::seconds(1'700'000'000)) + since_first,
                            MonotonicTime(std::chrono::seconds(1)) + since_first, number);
    frame.markers = TruthOf(markers, options.camera);
    truth.push_back(std::move(frame));
  }
  writer.Finish();
  WriteTruth(folder / info.truth, truth);
}

std::vector<SceneMarker> ReferenceMarkers() {
  std::vector<SceneMarker> markers;
  for (const RoomReference& reference : RoomReferences())
    markers.push_back(InRoom(reference.id, Flat(reference.position_in_world, reference.heading_rad)));
  return markers;
}

/// A sheet of 5 x 4 markers, shown aimed at a pixel.
std::vector<SceneMarker> Sheet(const RigidTransform& camera_from_sheet, const CameraModel& camera) {
  constexpr int kCols = 5, kRows = 4;
  constexpr double kPitchM = 0.15;
  std::vector<SceneMarker> markers;
  for (int i = 0; i < kCols * kRows; ++i) {
    // Glued on by hand.
    const double x = kPitchM * (i % kCols - 0.5 * (kCols - 1)) + 0.002 * std::sin(7 * i);
    const double y = kPitchM * (i / kCols - 0.5 * (kRows - 1)) + 0.002 * std::cos(5 * i);
    const SceneMarker marker = MarkerOf(kFirstSheetId + static_cast<std::uint64_t>(i),
                                        camera_from_sheet * Flat({x, y, 0}, 0.02 * std::sin(3 * i)));
    // What stands over the frame's rim is seen in part; what lies where the lens sees nothing cannot be drawn.
    if (IsDrawable(marker, camera)) markers.push_back(marker);
  }
  return markers;
}

}  // namespace

CameraModel RoomCamera() {
  CameraModel camera{.width = 2048, .height = 1536, .fx = 1502.5, .fy = 1499.3, .cx = 1031.2, .cy = 757.9};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.18, 0.05, 0.0006, -0.0004, 0.002};
  return camera;
}

RigidTransform WorldFromRoomCamera() {
  RigidTransform world_from_camera;
  world_from_camera.translation = {1.3, 0.35, 2.2};
  // Half a turn about x looks down; 15 degrees more tilt the view ahead, along y; mounted askew by 3 degrees.
  world_from_camera.rotation = RotationFromVector({M_PI + 15 * M_PI / 180, 0, 0}) * RotationFromVector({0, 0, 0.05});
  return world_from_camera;
}

double RobotHeightM(int robot) { return 0.06 + 0.03 * (robot % 4); }

RobotState RobotAt(int robot, Seconds time) {
  // Eight lanes of five robots along y, every other one the other way; a wide arc each, in the middle of its way after
  // a second.
  constexpr double kPitchX = 0.30, kPitchY = 0.28, kCurvature = 0.5;
  const int lane = robot % 8;
  const double start_rad = lane % 2 == 0 ? M_PI / 2 : -M_PI / 2, speed = 0.08 + 0.02 * lane;
  const double curvature = robot % 3 == 0 ? -kCurvature : kCurvature;
  const double way = speed * (time.count() - 1), heading = start_rad + curvature * way;
  const Eigen::Vector3d home(0.25 + kPitchX * lane, 0.35 + kPitchY * (robot / 8), RobotHeightM(robot));
  const Eigen::Vector3d offset((std::sin(heading) - std::sin(start_rad)) / curvature,
                               (std::cos(start_rad) - std::cos(heading)) / curvature, 0);
  RobotState state;
  state.world_from_marker = Flat(home + offset, heading);
  state.velocity_m_s = speed * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
  state.yaw_rate_rad_s = curvature * speed;
  return state;
}

std::vector<RoomReference> RoomReferences() {
  // Along the walls, where robots do not drive; one on a box.
  return {{kFirstReferenceId + 0, {0.0, 0.0, 0}, 0},         {kFirstReferenceId + 1, {2.6, 0.0, 0}, M_PI / 2},
          {kFirstReferenceId + 2, {2.75, 1.1, 0.25}, 0.4},   {kFirstReferenceId + 3, {2.6, 1.85, 0}, M_PI},
          {kFirstReferenceId + 4, {1.3, 1.9, 0}, -M_PI / 2}, {kFirstReferenceId + 5, {0.0, 1.85, 0}, 1.0},
          {kFirstReferenceId + 6, {-0.1, 0.9, 0}, 2.0},      {kFirstReferenceId + 7, {1.3, -0.15, 0}, 0}};
}

void RecordSheet(const std::filesystem::path& folder, int views, std::uint64_t seed, const CameraModel& camera) {
  Random random(seed);
  // As large in the image, whatever the lens.
  const double nearer = camera.fx / camera.width / 0.73;
  int view = 0;
  Record(folder, camera, views, 2, seed, [&](Seconds) {
    // All parts of the image in turn, tilted to all sides, nearer and farther.
    const double u = (view % 4 + random.Uniform(0.2, 0.8)) / 4, v = (view / 4 % 3 + random.Uniform(0.2, 0.8)) / 3;
    const double axis = random.Uniform(0, 2 * M_PI), tilt = random.Uniform(0.25, 0.65);
    ++view;
    const auto aim = camera.Undistort({u * camera.width, v * camera.height});
    if (!aim) throw std::logic_error("the room's camera sees nothing there");
    RigidTransform camera_from_sheet;
    camera_from_sheet.rotation = RotationFromVector(tilt * Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
                                 RotationFromVector({M_PI, 0, 0}) *
                                 RotationFromVector({0, 0, random.Uniform(0, 2 * M_PI)});
    camera_from_sheet.translation = nearer * random.Uniform(0.9, 1.5) * Eigen::Vector3d(aim->x(), aim->y(), 1);
    return Sheet(camera_from_sheet, camera);
  });
}

void RecordReferences(const std::filesystem::path& folder, int frames, std::uint64_t seed) {
  Record(folder, RoomCamera(), frames, 10, seed, [](Seconds) { return ReferenceMarkers(); });
}

void RecordDrive(const std::filesystem::path& folder, int frames, double fps, std::uint64_t seed) {
  Record(folder, RoomCamera(), frames, fps, seed, [](Seconds time) {
    std::vector<SceneMarker> markers = ReferenceMarkers();
    for (int robot = 0; robot < kRobots; ++robot)
      markers.push_back(InRoom(static_cast<std::uint64_t>(robot), RobotAt(robot, time).world_from_marker));
    return markers;
  });
}

void WriteReferenceList(const std::filesystem::path& file) {
  std::ofstream out(file);
  out << "sigma = 0.001\n";
  for (const RoomReference& reference : RoomReferences()) {
    const Eigen::Vector3d& p = reference.position_in_world;
    out << "[[reference]]\nid = " << reference.id << "\nposition = [" << p.x() << ", " << p.y() << ", " << p.z()
        << "]\n";
  }
}

}  // namespace chequer::test
