#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "publish/messages.h"
#include "publish/view_messages.h"
#include "view/topics.h"

// What moves, as the page reads it: little-endian, a header of 64 bytes, then records of 32-bit floats (and some 32-bit
// integers) that become typed arrays without copying. page/decode.js has the same numbers.

namespace chequer {

inline constexpr std::size_t kPageHeaderBytes = 64;
inline constexpr std::size_t kMarkerWords = 36;
inline constexpr std::size_t kBodyWords = 16;

/// A frame's markers. Outlines and axes need the camera: they are NaN without it.
/// @param camera what is known of it; may be null. @param index of the camera on the page.
SharedPacket FramePacket(const PosesMessage& message, const CameraMessage* camera, std::uint16_t index);
SharedPacket RobotsPacket(const RobotsMessage& message, std::uint16_t index);
SharedPacket TracksPacket(const TracksMessage& message, std::uint16_t index);

/// A picture, and with it the markers of its frame if they are known: they lie on it exactly, however late it comes.
/// @param frame of FramePacket; may be null.
SharedPacket PicturePacket(TopicKind kind, const PreviewMessage& message, const SharedPacket& frame,
                           std::uint16_t index);

/// The marker's outline, clockwise from its top left, and the ends of its axes x, y, z, half a side long. Pixels.
struct MarkerDrawing {
  std::array<Eigen::Vector2d, 4> outline = Zeros<Eigen::Vector2d, 4>();
  std::array<Eigen::Vector2d, 3> axes = Zeros<Eigen::Vector2d, 3>();
};
/// Nothing where the marker has no pose, its family is not known, or a part of it lies behind the camera.
std::optional<MarkerDrawing> DrawMarker(const MarkerPose& marker, const RigidTransform& camera_from_marker,
                                        const CameraMessage& camera);

}  // namespace chequer
