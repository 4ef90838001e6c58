#include "devices/camera_test_tools.h"

#include <sys/resource.h>
#include <time.h>

#include <fstream>
#include <iterator>
#include <set>
#include <thread>
#include <utility>

#include "daemon/newest_queue.h"

namespace chequer::test {
namespace {

std::size_t EntriesOf(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

struct ThreadTimes {
  double cpu_ms = 0;
  double user_ms = 0;
};

ThreadTimes TimesOfThisThread() {
  timespec cpu{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &cpu);
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {1e3 * static_cast<double>(cpu.tv_sec) + 1e-6 * static_cast<double>(cpu.tv_nsec),
          1e3 * static_cast<double>(usage.ru_utime.tv_sec) + 1e-3 * static_cast<double>(usage.ru_utime.tv_usec)};
}

using SteadyTime = std::chrono::steady_clock::time_point;

}  // namespace

std::string CameraConfig(const std::filesystem::path& folder, const std::string& capture,
                         const std::filesystem::path& calibration, const std::string& name) {
  const std::filesystem::path file = folder / (name + ".toml");
  std::ofstream text(file);
  text << "[camera]\nname = \"" << name << "\"\n";
  if (!calibration.empty()) text << "calibration = \"" << calibration.string() << "\"\n";
  text << "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 0.12\n[capture]\n" << capture << "\n";
  return file.string();
}

Holdings HoldingsOf(int process) {
  const std::filesystem::path proc = "/proc/" + std::to_string(process);
  Holdings holdings;
  holdings.descriptors = EntriesOf(proc / "fd");
  holdings.threads = EntriesOf(proc / "task");
  std::ifstream status(proc / "status");
  for (std::string word; status >> word;)
    if (word == "VmRSS:") status >> holdings.memory_kb;
  return holdings;
}

CaptureCost MeasureCapture(FrameSource& source, int frames, int most_lost) {
  CaptureCost cost;
  NewestQueue<std::pair<Frame, SteadyTime>> queue;
  double waited_ms = 0;
  int taken = 0;
  std::set<const void*> places;
  std::jthread worker([&] {
    while (auto item = queue.Take()) {
      waited_ms +=
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - item->item.second).count();
      places.insert(item->item.first.image.row(0));
      ++taken;
    }
  });
  ThreadTimes begin;
  // The first one touches everything for the first time.
  for (int i = 0, lost = 0; i <= frames && cost.problem.empty();) {
    if (i == 1) begin = TimesOfThisThread();
    CaptureResult result = source.Next(std::chrono::seconds(10));
    if (result.status == CaptureStatus::kFrame) {
      queue.Put({std::move(result.frame), std::chrono::steady_clock::now()});
      ++i;
    } else if (result.status != CaptureStatus::kCorrupt || ++lost > most_lost) {
      cost.problem = "frame " + std::to_string(i) + " did not come: " + result.message;
    }
  }
  const ThreadTimes end = TimesOfThisThread();
  queue.Close();
  worker.join();
  cost.frames = frames;
  cost.cpu_ms = (end.cpu_ms - begin.cpu_ms) / frames;
  cost.user_ms = (end.user_ms - begin.user_ms) / frames;
  cost.hand_over_ms = waited_ms / taken;
  cost.places = static_cast<int>(places.size());
  return cost;
}

}  // namespace chequer::test
