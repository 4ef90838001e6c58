#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "chequer/check.h"
#include "robot/robot_finder.h"

// Any text: a roster that a finder takes, or a std::runtime_error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::array families{
      chequer::MarkerFamily{chequer::MarkerCode({6, 6}, chequer::Variant::kSecded), 0.12, {}}};
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    chequer::RobotFinderOptions options;
    options.roster = chequer::ParseRobotRoster(text, "robots.toml", families);
    const chequer::RobotFinder finder(options);
    for (const chequer::RosterRobot& robot : options.roster.robots)
      CHEQUER_CHECK(!robot.markers.empty() && robot.markers.size() <= 2, "a robot has one or two markers");
  } catch (const std::runtime_error&) {
    // What a bad file must give.
  }
  return 0;
}
