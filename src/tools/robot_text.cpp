#include "tools/robot_text.h"

#include <fmt/format.h>

#include <utility>

#include "core/printable.h"
#include "tools/message_json.h"
#include "tools/message_text.h"

namespace chequer {
namespace {

template <typename Vector>
Json Numbers(const Vector& vector) {
  Json numbers = Json::array();
  for (Eigen::Index i = 0; i < vector.size(); ++i) numbers.push_back(vector(i));
  return numbers;
}

Json Orientation(const RigidTransform& pose) {
  const Eigen::Quaterniond q = Canonical(pose.rotation);
  return {q.w(), q.x(), q.y(), q.z()};
}

Json HeaderJson(const char* type, const std::string& channel, const FrameHeader& header) {
  return {{"type", type},
          {"channel", channel},
          {"camera", header.camera},
          {"frame", header.frame},
          {"sequence", header.sequence},
          {"captured_utc_us", Microseconds(header.captured_utc)},
          {"captured_monotonic_us", Microseconds(header.captured_monotonic)},
          {"published_utc_us", Microseconds(header.published_utc)},
          {"published_monotonic_us", Microseconds(header.published_monotonic)}};
}

Json FloorJson(const FloorPose& floor) {
  return {{"position", Numbers(floor.position)},
          {"heading", floor.heading_rad},
          {"covariance", UpperTriangle(floor.covariance)},
          {"height_error", floor.height_error_m},
          {"tilt", floor.tilt_rad},
          {"chi_square", floor.chi_square},
          {"off_floor", floor.off_floor}};
}

Json RobotJson(const RobotPose& robot) {
  Json json{{"name", robot.name}, {"marker_ids", Json::array()}, {"family", robot.family}};
  for (int i = 0; i < robot.marker_count; ++i) json["marker_ids"].push_back(robot.ids[static_cast<std::size_t>(i)]);
  json["position"] = Numbers(robot.frame_from_body.translation);
  json["orientation"] = Orientation(robot.frame_from_body);
  json["heading"] = HeadingRad(robot.frame_from_body.rotation);
  json["covariance"] = UpperTriangle(robot.covariance);
  json["ambiguity"] = robot.ambiguity;
  if (robot.floor) json["floor"] = FloorJson(*robot.floor);
  return json;
}

Json TrackJson(const TrackState& track) {
  return {{"name", track.key.robot},
          {"marker_id", track.key.id},
          {"family", track.key.family},
          {"position", Numbers(track.frame_from_body.translation)},
          {"orientation", Orientation(track.frame_from_body)},
          {"heading", HeadingRad(track.frame_from_body.rotation)},
          {"velocity", Numbers(track.velocity)},
          {"angular_velocity", Numbers(track.angular_velocity)},
          {"pose_covariance", UpperTriangle(track.covariance.topLeftCorner<6, 6>())},
          {"velocity_covariance", UpperTriangle(track.covariance.bottomRightCorner<6, 6>())},
          {"age_us", track.age.count()},
          {"since_seen_us", track.since_seen.count()},
          {"coasting", track.coasting},
          {"poses_used", track.poses_used},
          {"poses_refused", track.poses_refused}};
}

std::string CsvFrame(const std::string& channel, const FrameHeader& header) {
  return fmt::format("{},{},{},{},{},{},{}", CsvField(channel), CsvField(header.camera), CsvField(header.frame),
                     header.sequence, Microseconds(header.captured_utc), Microseconds(header.captured_monotonic),
                     Microseconds(header.published_utc));
}

constexpr const char* kFrameColumns =
    "channel,camera,frame,sequence,captured_utc_us,captured_monotonic_us,published_utc_us";
constexpr const char* kPoseColumns = "x_m,y_m,z_m,qw,qx,qy,qz,heading_deg";

std::string CsvBody(const RigidTransform& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond q = Canonical(pose.rotation);
  return fmt::format("{},{},{},{},{},{},{},{}", PlainZero(t.x()), PlainZero(t.y()), PlainZero(t.z()), PlainZero(q.w()),
                     PlainZero(q.x()), PlainZero(q.y()), PlainZero(q.z()),
                     FixedText(HeadingRad(pose.rotation) * kDegreesPerRadian, 4));
}

std::string CsvFloor(const std::optional<FloorPose>& floor) {
  if (!floor) return ",,,,,,";
  return fmt::format("{},{},{},{},{},{},{}", PlainZero(floor->position.x()), PlainZero(floor->position.y()),
                     FixedText(floor->heading_rad * kDegreesPerRadian, 4), PlainZero(floor->height_error_m),
                     FixedText(floor->tilt_rad * kDegreesPerRadian, 3), FixedText(floor->chi_square, 1),
                     floor->off_floor ? 1 : 0);
}

std::string PlaceText(const Eigen::Vector3d& place_m) {
  return fmt::format("({}, {}, {})", FixedText(place_m.x(), 4), FixedText(place_m.y(), 4), FixedText(place_m.z(), 4));
}

/// Who a track is for people: its name, else its id.
std::string NameOf(const TrackKey& key) { return key.robot.empty() ? std::to_string(key.id) : Printable(key.robot); }

}  // namespace

std::string JsonLine(const std::string& channel, const RobotsMessage& message) {
  Json json = HeaderJson("robots", channel, message.header);
  json["robots"] = Json::array();
  for (const RobotPose& robot : message.robots) json["robots"].push_back(RobotJson(robot));
  return Dump(std::move(json));
}

std::string JsonLine(const std::string& channel, const TracksMessage& message) {
  Json json = HeaderJson("tracks", channel, message.header);
  json["valid_utc_us"] = Microseconds(message.valid_utc);
  json["valid_monotonic_us"] = Microseconds(message.valid_monotonic);
  json["tracks"] = Json::array();
  for (const TrackState& track : message.tracks) json["tracks"].push_back(TrackJson(track));
  return Dump(std::move(json));
}

std::string PlainLine(const RobotsMessage& message) {
  std::string text = fmt::format("{} frame {}: {} robot{}", Printable(message.header.camera), message.header.sequence,
                                 message.robots.size(), message.robots.size() == 1 ? "" : "s");
  for (const RobotPose& robot : message.robots) {
    const Eigen::Vector3d& t = robot.frame_from_body.translation;
    const bool on_floor = robot.floor && !robot.floor->off_floor;
    const double heading = on_floor ? robot.floor->heading_rad : HeadingRad(robot.frame_from_body.rotation);
    if (on_floor)
      text += fmt::format("  {} ({}, {}) m {} deg", Printable(robot.name), FixedText(robot.floor->position.x(), 4),
                          FixedText(robot.floor->position.y(), 4), FixedText(heading * kDegreesPerRadian, 2));
    else
      text += fmt::format("  {} {} m {} deg{}", Printable(robot.name), PlaceText(t),
                          FixedText(heading * kDegreesPerRadian, 2), robot.floor ? " off the floor" : "");
  }
  return text;
}

std::string PlainLine(const TracksMessage& message) {
  std::string text = fmt::format("{} frame {}: {} track{}", Printable(message.header.camera), message.header.sequence,
                                 message.tracks.size(), message.tracks.size() == 1 ? "" : "s");
  for (const TrackState& track : message.tracks) {
    const Eigen::Vector3d& t = track.frame_from_body.translation;
    text +=
        fmt::format("  {} {} m {} deg {:.3f} m/s {} deg/s{}", NameOf(track.key), PlaceText(t),
                    FixedText(HeadingRad(track.frame_from_body.rotation) * kDegreesPerRadian, 2), track.velocity.norm(),
                    FixedText(track.angular_velocity.z() * kDegreesPerRadian, 1), track.coasting ? " coasting" : "");
  }
  return text;
}

std::string RobotsCsvHeader() {
  return fmt::format(
      "{},name,marker_id,{},ambiguity,floor_x_m,floor_y_m,floor_heading_deg,height_error_m,tilt_deg,chi_square,"
      "off_floor\n",
      kFrameColumns, kPoseColumns);
}

std::string CsvRows(const std::string& channel, const RobotsMessage& message) {
  const std::string frame = CsvFrame(channel, message.header);
  if (message.robots.empty()) return frame + std::string(18, ',') + "\n";
  std::string rows;
  for (const RobotPose& robot : message.robots)
    rows += fmt::format("{},{},{},{},{},{}\n", frame, CsvField(robot.name), robot.ids[0],
                        CsvBody(robot.frame_from_body), robot.ambiguity, CsvFloor(robot.floor));
  return rows;
}

std::string TracksCsvHeader() {
  return fmt::format(
      "{},valid_utc_us,valid_monotonic_us,name,marker_id,{},vx_m_s,vy_m_s,vz_m_s,yaw_rate_deg_s,age_us,"
      "since_seen_us,coasting,poses_used,poses_refused\n",
      kFrameColumns, kPoseColumns);
}

std::string CsvRows(const std::string& channel, const TracksMessage& message) {
  const std::string frame = fmt::format("{},{},{}", CsvFrame(channel, message.header), Microseconds(message.valid_utc),
                                        Microseconds(message.valid_monotonic));
  if (message.tracks.empty()) return frame + std::string(19, ',') + "\n";
  std::string rows;
  for (const TrackState& track : message.tracks)
    rows += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", frame, CsvField(track.key.robot), track.key.id,
                        CsvBody(track.frame_from_body), PlainZero(track.velocity.x()), PlainZero(track.velocity.y()),
                        PlainZero(track.velocity.z()), FixedText(track.angular_velocity.z() * kDegreesPerRadian, 4),
                        track.age.count(), track.since_seen.count(), track.coasting ? 1 : 0, track.poses_used,
                        track.poses_refused);
  return rows;
}

}  // namespace chequer
