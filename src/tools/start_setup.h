#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace chequer {

/// What somebody who begins has to say.
struct StartAnswers {
  std::string name = "north";          ///< of the camera
  std::filesystem::path folder = ".";  ///< where all its files are
  std::string device;                  ///< as [capture] has it; empty: the only V4L2 camera
  std::string recording;               ///< instead of a camera
  std::string side = "60mm";           ///< of the robots' markers
  std::uint64_t robots = 10;

  std::filesystem::path Config() const { return folder / (name + ".toml"); }
  std::filesystem::path File(const std::string& what) const { return folder / (name + "-" + what); }
};

/// Markers of the floor have the ids behind the robots': the corner, on the x axis, on the y axis.
inline constexpr std::uint64_t kFloorMarkers = 3;
/// The sheet for the lens: smaller markers, so that a page holds many, with the last ids, which no robot has.
inline constexpr const char* kLensSheetSide = "30mm";
inline constexpr const char* kLensSheetIds = "2028-2047";

/// The configuration of the answers; what later steps make (camera file, world, roster) stands in it as comments.
std::string StartConfiguration(const StartAnswers& answers);

/// Takes the comment sign from the line of a key in a configuration, "file" of [world] or the like, where it is still
/// there. False where nothing was to be done: somebody has edited it, or it was done before. Throws std::runtime_error
/// where the file cannot be read or written.
bool SwitchOn(const std::filesystem::path& config, const std::string& line);

/// The lines that SwitchOn takes.
std::string CalibrationLine(const StartAnswers& answers);
std::string WorldLine(const StartAnswers& answers);
std::string RobotsLine(const StartAnswers& answers);

}  // namespace chequer
