#include "view/page_message.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "core/robot_pose.h"
#include "view/page_time.h"

static_assert(std::endian::native == std::endian::little, "pages read little-endian numbers");

namespace chequer {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// What is nearer than that to the camera's plane is not drawn.
constexpr double kLeastDepthM = 1e-3;

/// Places in a header, bytes.
enum At : std::size_t {
  kAtKind = 0,
  kAtWorld = 1,  ///< whether places are in the world
  kAtCamera = 2,
  kAtCount = 4,
  kAtSequence = 8,
  kAtCaptured = 16,  ///< ms of UTC, 64-bit float, as the next
  kAtPublished = 24,
  kAtDropped = 32,
  kAtWidth = 40,
  kAtHeight = 44,
  kAtLatency = 48,  ///< ms
  kAtNames = 56,    ///< where names begin, bytes
};
/// Of a picture, behind the camera's number.
enum PictureAt : std::size_t {
  kAtFrameBytes = 4,
  kAtRegion = 32,  ///< four 16-bit numbers
  kAtSize = 48,    ///< of the picture, two 16-bit numbers
};

template <typename Value>
void Put(std::vector<std::uint8_t>& bytes, std::size_t at, Value value) {
  static_assert(std::is_arithmetic_v<Value>);
  std::memcpy(bytes.data() + Packet::kHeadroom + at, &value, sizeof value);
}

SharedPacket Begin(TopicKind kind, std::uint16_t index, std::size_t bytes) {
  auto packet = std::make_shared<Packet>();
  packet->storage().resize(Packet::kHeadroom + bytes);
  Put(packet->storage(), kAtKind, static_cast<std::uint8_t>(kind));
  Put(packet->storage(), kAtCamera, index);
  return packet;
}

void PutHeader(const FrameHeader& header, std::size_t count, std::vector<std::uint8_t>& bytes) {
  Put(bytes, kAtCount, static_cast<std::uint32_t>(count));
  Put(bytes, kAtSequence, static_cast<double>(header.sequence));
  Put(bytes, kAtCaptured, Milliseconds(header.captured_utc));
  Put(bytes, kAtPublished, Milliseconds(header.published_utc));
  Put(bytes, kAtLatency,
      static_cast<float>(Milliseconds(header.published_monotonic) - Milliseconds(header.captured_monotonic)));
}

/// A record of 32-bit words.
class Record {
 public:
  explicit Record(std::uint8_t* bytes) : bytes_(bytes) {}
  void Float(std::size_t word, double value) {
    const auto number = static_cast<float>(value);
    std::memcpy(bytes_ + 4 * word, &number, sizeof number);
  }
  void Word(std::size_t word, std::uint32_t value) { std::memcpy(bytes_ + 4 * word, &value, sizeof value); }
  void Point(std::size_t word, const Eigen::Vector2d& point) {
    Float(word, point.x());
    Float(word + 1, point.y());
  }

 private:
  std::uint8_t* bytes_;
};

void PutId(std::uint64_t id, Record& record) {
  record.Word(0, static_cast<std::uint32_t>(id));
  record.Word(1, static_cast<std::uint32_t>(id >> 32));
}

/// Semi-axes and direction of the ellipse of one standard deviation.
struct Ellipse {
  double major = 0, minor = 0, angle = 0;
};

Ellipse EllipseOf(const Eigen::Matrix2d& covariance) {
  const double mean = covariance.trace() / 2, half = (covariance(0, 0) - covariance(1, 1)) / 2;
  const double spread = std::hypot(half, covariance(0, 1));
  return {std::sqrt(std::max(0.0, mean + spread)), std::sqrt(std::max(0.0, mean - spread)),
          std::atan2(covariance(0, 1), half) / 2};
}

/// Of the marker's middle, in the image.
Ellipse EllipseInImage(const Eigen::Vector3d& x_in_camera, const Eigen::Matrix3d& covariance,
                       const CameraModel& model) {
  const double depth = x_in_camera.z();
  Eigen::Matrix2d lens;
  model.Distort(x_in_camera.head<2>() / depth, &lens);
  Eigen::Matrix<double, 2, 3> perspective;
  perspective << 1 / depth, 0, -x_in_camera.x() / (depth * depth), 0, 1 / depth, -x_in_camera.y() / (depth * depth);
  const Eigen::Matrix<double, 2, 3> jacobian = lens * perspective;
  return EllipseOf(jacobian * covariance * jacobian.transpose());
}

/// Turns poses between the frames of reference of a message, its camera and the world.
struct Places {
  bool in_world = false;  ///< the message is
  const CameraMessage* camera = nullptr;

  std::optional<RigidTransform> camera_from_frame() const {
    if (!in_world) return RigidTransform{};
    if (camera == nullptr || !camera->world_from_camera) return std::nullopt;
    return camera->world_from_camera->Inverse();
  }
  /// The best there is: the world where it is known, else the camera.
  std::optional<RigidTransform> world_from_frame() const {
    if (in_world) return RigidTransform{};
    if (camera == nullptr || !camera->world_from_camera) return std::nullopt;
    return camera->world_from_camera;
  }
};

void PutDrawing(const MarkerPose& marker, const Places& places, Record& record) {
  for (std::size_t word = 8; word < 22; ++word) record.Word(word, std::bit_cast<std::uint32_t>(kUnknown));
  for (std::size_t word = 32; word < 35; ++word) record.Word(word, std::bit_cast<std::uint32_t>(kUnknown));
  const auto camera_from_frame = places.camera_from_frame();
  if (!marker.has_pose || !camera_from_frame || places.camera == nullptr || !places.camera->model) return;
  const RigidTransform camera_from_marker = *camera_from_frame * marker.camera_from_marker;
  const auto drawing = DrawMarker(marker, camera_from_marker, *places.camera);
  if (!drawing) return;
  for (std::size_t i = 0; i < 4; ++i) record.Point(8 + 2 * i, drawing->outline[i]);
  for (std::size_t i = 0; i < 3; ++i) record.Point(16 + 2 * i, drawing->axes[i]);
  const Eigen::Matrix3d turn = camera_from_frame->rotation.toRotationMatrix();
  const Ellipse ellipse =
      EllipseInImage(camera_from_marker.translation, turn * marker.covariance.topLeftCorner<3, 3>() * turn.transpose(),
                     *places.camera->model);
  record.Float(32, ellipse.major);
  record.Float(33, ellipse.minor);
  record.Float(34, ellipse.angle);
  record.Float(35, camera_from_marker.translation.norm());
}

void PutPlace(const MarkerPose& marker, const Places& places, Record& record) {
  for (std::size_t word = 26; word < 32; ++word) record.Word(word, std::bit_cast<std::uint32_t>(kUnknown));
  if (!marker.has_pose) return;
  const RigidTransform pose = places.world_from_frame().value_or(RigidTransform{}) * marker.camera_from_marker;
  for (int axis = 0; axis < 3; ++axis) record.Float(26 + static_cast<std::size_t>(axis), pose.translation(axis));
  record.Float(29, HeadingRad(pose.rotation));
  record.Float(30, std::sqrt(std::max(0.0, marker.covariance.topLeftCorner<3, 3>().trace())));
  record.Float(31, std::sqrt(std::max(0.0, marker.covariance.bottomRightCorner<3, 3>().trace())));
}

void PutMarker(const MarkerPose& marker, const Places& places, Record record) {
  PutId(marker.id.value_or(0), record);
  record.Word(2, (marker.id ? 1u : 0u) | (marker.has_pose ? 2u : 0u) | static_cast<std::uint32_t>(marker.family) << 8 |
                     static_cast<std::uint32_t>(marker.variant) << 16);
  record.Word(3, marker.warnings);
  record.Word(4, static_cast<std::uint32_t>(marker.size.rows) | static_cast<std::uint32_t>(marker.size.cols) << 8 |
                     static_cast<std::uint32_t>(marker.corners_used) << 16);
  record.Word(5, static_cast<std::uint32_t>(marker.bits_corrected));
  record.Point(6, marker.center_px);
  record.Float(22, marker.reprojection_rms_px);
  record.Float(23, marker.luminance_overlap);
  record.Float(24, marker.saturation_overlap);
  record.Float(25, marker.has_pose ? marker.ambiguity : std::nan(""));
  PutDrawing(marker, places, record);
  PutPlace(marker, places, record);
}

/// Puts names behind the records, as a JSON array.
void PutNames(const nlohmann::json& names, Packet& packet) {
  const std::string text = names.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  Put(packet.storage(), kAtNames, static_cast<std::uint32_t>(packet.size()));
  packet.storage().insert(packet.storage().end(), text.begin(), text.end());
}

void PutBodyPlace(const RigidTransform& pose, const Matrix6d& covariance, Record& record) {
  for (int axis = 0; axis < 3; ++axis) record.Float(4 + static_cast<std::size_t>(axis), pose.translation(axis));
  record.Float(7, HeadingRad(pose.rotation));
  const Ellipse ellipse = EllipseOf(covariance.topLeftCorner<2, 2>());
  record.Float(12, ellipse.major);
  record.Float(13, ellipse.minor);
  record.Float(14, ellipse.angle);
}

}  // namespace

std::optional<MarkerDrawing> DrawMarker(const MarkerPose& marker, const RigidTransform& camera_from_marker,
                                        const CameraMessage& camera) {
  const auto family = static_cast<std::size_t>(marker.family);
  if (!camera.model || family >= camera.families.size()) return std::nullopt;
  const double cell = camera.families[family].side_m / std::max(marker.size.rows, marker.size.cols);
  const double x = cell * marker.size.cols / 2, y = cell * marker.size.rows / 2;
  if (!(x > 0)) return std::nullopt;
  const std::array<Eigen::Vector3d, 7> points{
      {{-x, y, 0}, {x, y, 0}, {x, -y, 0}, {-x, -y, 0}, {x, 0, 0}, {0, y, 0}, {0, 0, x}}};
  std::array<Eigen::Vector2d, 7> pixels;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d x_in_camera = camera_from_marker * points[i];
    if (!(x_in_camera.z() > kLeastDepthM)) return std::nullopt;
    pixels[i] = camera.model->Project(x_in_camera);
  }
  MarkerDrawing drawing;
  std::copy_n(pixels.begin(), 4, drawing.outline.begin());
  std::copy_n(pixels.begin() + 4, 3, drawing.axes.begin());
  return drawing;
}

SharedPacket FramePacket(const PosesMessage& message, const CameraMessage* camera, std::uint16_t index) {
  const std::size_t count = message.markers.size();
  auto packet = Begin(TopicKind::kFrame, index, kPageHeaderBytes + 4 * kMarkerWords * count);
  std::vector<std::uint8_t>& bytes = packet->storage();
  PutHeader(message, count, bytes);
  const Places places{message.frame == "world", camera};
  Put(bytes, kAtWorld, static_cast<std::uint8_t>(places.world_from_frame() ? 1 : 0));
  Put(bytes, kAtDropped, static_cast<double>(message.frames_dropped));
  Put(bytes, kAtWidth, static_cast<std::uint32_t>(message.image_width));
  Put(bytes, kAtHeight, static_cast<std::uint32_t>(message.image_height));
  for (std::size_t i = 0; i < count; ++i)
    PutMarker(message.markers[i], places, Record(packet->data() + kPageHeaderBytes + 4 * kMarkerWords * i));
  return packet;
}

SharedPacket RobotsPacket(const RobotsMessage& message, std::uint16_t index) {
  const std::size_t count = message.robots.size();
  auto packet = Begin(TopicKind::kRobots, index, kPageHeaderBytes + 4 * kBodyWords * count);
  PutHeader(message.header, count, packet->storage());
  Put(packet->storage(), kAtWorld, static_cast<std::uint8_t>(message.header.frame == "world"));
  nlohmann::json names = nlohmann::json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const RobotPose& robot = message.robots[i];
    Record record(packet->data() + kPageHeaderBytes + 4 * kBodyWords * i);
    PutId(robot.ids[0], record);
    const bool off_floor = robot.floor && robot.floor->off_floor;
    record.Word(2, (off_floor ? 2u : 0u) | static_cast<std::uint32_t>(robot.family) << 8);
    RigidTransform pose = robot.frame_from_body;
    PutBodyPlace(pose, robot.covariance, record);
    if (robot.floor && !off_floor) {
      record.Point(4, robot.floor->position);
      record.Float(7, robot.floor->heading_rad);
    }
    for (std::size_t word = 8; word < 12; ++word) record.Word(word, std::bit_cast<std::uint32_t>(kUnknown));
    names.push_back(robot.name);
  }
  PutNames(names, *packet);
  return packet;
}

SharedPacket TracksPacket(const TracksMessage& message, std::uint16_t index) {
  const std::size_t count = message.tracks.size();
  auto packet = Begin(TopicKind::kTracks, index, kPageHeaderBytes + 4 * kBodyWords * count);
  PutHeader(message.header, count, packet->storage());
  Put(packet->storage(), kAtWorld, static_cast<std::uint8_t>(message.header.frame == "world"));
  nlohmann::json names = nlohmann::json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const TrackState& track = message.tracks[i];
    Record record(packet->data() + kPageHeaderBytes + 4 * kBodyWords * i);
    PutId(track.key.id, record);
    record.Word(2, (track.coasting ? 1u : 0u) | static_cast<std::uint32_t>(track.key.family) << 8);
    PutBodyPlace(track.frame_from_body, track.covariance.topLeftCorner<6, 6>(), record);
    for (int axis = 0; axis < 3; ++axis) record.Float(8 + static_cast<std::size_t>(axis), track.velocity(axis));
    record.Float(11, track.angular_velocity.z());
    record.Float(15, std::chrono::duration<double>(track.since_seen).count());
    names.push_back(track.key.robot);
  }
  PutNames(names, *packet);
  return packet;
}

SharedPacket PicturePacket(TopicKind kind, const PreviewMessage& message, const SharedPacket& frame,
                           std::uint16_t index) {
  const std::size_t frame_bytes = frame ? frame->size() : 0;
  auto packet = Begin(kind, index, kPageHeaderBytes + frame_bytes + message.jpeg.size());
  std::vector<std::uint8_t>& bytes = packet->storage();
  Put(bytes, kAtFrameBytes, static_cast<std::uint32_t>(frame_bytes));
  Put(bytes, kAtSequence, static_cast<double>(message.sequence));
  Put(bytes, kAtCaptured, Milliseconds(message.captured_utc));
  const int numbers[] = {message.region.x, message.region.y, message.region.width, message.region.height};
  for (std::size_t i = 0; i < 4; ++i) Put(bytes, kAtRegion + 2 * i, static_cast<std::uint16_t>(numbers[i]));
  Put(bytes, kAtWidth, static_cast<std::uint32_t>(message.image_width));
  Put(bytes, kAtHeight, static_cast<std::uint32_t>(message.image_height));
  Put(bytes, kAtSize, static_cast<std::uint16_t>(message.width));
  Put(bytes, kAtSize + 2, static_cast<std::uint16_t>(message.height));
  std::uint8_t* out = packet->data() + kPageHeaderBytes;
  if (frame) std::memcpy(out, frame->data(), frame_bytes);
  if (!message.jpeg.empty()) std::memcpy(out + frame_bytes, message.jpeg.data(), message.jpeg.size());
  return packet;
}

}  // namespace chequer
