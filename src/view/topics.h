#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace chequer {

/// What a page is sent, by its first byte. Numbers are shared with page/decode.js.
enum class TopicKind : std::uint8_t {
  kServer,       ///< JSON: the cameras, how the server fares, of a replay its times
  kFrame,        ///< the markers of a frame
  kRobots,       ///< the robots of a frame
  kTracks,       ///< the tracks after a frame
  kPicture,      ///< a whole frame as JPEG, with its markers
  kZoom,         ///< a part of a frame as JPEG
  kStatus,       ///< JSON
  kHistory,      ///< JSON: statuses of the last ten minutes, sent once to each page
  kCamera,       ///< JSON: lens, place, families
  kDetail,       ///< JSON: one marker
  kCalibration,  ///< JSON: how far a calibration has come
};
inline constexpr std::size_t kTopicKinds = 11;

/// Bytes for a page, behind room for what a WebSocket puts before them.
class Packet {
 public:
  static constexpr std::size_t kHeadroom = 32;

  Packet() : bytes_(kHeadroom) {}
  std::size_t size() const { return bytes_.size() - kHeadroom; }
  const std::uint8_t* data() const { return bytes_.data() + kHeadroom; }
  /// For writing: a WebSocket's header is put into the headroom.
  std::uint8_t* data() { return bytes_.data() + kHeadroom; }
  std::vector<std::uint8_t>& storage() { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Shared by all pages that are being sent it: one copy, however many.
using SharedPacket = std::shared_ptr<Packet>;

/// The newest of one kind: what came before is gone, so a page that is slow skips.
struct Topic {
  std::uint64_t version = 0;  ///< 0: none yet
  SharedPacket packet;
};

}  // namespace chequer
