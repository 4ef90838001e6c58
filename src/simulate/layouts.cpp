#include "simulate/layouts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "simulate/random.h"

namespace chequer {
namespace {

struct TrackGeometry {
  std::string_view name;
  double distance_m;
  double half_length_m;
  double tilt_rad;
};

// Distances of the publication; the lengths are what its camera sees of the line at that distance.
constexpr std::array<TrackGeometry, 4> kTracks{{
    {"CloseDist", 0.6, 0.1864, 0},
    {"MedDist", 0.9, 0.3196, 0},
    {"FarDist", 1.4, 0.5416, 0},
    {"Inc30d", 0.9, 0.3196, M_PI / 6},
}};

constexpr int kTrackFrames = 8;
constexpr double kTrackSideM = 0.12;

/// Whether a board's circle about `home`, at any height of the swarm, is seen whole.
bool CircleInFrame(const CameraModel& camera, const Eigen::Vector3d& home, double radius) {
  for (int i = 0; i < 16; ++i) {
    const double angle = 2 * M_PI * i / 16;
    const Eigen::Vector3d rim = home + radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    const Eigen::Vector2d normalized = rim.head<2>() / rim.z();
    const Eigen::Vector2d pixel = camera.Distort(normalized);
    if (!(pixel.x() >= 1 && pixel.y() >= 1 && pixel.x() <= camera.width - 2 && pixel.y() <= camera.height - 2))
      return false;
    const auto back = camera.Undistort(pixel);
    if (!back || (*back - normalized).norm() > 1e-6) return false;
  }
  return true;
}

/// A triangle wave of period 4 and amplitude 1, starting upwards from 0.
double Triangle(double phase) {
  const double p = phase - 4 * std::floor(phase / 4);
  return p < 1 ? p : (p < 3 ? 2 - p : p - 4);
}

}  // namespace

CameraModel PublicationCamera() {
  CameraModel camera{.width = 640, .height = 480, .fx = 540.5, .fy = 540.5, .cx = 322.3, .cy = 237.1};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.25, 0.08, 0, 0, 0};
  return camera;
}

std::string_view TrackName(TrackCase track) { return kTracks[static_cast<std::size_t>(track)].name; }

std::vector<SceneMarker> PublicationTrack(TrackCase track, const MarkerCode& code, std::uint64_t seed) {
  const TrackGeometry& geometry = kTracks[static_cast<std::size_t>(track)];
  Random random(seed);
  SceneMarker marker;
  const double ids = std::min(static_cast<double>(code.max_id()) + 1, 0x1p53);
  marker.board = MakeBoard(code, static_cast<std::uint64_t>(random.Uniform() * ids));
  marker.side_m = kTrackSideM;
  const double heading = random.Uniform(0, 2 * M_PI);
  const double line = random.Uniform(-0.08, 0.08);
  const double tilt_axis = geometry.tilt_rad > 0 ? random.Uniform(0, 2 * M_PI) : 0.0;
  const RigidTransform pose = FacingPose({0, 0, geometry.distance_m}, heading, geometry.tilt_rad, tilt_axis);
  const Eigen::Vector3d normal = pose.rotation * Eigen::Vector3d::UnitZ();
  // The line across the frame, laid into the marker's plane.
  Eigen::Vector3d along(std::cos(line), std::sin(line), 0);
  along = (along - normal * normal.dot(along)).normalized();
  std::vector<SceneMarker> frames(kTrackFrames, marker);
  for (int i = 0; i < kTrackFrames; ++i) {
    const double at = geometry.half_length_m * (2.0 * i / (kTrackFrames - 1) - 1);
    frames[static_cast<std::size_t>(i)].camera_from_marker = {pose.rotation, pose.translation + at * along};
  }
  return frames;
}

std::string SwarmOptions::Check() const {
  if (camera.width < 1 || camera.height < 1) return "the swarm's camera has no size";
  if (!(side_m > 0)) return "side_m must be above 0";
  if (!sides_m.empty() && sides_m.size() != boards.size()) return "sides_m must be empty or one a board";
  for (const double side : sides_m)
    if (!(side > 0)) return "sides_m must be above 0";
  if (!(height_spread_m >= 0)) return "height_spread_m must be at least 0";
  if (!(distance_m > height_spread_m)) return "distance_m must be above height_spread_m";
  if (!(max_tilt_rad >= 0 && max_tilt_rad < 1.2)) return "max_tilt_rad must be from 0 to 1.2";
  if (!(max_speed_m_s >= 0)) return "max_speed_m_s must be at least 0";
  if (!(gap_m >= 0)) return "gap_m must be at least 0";
  return print.Check();
}

Swarm::Swarm(SwarmOptions options, std::uint64_t seed) : options_(std::move(options)) {
  if (std::string wrong = options_.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  Place(seed);
  for (std::size_t i = 0; i < options_.boards.size(); ++i) prints_.push_back(PrintFor(i, DeriveSeed(seed, i)));
}

SceneMarker Swarm::PrintFor(std::size_t index, std::uint64_t seed) const {
  SceneMarker marker;
  marker.board = options_.boards[index];
  marker.side_m = options_.SideOf(index);
  marker.inks = options_.inks;
  marker.margin_cells = options_.margin_cells;
  marker.ink_spread_cells = options_.ink_spread_cells;
  Print(options_.print, seed, marker);
  return marker;
}

std::optional<Swarm::Circle> Swarm::FindRoom(double radius_m, const std::vector<Circle>& taken, Random& random) const {
  const CameraModel& camera = options_.camera;
  // So many darts find nearly every gap that is left at the densities that can be reached at all.
  for (int dart = 0; dart < 2000; ++dart) {
    const auto seen = camera.Undistort({random.Uniform(0, camera.width), random.Uniform(0, camera.height)});
    const double depth = options_.distance_m - random.Uniform(0, options_.height_spread_m);
    if (!seen) continue;
    // The nearer board hides more of the floor, so circles are kept apart as they are seen on the floor.
    const Circle circle{{seen->x() * depth, seen->y() * depth, depth},
                        *seen * options_.distance_m,
                        radius_m * options_.distance_m / depth};
    const bool free = std::none_of(taken.begin(), taken.end(), [&](const Circle& other) {
      return (other.on_floor - circle.on_floor).norm() < other.floor_radius_m + circle.floor_radius_m;
    });
    if (free && CircleInFrame(camera, circle.home, radius_m)) return circle;
  }
  return std::nullopt;
}

std::size_t Swarm::TryPlace(double roam_m, std::uint64_t seed) {
  Random random(seed);
  std::vector<Circle> taken;
  robots_.clear();
  for (std::size_t i = 0; i < options_.boards.size(); ++i) {
    const Board& board = options_.boards[i];
    const double cells = std::hypot(board.rows + 2 * options_.margin_cells, board.cols + 2 * options_.margin_cells);
    const double radius = 0.5 * cells * board.CellSize(options_.SideOf(i)) + roam_m + 0.5 * options_.gap_m;
    const auto circle = FindRoom(radius, taken, random);
    if (!circle) break;
    taken.push_back(*circle);
    Robot robot{.home = circle->home, .roam_m = roam_m};
    robot.speed_m_s = options_.max_speed_m_s * random.Uniform(0.3, 1) * (random.Below(2) == 0 ? 1 : -1);
    robot.heading_rad = random.Uniform(0, 2 * M_PI);
    robot.tilt_rad = random.Uniform(0, options_.max_tilt_rad);
    robot.tilt_axis_rad = random.Uniform(0, 2 * M_PI);
    robot.turns = random.Below(2) == 0;
    robots_.push_back(robot);
  }
  return robots_.size();
}

void Swarm::Place(std::uint64_t seed) {
  // Less room to roam, then, if the robots do not all find a place.
  std::size_t most = 0;
  for (const double roam_m : {0.25, 0.15, 0.08, 0.04, 0.02, 0.0}) {
    most = std::max(most, TryPlace(roam_m, seed));
    if (most == options_.boards.size()) return;
  }
  char text[160];
  std::snprintf(text, sizeof text, "%zu markers do not fit into the frame; about %zu of them do, %g m away",
                options_.boards.size(), most, options_.distance_m);
  throw std::runtime_error(text);
}

SceneMarker Swarm::MarkerAt(std::size_t index, double time_s) const {
  const Robot& robot = robots_[index];
  Eigen::Vector2d offset(0, 0);
  double heading = robot.heading_rad;
  if (robot.roam_m > 0 && robot.turns) {
    const double turned = robot.speed_m_s * time_s / robot.roam_m;
    offset = robot.roam_m * Eigen::Vector2d(std::sin(heading + turned), -std::cos(heading + turned));
    heading += turned;
  } else if (robot.roam_m > 0) {
    const double at = robot.roam_m * Triangle(robot.speed_m_s * time_s / robot.roam_m);
    offset = at * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  }
  SceneMarker marker = prints_[index];
  const Eigen::Vector3d position = robot.home + Eigen::Vector3d(offset.x(), offset.y(), 0);
  marker.camera_from_marker = FacingPose(position, heading, robot.tilt_rad, robot.tilt_axis_rad);
  return marker;
}

std::vector<SceneMarker> Swarm::At(std::chrono::duration<double> time) const {
  std::vector<SceneMarker> markers;
  for (std::size_t i = 0; i < robots_.size(); ++i) markers.push_back(MarkerAt(i, time.count()));
  return markers;
}

}  // namespace chequer
