#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "chequer/frame.h"
#include "publish/wire.h"
#include "publish/wire_view.h"
#include "view/page_json.h"
#include "view/topics.h"

namespace chequer {

/// What pages are shown, made from LCM's messages: of each camera and kind the newest, and what a picture needs of the
/// frames before. Its memory is bounded whatever comes. One thread.
class Feed {
 public:
  static constexpr std::size_t kMostCameras = 32;

  /// @param asker numbers of this program's requests: `asker` of whole frames, `asker + 1` of parts.
  explicit Feed(std::int64_t asker) : asker_(asker) {}

  /// A message came. What nobody watches (set_watched) is passed over, but for the statuses, of which a history is
  /// kept.
  void Take(const std::string& channel, std::span<const std::uint8_t> bytes);
  void set_watched(bool watched) { watched_ = watched; }
  bool watched() const { return watched_; }
  /// Forgets all but the cameras and their numbers: a replay goes on elsewhere.
  void Rewind();

  std::size_t cameras() const { return cameras_.size(); }
  const std::string& prefix(std::size_t camera) const { return cameras_[camera].prefix; }
  std::vector<ServerState::Camera> CameraList() const;
  /// Rises when a camera was found or named anew.
  std::uint64_t list_version() const { return list_version_; }
  const Topic& topic(std::size_t camera, TopicKind kind) const {
    return cameras_[camera].topics[static_cast<std::size_t>(kind)];
  }
  /// Its packet: made now where it is the history, which few ask for. Null where there is none.
  SharedPacket PacketOf(std::size_t camera, TopicKind kind);
  /// Messages that were damaged or of another version.
  std::uint64_t unreadable() const { return unreadable_; }

 private:
  /// A preview comes some frames after its frame: three seconds of them at 20 a second.
  static constexpr std::size_t kFramesKept = 60;
  static constexpr std::size_t kHistoryKept = 600;

  struct Camera {
    std::string prefix;
    std::string name;
    std::optional<CameraMessage> about;
    std::array<Topic, kTopicKinds> topics;
    std::deque<std::pair<std::uint64_t, SharedPacket>> frames;  ///< by sequence
    std::optional<PreviewMessage> early;  ///< a preview that came before the markers of its frame
    std::deque<HistoryEntry> history;
    std::uint64_t dropped = 0;
  };

  /// The camera of a channel with that suffix; nothing where there are too many.
  std::optional<std::size_t> CameraOf(std::string_view channel, std::string_view suffix);
  std::optional<std::size_t> CameraOf(std::string_view channel);
  void Show(std::size_t camera, TopicKind kind, SharedPacket packet);
  void TakePoses(std::size_t camera, const PosesMessage& message);
  void TakeStatus(std::size_t camera, const StatusMessage& message);
  void TakePreview(std::size_t camera, const PreviewMessage& message);

  std::int64_t asker_;
  bool watched_ = false;
  std::vector<Camera> cameras_;
  std::uint64_t list_version_ = 1;
  std::uint64_t versions_ = 0;
  std::uint64_t unreadable_ = 0;
};

}  // namespace chequer
