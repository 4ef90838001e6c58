// Holds the detector against recorded scenes: golden_runner SCENE_FOLDER…
// golden_runner --complete SCENES_FOLDER NAME… checks instead that the names are all the folders there are.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "golden/judge.h"
#include "golden/scene_file.h"

namespace chequer::golden {
namespace {

namespace fs = std::filesystem;

Verdict Run(const fs::path& folder, const GoldenScene& scene) {
  Detector detector(scene.options);
  Verdict verdict;
  for (const ExpectedFrame& frame : scene.frames) {
    const Image image = LoadFrame(folder / frame.file, scene);
    JudgeFrame(scene, frame, detector.Detect(image.view()), verdict);
  }
  JudgeCount(scene, verdict);
  return verdict;
}

/// Prints a scene's result; true if it passed.
bool Report(const GoldenScene& scene, const Verdict& verdict) {
  const bool passed = verdict.failures.empty();
  std::printf(
      "%s %s: %d of %d markers (at least %d), %d undecided; worst corner %.3f px, position %.3f mm, angle %.3f deg\n",
      passed ? "passed" : "FAILED", scene.name.c_str(), verdict.detected, verdict.expected, scene.min_detections,
      verdict.undecided, verdict.worst_corner_px, verdict.worst_position_mm, verdict.worst_angle_deg);
  for (const std::string& failure : verdict.failures) std::printf("  %s\n", failure.c_str());
  if (verdict.detected > scene.min_detections) {
    std::printf("  surplus: %d more than asked for; raise min_detections to %d\n",
                verdict.detected - scene.min_detections, verdict.detected);
  }
  return passed;
}

bool RunScenes(const std::vector<std::string>& folders) {
  bool passed = true;
  for (const std::string& folder : folders) {
    try {
      const GoldenScene scene = LoadScene(folder);
      passed = Report(scene, Run(folder, scene)) && passed;
    } catch (const std::exception& error) {
      std::printf("FAILED %s\n", error.what());
      passed = false;
    }
  }
  return passed;
}

/// Whether the names are exactly the folders: a scene that nobody runs would pass for ever.
bool AllScenesAreRun(const fs::path& scenes, std::vector<std::string> names) {
  std::vector<std::string> present;
  for (const auto& entry : fs::directory_iterator(scenes)) {
    if (entry.is_directory()) present.push_back(entry.path().filename().string());
  }
  std::sort(present.begin(), present.end());
  std::sort(names.begin(), names.end());
  if (present == names) return true;
  std::printf("%s: %zu folders, but %zu scenes are run; the list is in tests/golden/CMakeLists.txt\n", scenes.c_str(),
              present.size(), names.size());
  return false;
}

}  // namespace
}  // namespace chequer::golden

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty()) {
    std::fprintf(stderr,
                 "usage: golden_runner SCENE_FOLDER...\n       golden_runner --complete SCENES_FOLDER NAME...\n");
    return 2;
  }
  if (arguments[0] != "--complete") return chequer::golden::RunScenes(arguments) ? 0 : 1;
  if (arguments.size() < 2) return 2;
  return chequer::golden::AllScenesAreRun(arguments[1], {arguments.begin() + 2, arguments.end()}) ? 0 : 1;
}
