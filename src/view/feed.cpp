#include "view/feed.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "publish/channels.h"
#include "view/page_message.h"

namespace chequer {

std::optional<std::size_t> Feed::CameraOf(std::string_view channel, std::string_view suffix) {
  if (!channel.ends_with(suffix)) return std::nullopt;
  const std::string_view prefix = channel.substr(0, channel.size() - suffix.size());
  if (!IsValidPrefix(prefix)) return std::nullopt;
  const auto found =
      std::find_if(cameras_.begin(), cameras_.end(), [&](const Camera& camera) { return camera.prefix == prefix; });
  if (found != cameras_.end()) return static_cast<std::size_t>(found - cameras_.begin());
  if (cameras_.size() == kMostCameras) return std::nullopt;
  Camera& camera = cameras_.emplace_back();
  camera.prefix = prefix;
  camera.name = prefix.starts_with("CHEQUER_") ? prefix.substr(8) : prefix;
  ++list_version_;
  return cameras_.size() - 1;
}

std::optional<std::size_t> Feed::CameraOf(std::string_view channel) {
  for (const auto suffix : {kPosesSuffix, kStatusSuffix, kRobotsSuffix, kTracksSuffix, kPreviewSuffix, kDetailSuffix,
                            kCameraSuffix, kSetupSuffix})
    if (channel.ends_with(suffix)) return CameraOf(channel, suffix);
  return std::nullopt;
}

void Feed::Take(const std::string& channel, std::span<const std::uint8_t> bytes) {
  const bool is_status = channel.ends_with(kStatusSuffix);
  if (!watched_ && !is_status) return;
  // Poses once more in the camera's frame, beside those in the world, are of no use here.
  if (channel.ends_with(kCameraSuffix) && !IsViewMessage(bytes)) return;
  if (IsViewMessage(bytes)) {
    const auto message = DecodeViewMessage(bytes);
    const auto camera = message ? CameraOf(channel) : std::nullopt;
    if (!message) ++unreadable_;
    if (!camera) return;
    const auto index = static_cast<std::uint16_t>(*camera);
    if (const auto* preview = std::get_if<PreviewMessage>(&*message)) TakePreview(*camera, *preview);
    if (const auto* detail = std::get_if<DetailMessage>(&*message))
      Show(*camera, TopicKind::kDetail, DetailPacket(*detail, index));
    if (const auto* about = std::get_if<CameraMessage>(&*message)) {
      cameras_[*camera].about = *about;
      Show(*camera, TopicKind::kCamera, CameraPacket(*about, index));
    }
    if (const auto* calibration = std::get_if<CalibrationMessage>(&*message))
      Show(*camera, TopicKind::kCalibration, CalibrationPacket(*calibration, index));
    return;
  }
  const auto message = DecodeMessage(bytes);
  if (!message) ++unreadable_;
  const auto camera = message ? CameraOf(channel) : std::nullopt;
  if (!camera) return;
  const auto index = static_cast<std::uint16_t>(*camera);
  if (const auto* poses = std::get_if<PosesMessage>(&*message)) TakePoses(*camera, *poses);
  if (const auto* status = std::get_if<StatusMessage>(&*message)) TakeStatus(*camera, *status);
  if (const auto* robots = std::get_if<RobotsMessage>(&*message))
    Show(*camera, TopicKind::kRobots, RobotsPacket(*robots, index));
  if (const auto* tracks = std::get_if<TracksMessage>(&*message))
    Show(*camera, TopicKind::kTracks, TracksPacket(*tracks, index));
}

void Feed::Show(std::size_t camera, TopicKind kind, SharedPacket packet) {
  Topic& topic = cameras_[camera].topics[static_cast<std::size_t>(kind)];
  topic.packet = std::move(packet);
  topic.version = ++versions_;
}

void Feed::TakePoses(std::size_t index, const PosesMessage& message) {
  Camera& camera = cameras_[index];
  SharedPacket packet =
      FramePacket(message, camera.about ? &*camera.about : nullptr, static_cast<std::uint16_t>(index));
  // A daemon that was started anew counts from the beginning: what is kept is another's.
  if (!camera.frames.empty() && message.sequence <= camera.frames.back().first) {
    camera.frames.clear();
    camera.early.reset();
  }
  camera.frames.emplace_back(message.sequence, packet);
  if (camera.frames.size() > kFramesKept) camera.frames.pop_front();
  Show(index, TopicKind::kFrame, std::move(packet));
  if (!camera.early || camera.early->sequence > message.sequence) return;
  const PreviewMessage early = *std::exchange(camera.early, std::nullopt);
  TakePreview(index, early);
}

void Feed::TakeStatus(std::size_t index, const StatusMessage& message) {
  Camera& camera = cameras_[index];
  if (!message.camera.empty() && camera.name != message.camera) {
    camera.name = message.camera;
    ++list_version_;
  }
  camera.history.push_back(EntryOf(message, camera.dropped));
  camera.dropped = message.frames_dropped;
  if (camera.history.size() > kHistoryKept) camera.history.pop_front();
  Show(index, TopicKind::kStatus, StatusPacket(message, static_cast<std::uint16_t>(index)));
  Show(index, TopicKind::kHistory, nullptr);
}

SharedPacket Feed::PacketOf(std::size_t index, TopicKind kind) {
  Camera& camera = cameras_[index];
  SharedPacket& packet = camera.topics[static_cast<std::size_t>(kind)].packet;
  if (kind == TopicKind::kHistory && !packet) packet = HistoryPacket(camera.history, static_cast<std::uint16_t>(index));
  return packet;
}

void Feed::TakePreview(std::size_t index, const PreviewMessage& message) {
  Camera& camera = cameras_[index];
  const bool whole =
      message.region == PixelRegion{0, 0, message.image_width & ~1, message.image_height & ~1} ||
      (message.region.width >= message.image_width - 1 && message.region.height >= message.image_height - 1);
  // What another program asked for is shown where it is the whole frame.
  if (!whole && message.asker != asker_ + 1 && asker_ != 0) return;
  SharedPacket frame;
  for (const auto& [sequence, packet] : camera.frames)
    if (sequence == message.sequence) frame = packet;
  // On a busy computer a preview may overtake its poses, which go another way.
  if (!frame && !camera.frames.empty() && message.sequence > camera.frames.back().first) {
    camera.early = message;
    return;
  }
  const TopicKind kind = whole ? TopicKind::kPicture : TopicKind::kZoom;
  Show(index, kind, PicturePacket(kind, message, frame, static_cast<std::uint16_t>(index)));
}

void Feed::Rewind() {
  for (Camera& camera : cameras_) {
    camera.frames.clear();
    camera.early.reset();
    camera.history.clear();
    camera.dropped = 0;
    for (Topic& topic : camera.topics) topic.packet.reset();
  }
}

std::vector<ServerState::Camera> Feed::CameraList() const {
  std::vector<ServerState::Camera> list;
  for (const Camera& camera : cameras_) list.push_back({camera.prefix, camera.name});
  return list;
}

}  // namespace chequer
