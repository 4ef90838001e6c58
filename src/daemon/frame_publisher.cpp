#include "daemon/frame_publisher.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace chequer {
namespace {

// What a robot on the floor still sways and rises: keeps its track from taking the floor for exact.
constexpr double kSwayM = 1e-3, kSwayRad = 1e-3;

const char* FrameName(bool world) { return world ? "world" : "camera"; }

}  // namespace

void MoveInto(const RigidTransform& target_from_camera, MarkerPose& marker) {
  if (!marker.has_pose) return;
  marker.camera_from_marker = target_from_camera * marker.camera_from_marker;
  marker.camera_from_marker.rotation = Canonical(marker.camera_from_marker.rotation);
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = target_from_camera.rotation.toRotationMatrix();
  marker.covariance = (turn * marker.covariance * turn.transpose()).eval();
  marker.print_covariance = (turn * marker.print_covariance * turn.transpose()).eval();
}

TrackedPose ToTrack(const RobotPose& robot) {
  const TrackKey key{robot.name, robot.family, robot.ids[0]};
  if (!robot.floor || robot.floor->off_floor)
    return {key, robot.frame_from_body, robot.covariance, robot.print_covariance};
  const FloorPose& floor = *robot.floor;
  const Eigen::Vector3d position(floor.position.x(), floor.position.y(), floor.height_m);
  TrackedPose pose{key, {RotationFromVector({0, 0, floor.heading_rad}), position}, Matrix6d::Zero(), Matrix6d::Zero()};
  pose.covariance.diagonal() << 0, 0, kSwayM * kSwayM, kSwayRad * kSwayRad, kSwayRad * kSwayRad, 0;
  constexpr int kPlaces[] = {0, 1, 5};  // of x, y and heading among the six
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 3; ++col) {
      pose.covariance(kPlaces[row], kPlaces[col]) = floor.covariance(row, col);
      pose.print_covariance(kPlaces[row], kPlaces[col]) = floor.print_covariance(row, col);
    }
  return pose;
}

FramePublisher::FramePublisher(FramePublisherOptions options) : options_(std::move(options)) {
  if (options_.world) monitor_.emplace(*options_.world, options_.drift);
  if (options_.roster) {
    RobotFinderOptions finder{.roster = *options_.roster,
                              .world_from_camera = std::nullopt,
                              .floor_mode = options_.floor_mode,
                              .max_height_error_m = options_.max_height_error_m,
                              .max_tilt_rad = options_.max_tilt_rad};
    if (options_.world) finder.world_from_camera = options_.world->world_from_camera;
    finder_.emplace(std::move(finder));
  }
  if (options_.tracks) tracker_.emplace(options_.tracker);
}

void FramePublisher::Publish(PosesMessage& message, Publisher& publisher, const Clock& clock) {
  WatchWorld(message);
  if (finder_) finder_->Find(message.markers, robots_.robots);
  if (finder_ && options_.ignore_others) LeaveOutOthers(message.markers);
  PublishPoses(message, publisher);
  if (finder_) {
    robots_.header = HeaderOf(message, clock);
    publisher.Publish(robots_);
    robot_count_ += robots_.robots.size();
    const auto is_off = [](const RobotPose& robot) { return robot.floor && robot.floor->off_floor; };
    off_floor_ += static_cast<std::uint64_t>(std::count_if(robots_.robots.begin(), robots_.robots.end(), is_off));
  }
  if (tracker_) {
    Collect(options_.world ? in_world_.markers : message.markers);
    Follow(HeaderOf(message, clock), clock);
    publisher.Publish(tracks_);
    track_count_ += tracks_.tracks.size();
  }
}

void FramePublisher::WatchWorld(const PosesMessage& message) {
  if (!monitor_) return;
  const auto news = monitor_->Take(message.markers, message.captured_monotonic);
  if (!news) return;
  trouble_ = monitor_->has_drifted() ? *news : std::string();
  if (monitor_->has_drifted())
    spdlog::warn("{}", *news);
  else
    spdlog::info("{}", *news);
}

void FramePublisher::LeaveOutOthers(std::vector<MarkerPose>& markers) {
  outside_roster_ +=
      std::erase_if(markers, [&](const MarkerPose& marker) { return marker.id && !finder_->Knows(marker); });
}

void FramePublisher::PublishPoses(PosesMessage& message, Publisher& publisher) {
  if (!options_.world) {
    publisher.Publish(message);
    return;
  }
  in_world_ = message;
  in_world_.frame = FrameName(true);
  for (MarkerPose& marker : in_world_.markers) MoveInto(options_.world->world_from_camera, marker);
  publisher.Publish(options_.frames == PublishedFrames::kCamera ? message : in_world_);
  if (options_.frames == PublishedFrames::kBoth) publisher.PublishInCamera(message);
}

FrameHeader FramePublisher::HeaderOf(const PosesMessage& message, const Clock& clock) const {
  FrameHeader header = message;
  header.published_utc = clock.utc();
  header.published_monotonic = clock.monotonic();
  header.frame = FrameName(options_.world.has_value());
  return header;
}

void FramePublisher::Collect(std::span<const MarkerPose> markers) {
  followed_.clear();
  for (const RobotPose& robot : robots_.robots) followed_.push_back(ToTrack(robot));
  if (finder_) return;
  for (const MarkerPose& marker : markers)
    if (marker.id && marker.has_pose)
      followed_.push_back(
          {{"", marker.family, *marker.id}, marker.camera_from_marker, marker.covariance, marker.print_covariance});
}

void FramePublisher::Follow(const FrameHeader& header, const Clock& clock) {
  tracker_->Update(followed_, header.captured_monotonic);
  tracks_.header = header;
  tracks_.valid_utc = header.captured_utc;
  tracks_.valid_monotonic = header.captured_monotonic;
  if (options_.track_time == TrackTime::kPublish) {
    // Behind the filter's work, so that it holds when it leaves.
    tracks_.header.published_utc = tracks_.valid_utc = clock.utc();
    tracks_.header.published_monotonic = tracks_.valid_monotonic = clock.monotonic();
  }
  tracker_->Tracks(tracks_.valid_monotonic, tracks_.tracks);
}

std::vector<NamedCount> FramePublisher::TakeCounts() {
  std::vector<NamedCount> counts;
  if (finder_ && options_.ignore_others) counts.push_back({"outside_roster", std::exchange(outside_roster_, 0)});
  if (finder_) counts.push_back({"robots", std::exchange(robot_count_, 0)});
  if (finder_ && options_.floor_mode) counts.push_back({"off_floor", std::exchange(off_floor_, 0)});
  if (tracker_) counts.push_back({"tracks", std::exchange(track_count_, 0)});
  return counts;
}

}  // namespace chequer
