#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

namespace chequer {

// Channel names are part of what users rely on.
inline constexpr std::string_view kPosesSuffix = "_POSES";
inline constexpr std::string_view kStatusSuffix = "_STATUS";
inline constexpr std::string_view kRobotsSuffix = "_ROBOTS";
inline constexpr std::string_view kTracksSuffix = "_TRACKS";
/// Poses in the camera's frame of reference, where those of kPosesSuffix are in the world and both are wanted.
inline constexpr std::string_view kCameraSuffix = "_CAMERA";
// What is published on request alone, beside a camera_t on kCameraSuffix, and the requests.
inline constexpr std::string_view kAskSuffix = "_ASK";
inline constexpr std::string_view kPreviewSuffix = "_PREVIEW";
inline constexpr std::string_view kDetailSuffix = "_DETAIL";
/// calibration_t, of a calibration that runs; asked for on kCalibrationPrefix, as nobody knows its camera before.
inline constexpr std::string_view kSetupSuffix = "_SETUP";
inline constexpr std::string_view kCalibrationPrefix = "CHEQUER";
inline constexpr std::array kViewSuffixes{kPreviewSuffix, kDetailSuffix, kCameraSuffix, kSetupSuffix};
inline constexpr std::array kChannelSuffixes{kPosesSuffix, kStatusSuffix, kRobotsSuffix, kTracksSuffix, kCameraSuffix};

/// LCM carries channel names of at most 63 bytes.
inline constexpr std::size_t kMaxChannelLength = 63;
inline constexpr std::size_t kMaxPrefixLength = kMaxChannelLength - kStatusSuffix.size();
static_assert(std::all_of(kChannelSuffixes.begin(), kChannelSuffixes.end(),
                          [](std::string_view suffix) { return suffix.size() <= kStatusSuffix.size(); }));

/// Longest prefix of a camera that can be viewed: _PREVIEW is longer than the channels before it.
inline constexpr std::size_t kMaxViewedPrefix = kMaxChannelLength - kPreviewSuffix.size();

inline std::string ChannelName(std::string_view prefix, std::string_view suffix) {
  return std::string(prefix).append(suffix);
}
inline std::string PosesChannel(std::string_view prefix) { return ChannelName(prefix, kPosesSuffix); }
inline std::string StatusChannel(std::string_view prefix) { return ChannelName(prefix, kStatusSuffix); }

/// Whether a prefix can be part of a channel name: 1 to kMaxPrefixLength of the characters A-Z a-z 0-9 _ -.
/// (LCM allows more; these need no quoting in its regular expressions, in shells and in file names.)
bool IsValidPrefix(std::string_view prefix);

/// Longest name of a camera: its prefix has to fit.
inline constexpr std::size_t kMaxCameraName = kMaxPrefixLength - std::string_view("CHEQUER_").size();

/// Channel prefix of a camera unless another is configured: CHEQUER_<name>.
std::string DefaultPrefix(const std::string& camera_name);

/// The name of a camera whose configuration says none: that of the file ("north" of /etc/chequer/north.toml), so that
/// the instance of a service has the name of its camera; "camera" where a file's name cannot be part of a channel.
std::string CameraNameOf(const std::filesystem::path& configuration);

}  // namespace chequer
