// frame_work draw FOLDER WIDTH HEIGHT [NAME...]: the frames of tests/support/adversarial_frames.h, one file each.
// frame_work detect FILE WIDTH HEIGHT [BUDGET]: what detecting in one of them counts; tests/bench/work_check holds that
// against the instructions it takes.
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "support/adversarial_frames.h"

namespace chequer::bench {
namespace {

void Draw(const std::filesystem::path& folder, int width, int height, std::vector<std::string> names) {
  if (names.empty()) names = test::HardFrameNames();
  for (const std::string& name : names) {
    const test::HardFrame frame = test::DrawHardFrame(name, width, height);
    std::ofstream file(folder / name, std::ios::binary);
    const auto bytes = frame.image.bytes();
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file) throw std::runtime_error((folder / name).string() + " could not be written");
  }
}

void Detect(const std::filesystem::path& path, int width, int height, std::uint64_t budget) {
  Image image(PixelFormat::kBgr8, width, height);
  std::ifstream file(path, std::ios::binary);
  const auto bytes = image.bytes();
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) throw std::runtime_error(path.string() + " is no frame of that size");
  DetectorOptions options = test::HardFrameOptions(width, height);
  options.budget = budget;
  Detector detector(options);
  std::vector<MarkerPose> markers;
  detector.Detect(image.view(), markers);
  const DetectStats& stats = detector.stats();
  fmt::print("peaks {} corners {} grids {} boards {} markers {} undecided {} refused_fit {} deferred {} work {}\n", stats.corner_candidates,
             stats.corners, stats.grids, stats.boards, markers.size(), stats.undecided, stats.refused_fit, stats.deferred, stats.work);
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (words.size() < 4) throw std::runtime_error("draw FOLDER WIDTH HEIGHT [NAME...] or detect FILE WIDTH HEIGHT [BUDGET]");
    const int width = std::stoi(words[2]), height = std::stoi(words[3]);
    if (words[0] == "draw")
      chequer::bench::Draw(words[1], width, height, {words.begin() + 4, words.end()});
    else
      chequer::bench::Detect(words[1], width, height, words.size() > 4 ? std::stoull(words[4]) : 0);
  } catch (const std::exception& error) {
    fmt::print(stderr, "frame_work: {}\n", error.what());
    return 1;
  }
}
