#include "daemon/machine_speed.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <ctime>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "chequer/detector.h"

namespace chequer {
namespace {

/// Two boards.
constexpr int kWidth = 180, kHeight = 90;
/// Cells, and from one board to the next, px.
constexpr int kCellPx = 9, kPitchPx = 90;
/// How far the boards moved during the exposure, px. A budget counts where boards need the model with all terms; a unit
/// of that takes longer than one of sharp boards.
constexpr int kMotionPx = 6;
/// Runs that count, and the time of a thread after which those that there are have to do: an emulated machine takes
/// seconds for the first.
constexpr std::size_t kRuns = 25;
constexpr double kMostSeconds = 0.4;

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

/// What all threads know of each other. Nobody waits for anybody: each works on until all have measured.
struct Measuring {
  explicit Measuring(std::size_t count) : threads(static_cast<int>(count)) {}
  const int threads;
  std::atomic<int> working{0}, done{0};
};

/// What this thread does in a second: the median of a few runs while all others run, too. The fastest would tell what a
/// thread does while the others rest, which frames never see. @param stop asked for where others could not be started.
double SpeedOfThread(const Image& floor, Measuring& all, const std::stop_token& stop) {
  Detector detector{DetectorOptions{}};
  std::vector<MarkerPose> markers;
  std::vector<double> seconds;
  double spent_s = 0;
  const auto run = [&] {
    const double start_s = ThreadSeconds();
    detector.Detect(floor.view(), markers);
    const double run_s = ThreadSeconds() - start_s;
    spent_s += run_s;
    return run_s;
  };
  // It finds the memory that later ones have, and counts only where there is no time for others.
  const double first_s = run();
  ++all.working;
  for (bool done = false; !stop.stop_requested();) {
    if (!done && (seconds.size() >= kRuns || spent_s >= kMostSeconds)) {
      done = true;
      ++all.done;
    }
    if (all.done == all.threads) break;
    const bool counts = all.working == all.threads;
    const double run_s = run();
    if (counts) seconds.push_back(run_s);
  }
  if (seconds.empty()) seconds.push_back(first_s);
  const auto median = seconds.begin() + static_cast<std::ptrdiff_t>(seconds.size() / 2);
  std::nth_element(seconds.begin(), median, seconds.end());
  return static_cast<double>(detector.stats().work) / std::max(*median, 1e-6);
}

}  // namespace

double MeasureSpeed(int workers) {
  const Image floor = DrawFloor(DetectorOptions{}.families[0].code);
  std::vector<double> speeds(static_cast<std::size_t>(std::max(workers, 1)));
  {
    Measuring all(speeds.size());
    // Where one cannot be started, those that were are asked to stop as they are destroyed.
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < speeds.size(); ++i)
      others.emplace_back([&, i](const std::stop_token& stop) { speeds[i] = SpeedOfThread(floor, all, stop); });
    speeds[0] = SpeedOfThread(floor, all, {});
  }
  const double speed = *std::min_element(speeds.begin(), speeds.end());
  spdlog::info("this machine does {:.1f} million units of work a second", 1e-6 * speed);
  return speed;
}

}  // namespace chequer
