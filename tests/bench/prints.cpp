#include "bench/prints.h"

#include <algorithm>

namespace chequer::bench {
namespace {

constexpr std::uint64_t kAprilTags = 587;
constexpr std::uint64_t kArucoTags = 1000;

Board ChequerBoard(std::uint64_t number) {
  const MarkerCode code(MarkerSize{6, 6}, Variant::kSecded);
  return MakeBoard(code, number % (code.max_id() + 1));
}

/// Cells of the whole board for each cell of the side that counts.
double Spread(const Print& print) {
  const Board board = print.board(0);
  return static_cast<double>(board.cols) / (board.cols - 2 * board.uncounted_rim);
}

}  // namespace

std::vector<Print> KnownPrints() {
  std::vector<Print> prints{{kChequerPattern, ChequerBoard}};
  if (HasAprilTag())
    prints.push_back({kAprilTagPattern, [](std::uint64_t number) { return AprilTag36h11(number % kAprilTags); }});
  if (HasAruco()) prints.push_back({kArucoPattern, [](std::uint64_t number) { return Aruco4x4(number % kArucoTags); }});
  return prints;
}

const Print& WidestRim(const std::vector<Print>& prints) {
  return *std::max_element(prints.begin(), prints.end(),
                           [](const Print& a, const Print& b) { return Spread(a) < Spread(b); });
}

}  // namespace chequer::bench
