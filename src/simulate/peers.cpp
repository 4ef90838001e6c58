#include <stdexcept>
#include <string>

#include "simulate/board.h"

#ifdef CHEQUER_HAVE_APRILTAG
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <memory>
#endif
#ifdef CHEQUER_HAVE_ARUCO
#include <opencv2/aruco.hpp>
#endif

namespace chequer {
namespace {

[[noreturn, maybe_unused]] void Missing(const std::string& what, const std::string& package) {
  throw std::runtime_error(what + " cannot be drawn: this build is without it; install " + package +
                           " and configure again");
}

[[maybe_unused]] void CheckId(std::uint64_t id, std::uint64_t count, const std::string& family) {
  if (id >= count)
    throw std::runtime_error(family + " has no id " + std::to_string(id) + "; its ids run from 0 to " +
                             std::to_string(count - 1));
}

}  // namespace

#ifdef CHEQUER_HAVE_APRILTAG

bool HasAprilTag() { return true; }

Board AprilTag36h11(std::uint64_t id) {
  const std::unique_ptr<apriltag_family_t, decltype(&tag36h11_destroy)> family(tag36h11_create(), &tag36h11_destroy);
  CheckId(id, family->ncodes, "tag36h11");
  const int side = family->total_width;
  const int rim = (side - family->width_at_border) / 2;
  Board board{.rows = side, .cols = side, .cells = {}, .uncounted_rim = rim, .id = id, .variant = "tag36h11"};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) board.cells += x < rim || y < rim || x >= side - rim || y >= side - rim ? 'W' : 'K';
  for (std::uint32_t bit = 0; bit < family->nbits; ++bit) {
    const auto x = static_cast<int>(family->bit_x[bit]) + rim, y = static_cast<int>(family->bit_y[bit]) + rim;
    // The first bit is the most significant one of the code.
    if ((family->codes[id] >> (family->nbits - 1 - bit) & 1u) != 0)
      board.cells[static_cast<std::size_t>(y * side + x)] = 'W';
  }
  return board;
}

#else

bool HasAprilTag() { return false; }
Board AprilTag36h11(std::uint64_t) { Missing("AprilTag", "libapriltag-dev"); }

#endif

#ifdef CHEQUER_HAVE_ARUCO

bool HasAruco() { return true; }

Board Aruco4x4(std::uint64_t id) {
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_1000);
  CheckId(id, static_cast<std::uint64_t>(dictionary->bytesList.rows), "DICT_4X4_1000");
  cv::Mat square;
  cv::aruco::drawMarker(dictionary, static_cast<int>(id), 6, square, 1);
  Board board{
      .rows = 8, .cols = 8, .cells = std::string(64, 'W'), .uncounted_rim = 1, .id = id, .variant = "aruco4x4_1000"};
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 6; ++x)
      if (square.at<std::uint8_t>(y, x) < 128) board.cells[static_cast<std::size_t>(8 * (y + 1) + x + 1)] = 'K';
  return board;
}

#else

bool HasAruco() { return false; }
Board Aruco4x4(std::uint64_t) { Missing("ArUco", "libopencv-contrib-dev"); }

#endif

}  // namespace chequer
