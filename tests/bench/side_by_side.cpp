// This detector, AprilTag 3, ArUco and others that are given, on the same scenes, in one process, each with one thread.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <opencv2/core.hpp>

#include "bench/frames.h"
#include "bench/peer.h"
#include "bench/race.h"
#include "bench/report.h"

namespace chequer::bench {
namespace {

struct Options {
  std::filesystem::path frames;
  std::vector<std::string> suites;
  std::vector<std::string> sides;
  std::vector<std::filesystem::path> peers;
  std::filesystem::path json;
  int repetitions = 3;
  std::uint64_t seed = 1;
  bool by_condition = false;
};

/// The folders of a frames folder that hold a suite.
std::vector<std::string> SuitesIn(const std::filesystem::path& frames, const std::vector<Print>& prints) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(frames)) {
    const bool holds_pattern = std::any_of(prints.begin(), prints.end(), [&entry](const Print& print) {
      return std::filesystem::exists(entry.path() / print.pattern);
    });
    if (holds_pattern) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// The side that "--side SUITE=METRES" gives a suite, or its default.
double SideOf(const std::string& suite, const std::vector<std::string>& sides) {
  for (const std::string& side : sides) {
    const std::size_t equals = side.find('=');
    if (equals == std::string::npos) throw std::runtime_error("--side " + side + ": must be SUITE=METRES");
    if (side.substr(0, equals) != suite) continue;
    const double metres = std::stod(side.substr(equals + 1));
    if (!(metres > 0)) throw std::runtime_error("--side " + side + ": must be more than 0 metres");
    return metres;
  }
  return DefaultSide(suite);
}

/// Says who takes part, and who could.
void PrintHead(const nlohmann::json& machine, int repetitions, const std::vector<Peer>& peers) {
  fmt::print("{}; OpenCV {}, AprilTag {}", machine["processor"].get<std::string>(),
             machine["opencv"].get<std::string>(), machine["apriltag"].get<std::string>());
  for (const Peer& peer : peers) fmt::print(", {}", peer.name());
  fmt::print(
      "\nms: median over frames of the fastest of {} (streams: mean, without the first {}); one thread each, BGR in "
      "memory, grey conversion included, poses only for chequer\n",
      repetitions, kFramesUntilKnown);
  if (peers.empty())
    fmt::print(
        "not here: ArUco Nano, ARToolKitPlus and other detectors without a package; each takes part as a shared "
        "library, "
        "--peer LIBRARY (tests/bench/README.md)\n");
  fmt::print("\n");
}

/// Says which peers have nothing to read in a suite of a folder.
void PrintIdle(const Suite& suite, const std::vector<Peer>& peers) {
  if (!suite.HasMarkers()) return;
  for (const Peer& peer : peers) {
    if (!suite.frames.contains(peer.pattern()))
      fmt::print("{}: no frames of {} in {}\n", peer.name(), peer.pattern(), suite.name);
  }
}

void Run(const Options& options) {
  cv::setNumThreads(1);
  const std::vector<Peer> peers(options.peers.begin(), options.peers.end());
  const std::vector<Print> prints = PrintsWith(peers);
  nlohmann::json report = DescribeMachine();
  report["repetitions"] = options.repetitions;
  report["suites"] = nlohmann::json::array();
  std::vector<std::string> names = options.suites;
  if (names.empty()) names = options.frames.empty() ? RenderedSuites() : SuitesIn(options.frames, prints);
  PrintHead(report, options.repetitions, peers);
  for (const std::string& name : names) {
    const Suite suite = options.frames.empty() ? RenderSuite(name, options.seed, prints)
                                               : LoadSuite(options.frames / name, SideOf(name, options.sides), prints);
    PrintIdle(suite, peers);
    const std::vector<Result> results = Race(suite, options.repetitions, peers);
    fmt::print("{}\n", FormatTable(suite, results, options.by_condition || suite.straight_tracks));
    std::fflush(stdout);
    report["suites"].push_back(ToJson(suite, results));
  }
  if (options.json.empty()) return;
  std::ofstream file(options.json);
  file << report.dump(1) << "\n";
  if (!file.flush()) throw std::runtime_error(options.json.string() + ": cannot be written");
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  chequer::bench::Options options;
  CLI::App app(
      "Compares chequer with AprilTag 3, ArUco and the peers that are given on the same scenes.\n"
      "Example: side_by_side FRAMES --suite paper --json result.json");
  app.add_option("frames", options.frames, "folder of SUITE/{secded,tag36h11,aruco4}; without it, scenes are rendered")
      ->check(CLI::ExistingDirectory);
  app.add_option("--suite", options.suites, "suites to run (default: all)");
  app.add_option("--peer", options.peers, "shared library of one more detector (tests/bench/peer_plugin.h)")
      ->check(CLI::ExistingFile);
  app.add_option("--side", options.sides, "SUITE=METRES: side of the markers of a suite in the folder");
  app.add_option("--repeat", options.repetitions, "repetitions of each frame, the fastest counts")
      ->check(CLI::Range(1, 1000));
  app.add_option("--seed", options.seed, "of rendered scenes");
  app.add_option("--json", options.json, "write the results to this file, too");
  app.add_flag("--conditions", options.by_condition, "a line for every condition");
  CLI11_PARSE(app, argc, argv);
  try {
    chequer::bench::Run(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "side_by_side: {}\n", error.what());
    return 1;
  }
  return 0;
}
