#include "robot/robot_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "robot/body_fit.h"

namespace chequer {
namespace {

/// χ² of three degrees of freedom that noise does not reach, with room for what a calibration leaves.
constexpr double kNotNoise = 50;
/// How far two markers of one robot may be from fitting its body: what a body gives way and a hand mounts askew.
constexpr double kMountingM = 0.01, kMountingShare = 0.1;
/// Standard deviations that noise adds to that.
constexpr double kNoiseLimit = 4;

/// Covariance of a body's pose, from its marker's: the body's origin is `arm` away from the marker's centre, and a turn
/// θ of the marker moves it by θ × arm.
Matrix6d MovedBy(const Matrix6d& covariance, const Eigen::Vector3d& arm) {
  Matrix6d by_marker = Matrix6d::Identity();
  by_marker.topRightCorner<3, 3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  return by_marker * covariance * by_marker.transpose();
}

/// The body's pose in the camera frame by one marker alone.
BodyFit ByOneMarker(const MarkerPose& marker, const RosterMarker& mounted) {
  const RigidTransform camera_from_body = marker.camera_from_marker * mounted.body_from_marker.Inverse();
  const Eigen::Vector3d arm = camera_from_body.translation - marker.camera_from_marker.translation;
  return {camera_from_body, MovedBy(marker.covariance, arm), 0, MovedBy(marker.print_covariance, arm)};
}

double Spread(const Matrix6d& covariance) { return std::sqrt(covariance.topLeftCorner<3, 3>().trace()); }

/// How far the second marker is from where the first says it should be, metres, less what noise explains; at most 0
/// where they fit.
double Misfit(const RosterRobot& robot, const MarkerPose& first, const MarkerPose& second) {
  const RigidTransform first_from_second =
      robot.markers[0].body_from_marker.Inverse() * robot.markers[1].body_from_marker;
  const RigidTransform expected = first.camera_from_marker * first_from_second;
  const Eigen::Vector3d arm = expected.translation - first.camera_from_marker.translation;
  const double distance = (second.camera_from_marker.translation - expected.translation).norm();
  const double noise = Spread(MovedBy(first.covariance, arm)) + Spread(second.covariance);
  return distance - kMountingM - kMountingShare * arm.norm() - kNoiseLimit * noise;
}

std::vector<MountedBoard> Boards(const RosterRobot& robot, std::span<const MarkerPose* const> chosen) {
  std::vector<MountedBoard> boards;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i] != nullptr) boards.push_back({chosen[i]->measurement, robot.markers[i].body_from_marker});
  return boards;
}

Matrix6d Rotated(const Matrix6d& covariance, const Eigen::Quaterniond& rotation) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = rotation.toRotationMatrix();
  return turn * covariance * turn.transpose();
}

}  // namespace

std::string RobotFinderOptions::Check() const {
  if (floor_mode && !world_from_camera) return "floor mode needs a world: where the floor is seen from the camera";
  if (!(max_height_error_m >= 0.001 && max_height_error_m <= 10)) return "max_height_error must be from 0.001 to 10 m";
  if (!(max_tilt_rad >= 0.01 && max_tilt_rad <= std::numbers::pi)) return "max_tilt must be from 0.6 to 180 degrees";
  return "";
}

RobotFinder::RobotFinder(RobotFinderOptions options) : options_(std::move(options)) {
  if (const std::string wrong = options_.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  for (std::size_t robot = 0; robot < options_.roster.robots.size(); ++robot) {
    const std::vector<RosterMarker>& markers = options_.roster.robots[robot].markers;
    for (std::size_t i = 0; i < markers.size(); ++i)
      bearers_.emplace(std::pair(markers[i].family, markers[i].id), std::pair(robot, i));
  }
}

bool RobotFinder::Knows(const MarkerPose& marker) const {
  return marker.id && bearers_.contains({marker.family, *marker.id});
}

bool RobotFinder::IsShared(const RosterMarker& marker) const { return bearers_.count({marker.family, marker.id}) > 1; }

void RobotFinder::Find(std::span<const MarkerPose> markers, std::vector<RobotPose>& robots) const {
  robots.clear();
  std::map<std::size_t, Candidates> by_robot;
  for (const MarkerPose& marker : markers) {
    if (!marker.id || !marker.has_pose) continue;
    const auto [begin, end] = bearers_.equal_range({marker.family, *marker.id});
    for (auto bearer = begin; bearer != end; ++bearer)
      by_robot[bearer->second.first].seen[bearer->second.second].push_back(&marker);
  }
  std::vector<const MarkerPose*> taken;
  for (const auto& [index, candidates] : by_robot) {
    const RosterRobot& robot = options_.roster.robots[index];
    if (robot.markers.size() > 1) {
      FindPair(robot, candidates, taken, robots);
      continue;
    }
    for (const MarkerPose* marker : candidates.seen[0]) robots.push_back(Describe(robot, {marker, nullptr}));
  }
}

void RobotFinder::FindPair(const RosterRobot& robot, const Candidates& candidates,
                           std::vector<const MarkerPose*>& taken, std::vector<RobotPose>& robots) const {
  const auto is_free = [&](const MarkerPose* marker) {
    return std::find(taken.begin(), taken.end(), marker) == taken.end();
  };
  Chosen best{};
  double least = 0;
  for (const MarkerPose* first : candidates.seen[0])
    for (const MarkerPose* second : candidates.seen[1])
      if (const double misfit = Misfit(robot, *first, *second); misfit <= least && is_free(first) && is_free(second)) {
        least = misfit;
        best = {first, second};
      }
  if (best[0] == nullptr) {
    // One alone tells, unless it may be another robot's.
    for (std::size_t i = 0; i < robot.markers.size(); ++i)
      for (const MarkerPose* marker : candidates.seen[i]) {
        const auto current = std::find_if(best.begin(), best.end(), [](const MarkerPose* m) { return m != nullptr; });
        if (IsShared(robot.markers[i]) || !is_free(marker)) continue;
        if (current != best.end() && Spread((*current)->covariance) <= Spread(marker->covariance)) continue;
        best = {};
        best[i] = marker;
      }
  }
  if (best[0] == nullptr && best[1] == nullptr) return;
  robots.push_back(Describe(robot, best));
  taken.insert(taken.end(), best.begin(), best.end());
}

RobotPose RobotFinder::Describe(const RosterRobot& robot, const Chosen& chosen) const {
  RobotPose pose;
  pose.name = robot.name;
  BodyFit fit;
  for (std::size_t i = 0; i < robot.markers.size(); ++i) {
    if (chosen[i] == nullptr) continue;
    const BodyFit alone = ByOneMarker(*chosen[i], robot.markers[i]);
    if (pose.marker_count == 0) {
      fit = alone;
      pose.family = robot.markers[i].family;
      pose.ambiguity = chosen[i]->ambiguity;
    } else if (chosen[i]->ambiguity < pose.ambiguity) {
      fit = alone;  // the surer start
      pose.ambiguity = chosen[i]->ambiguity;
    }
    pose.ids[static_cast<std::size_t>(pose.marker_count++)] = robot.markers[i].id;
  }
  if (pose.marker_count > 1) {
    if (const auto together = FitFreeBody(Boards(robot, chosen), fit.camera_from_body)) fit = *together;
  }
  pose.frame_from_body = fit.camera_from_body;
  pose.covariance = fit.covariance;
  pose.print_covariance = fit.print_covariance;
  if (options_.world_from_camera) {
    pose.frame_from_body = *options_.world_from_camera * fit.camera_from_body;
    pose.covariance = Rotated(fit.covariance, options_.world_from_camera->rotation);
    pose.print_covariance = Rotated(fit.print_covariance, options_.world_from_camera->rotation);
  }
  pose.frame_from_body.rotation = Canonical(pose.frame_from_body.rotation);
  if (options_.floor_mode) pose.floor = DescribeFloor(robot, chosen, fit.camera_from_body);
  return pose;
}

std::optional<FloorPose> RobotFinder::DescribeFloor(const RosterRobot& robot, const Chosen& chosen,
                                                    const RigidTransform& camera_from_body) const {
  const std::vector<MountedBoard> boards = Boards(robot, chosen);
  const RigidTransform world_from_body = *options_.world_from_camera * camera_from_body;
  const auto fit = FitBodyOnFloor(boards, options_.world_from_camera->Inverse(), robot.body_height_m, world_from_body);
  if (!fit) return std::nullopt;
  FloorPose floor;
  floor.position = fit->position;
  floor.height_m = robot.body_height_m;
  floor.heading_rad = fit->heading_rad;
  floor.covariance = fit->covariance;
  floor.print_covariance = fit->print_covariance;
  for (const MountedBoard& board : boards) {
    const double expected = robot.body_height_m + board.body_from_marker.translation.z();
    floor.height_error_m +=
        ((world_from_body * board.body_from_marker.translation).z() - expected) / static_cast<double>(boards.size());
  }
  const Eigen::Vector3d up = world_from_body.rotation * Eigen::Vector3d::UnitZ();
  floor.tilt_rad = std::acos(std::clamp(up.z(), -1.0, 1.0));
  floor.chi_square = std::max(0.0, fit->chi_square - ChiSquare(boards, camera_from_body));
  const bool beyond =
      std::abs(floor.height_error_m) > options_.max_height_error_m || floor.tilt_rad > options_.max_tilt_rad;
  floor.off_floor = beyond && floor.chi_square > kNotNoise;
  return floor;
}

}  // namespace chequer
