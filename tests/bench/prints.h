#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "simulate/board.h"

namespace chequer::bench {

/// What is printed on the boards of a frame, by the name of its folder.
using Pattern = std::string;
inline constexpr char kChequerPattern[] = "secded";
inline constexpr char kAprilTagPattern[] = "tag36h11";
inline constexpr char kArucoPattern[] = "aruco4";

/// How a pattern is drawn.
struct Print {
  Pattern pattern;
  std::function<Board(std::uint64_t number)> board;  ///< the board that stands for a robot
};

/// The prints that this build can draw: its own first, then the peers' whose libraries it has.
std::vector<Print> KnownPrints();

/// The print with the widest white rim, compared with the side that counts. @pre not empty.
const Print& WidestRim(const std::vector<Print>& prints);

}  // namespace chequer::bench
