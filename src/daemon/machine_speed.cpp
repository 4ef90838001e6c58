#include "daemon/machine_speed.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <barrier>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include "chequer/detector.h"

namespace chequer {
namespace {

constexpr int kWidth = 360, kHeight = 270;
/// Cells, and from one board to the next, px.
constexpr int kCellPx = 9, kPitchPx = 90;
/// How far the boards moved during the exposure, px. A budget counts where boards need the model with all terms; a unit
/// of that takes longer than one of sharp boards.
constexpr int kMotionPx = 6;
/// The first run finds the memory that later ones have, and does not count.
constexpr int kRuns = 7;

struct Colour {
  int blue, green, red;
};

Colour ColourOf(char cell) {
  switch (cell) {
    case 'K': return {40, 38, 38};
    case 'B': return {150, 70, 40};
    case 'Y': return {50, 200, 220};
    default: return {225, 228, 230};
  }
}

/// Where boards lie side by side, the colour of a pixel; grey ground with a little grain between them.
Colour ColourAt(int x, int y, const std::vector<std::string>& boards, MarkerSize size) {
  const int board = y / kPitchPx * (kWidth / kPitchPx + 1) + x / kPitchPx;
  const int col = x % kPitchPx / kCellPx - 2, row = y % kPitchPx / kCellPx - 2;
  if (col >= 0 && row >= 0 && col < size.cols && row < size.rows)
    return ColourOf(
        boards[static_cast<std::size_t>(board) % boards.size()][static_cast<std::size_t>(row * size.cols + col)]);
  const int grain = (x * 7 + y * 13 + x * y % 31) % 9;
  return {105 + grain, 115 + grain, 110 + grain};
}

/// Boards on a plain floor that moved along the rows. Each pixel is also the mean of two rows, so that edges across
/// have some width.
Image DrawFloor(const MarkerCode& code) {
  std::vector<std::string> boards;
  for (std::uint64_t id = 0; id < 8; ++id) boards.push_back(CellColours(code.size(), code.Encode(id)));
  Image image(PixelFormat::kBgr8, kWidth, kHeight);
  std::uint8_t* byte = image.bytes().data();
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      Colour sum{};
      for (const int dy : {0, 1})
        for (int dx = 0; dx < kMotionPx; ++dx) {
          const Colour colour = ColourAt(x + dx, y + dy, boards, code.size());
          sum = {sum.blue + colour.blue, sum.green + colour.green, sum.red + colour.red};
        }
      for (const int value : {sum.blue, sum.green, sum.red})
        *byte++ = static_cast<std::uint8_t>(value / (2 * kMotionPx));
    }
  return image;
}

/// Seconds that this thread has had a processor to itself: machines that start have much else to do.
double ThreadSeconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// What this thread does in a second: the median of a few runs, each begun when all others begin theirs. The fastest
/// would tell what a thread does while the others rest, which frames never see.
double SpeedOfThread(const Image& floor, std::barrier<>& together) {
  Detector detector{DetectorOptions{}};
  std::vector<MarkerPose> markers;
  std::vector<double> seconds;
  for (int run = 0; run < kRuns; ++run) {
    together.arrive_and_wait();
    const double start_s = ThreadSeconds();
    detector.Detect(floor.view(), markers);
    if (run > 0) seconds.push_back(ThreadSeconds() - start_s);
  }
  const auto median = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), median, seconds.end());
  return static_cast<double>(detector.stats().work) / std::max(*median, 1e-6);
}

}  // namespace

double MeasureSpeed(int workers) {
  const Image floor = DrawFloor(DetectorOptions{}.families[0].code);
  std::vector<double> speeds(static_cast<std::size_t>(std::max(workers, 1)));
  {
    std::barrier together(std::ssize(speeds));
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < speeds.size(); ++i)
      others.emplace_back([&, i] { speeds[i] = SpeedOfThread(floor, together); });
    speeds[0] = SpeedOfThread(floor, together);
  }
  const double speed = *std::min_element(speeds.begin(), speeds.end());
  spdlog::info("this machine does {:.1f} million units of work a second", 1e-6 * speed);
  return speed;
}

}  // namespace chequer
