// long_stream [options]: streams, not stills, through one detector for as long as is asked for. Renders the frames of
// scenarios once and plays them over and over, each time with new noise and the streams in another order; holds every
// frame against the truth. Status 1 where there was a wrong id, a marker twice or a ghost, or where memory grew.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "bench/long_report.h"
#include "bench/long_tally.h"
#include "bench/reels.h"
#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "chequer/detector_memory.h"
#include "core/file.h"
#include "evaluate/frame_score.h"
#include "simulate/random.h"

namespace chequer::bench {
namespace {

namespace fs = std::filesystem;

/// Memory that may come after the first tenth of a run and still counts as flat: pages that the system moves.
constexpr double kMostGrowthMb = 2;
constexpr int kMostKept = 100;
/// Where a stream begins after a gap; every other one follows as a cut that no clock tells of.
constexpr std::chrono::seconds kGap{1};

struct Request {
  ReelRequest reels;
  std::string size;
  std::uint64_t total = 100'000;
  std::uint64_t budget = 0;
  int threads = 1;
  bool memory = true;
  std::string keep;
  std::uint64_t report_every = 0;
};

FoundFrame FoundOf(const std::vector<MarkerPose>& markers) {
  FoundFrame found;
  for (const MarkerPose& pose : markers) {
    FoundMarker& marker = found.markers.emplace_back();
    marker.id = pose.id;
    marker.variant = VariantName(pose.variant);
    marker.center_px = pose.center_px;
    marker.carried = pose.Has(Warning::kIdCarried);
    if (!pose.has_pose) continue;
    marker.camera_from_marker = pose.camera_from_marker;
    marker.covariance = pose.covariance;
  }
  return found;
}

/// Names each marker of a frame that is wrong, twice there or a ghost.
std::string DescribeMistakes(const FoundFrame& found, const FrameTruth& truth) {
  std::string text;
  std::map<std::uint64_t, int> seen;
  for (const FoundMarker& marker : found.markers) {
    if (!marker.id) continue;
    const FrameScore alone = ScoreFrame({.markers = {marker}, .detect_ms = {}, .latency_ms = {}}, truth);
    const char* what = alone.ghosts > 0         ? "ghost"
                       : alone.wrong > 0        ? "wrong"
                       : seen[*marker.id]++ > 0 ? "twice"
                                                : nullptr;
    if (what != nullptr)
      text +=
          fmt::format(" {} id {} at ({:.1f}, {:.1f})", what, *marker.id, marker.center_px.x(), marker.center_px.y());
  }
  return text;
}

/// Keeps frames with mistakes, so that others can look at them.
class Evidence {
 public:
  explicit Evidence(std::string folder) : folder_(std::move(folder)) {
    if (!folder_.empty()) fs::create_directories(folder_);
  }

  void Keep(const Reel& reel, std::size_t frame, std::uint64_t round, const Image& image, const std::string& what) {
    std::string line = fmt::format("{} seed {} frame {} ({}) round {}:{}", reel.stream, reel.seed(), frame,
                                   reel.truth[frame].phase, round, what);
    if (!folder_.empty() && kept_ < kMostKept) {
      const std::string name = fmt::format("{:03}_{}_{}_{}_{}.png", kept_++, reel.stream, reel.seed(), frame, round);
      WriteFileAtomically(folder_ / name, EncodeFrame(image.view(), {}));
      WriteCamera(folder_ / "camera.toml", reel.scenario.camera.render.camera);
      FrameTruth truth = reel.truth[frame];
      truth.file = name;
      std::ofstream(folder_ / "truth.jsonl", std::ios::app) << ToJsonLine(truth) << "\n";
      line += " -> " + (folder_ / name).string();
    }
    fmt::print("{}\n", line);
    std::fflush(stdout);
  }

 private:
  fs::path folder_;
  int kept_ = 0;
};

/// Plays reels through one detector.
class LongRun {
 public:
  LongRun(const Request& request, const std::vector<Reel>& reels)
      : request_(request),
        reels_(reels),
        detector_(MakeDetector(request, reels)),
        noise_(reels.front().scenario.camera.render.tone_curve),
        evidence_(request.keep) {
    for (const Reel& reel : reels)
      for (const FrameTruth& truth : reel.truth) TallyOf(reel, truth);
  }

  void Play() {
    std::vector<std::size_t> order(reels_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::uint64_t round = 0; played_ < request_.total; ++round) {
      for (const std::size_t index : order) PlayReel(reels_[index], round);
      Shuffle(order, round);
    }
  }

  /// Whether all that must not happen did not happen.
  bool Report() const {
    std::uint64_t mistakes = 0;
    for (const PhaseTally& phase : phases_) mistakes += phase.mistakes();
    fmt::print("{}\n{}", DescribeRun(phases_), DescribeMemory(memory_));
    const bool flat = memory_.Growth() <= kMostGrowthMb;
    fmt::print("{} frames, {} mistakes, memory {}\n", played_, mistakes, flat ? "flat" : "GROWS");
    std::fflush(stdout);
    return mistakes == 0 && flat;
  }

 private:
  static Detector MakeDetector(const Request& request, const std::vector<Reel>& reels) {
    DetectorOptions options = OptionsFor(reels);
    options.budget = request.budget;
    options.threads = request.threads;
    return Detector(std::move(options));
  }

  void PlayReel(const Reel& reel, std::uint64_t round) {
    const auto interval =
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(1 / reel.scenario.camera.fps));
    if (++streams_ % 2 == 0) now_ += kGap;
    for (std::size_t frame = 0; frame < reel.frames.size() && played_ < request_.total; ++frame) {
      noise_.Expose(reel.frames[frame], NoiseSeed(reel, frame, round), image_);
      now_ += interval;
      if (request_.memory) detector_.Detect(image_.view(), now_, taught_, markers_);
      else detector_.Detect(image_.view(), markers_);
      Judge(reel, frame, round);
      ++played_;
      if (played_ % std::max<std::uint64_t>(1, request_.total / 100) == 0) memory_.Add(played_, ResidentMegabytes());
      if (request_.report_every > 0 && played_ % request_.report_every == 0) Report();
    }
  }

  void Judge(const Reel& reel, std::size_t frame, std::uint64_t round) {
    const FoundFrame found = FoundOf(markers_);
    const FrameTruth& truth = reel.truth[frame];
    const FrameScore score = ScoreFrame(found, truth);
    TallyOf(reel, truth).Add(score, detector_.stats().work, detector_.stats().deferred);
    if (score.wrong + score.twice + score.ghosts > 0)
      evidence_.Keep(reel, frame, round, image_, DescribeMistakes(found, truth));
  }

  PhaseTally& TallyOf(const Reel& reel, const FrameTruth& truth) {
    const auto known = std::find_if(phases_.begin(), phases_.end(), [&](const PhaseTally& tally) {
      return tally.stream == reel.stream && tally.phase == truth.phase;
    });
    if (known != phases_.end()) return *known;
    phases_.emplace_back().stream = reel.stream;
    phases_.back().phase = truth.phase;
    return phases_.back();
  }

  static void Shuffle(std::vector<std::size_t>& order, std::uint64_t seed) {
    Random random(seed);
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(random.Below(static_cast<int>(i)))]);
  }

  const Request& request_;
  const std::vector<Reel>& reels_;
  Detector detector_;
  DetectorMemory taught_;
  std::chrono::nanoseconds now_{0};
  std::uint64_t streams_ = 0;
  FreshNoise noise_;
  Evidence evidence_;
  std::vector<PhaseTally> phases_;
  MemoryWatch memory_;
  Image image_;
  std::vector<MarkerPose> markers_;
  std::uint64_t played_ = 0;
};

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// "640x360".
std::optional<std::pair<int, int>> ParseSize(const std::string& text) {
  if (text.empty()) return std::nullopt;
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 160 || height < 120 ||
      !SizeIsValid(PixelFormat::kBayerRg8, width, height))
    throw std::runtime_error("--size must be WIDTHxHEIGHT such as 640x360, at least 160x120");
  return std::pair(width, height);
}

bool Run(const Request& request) {
  std::vector<Reel> reels = PlanReels(request.reels);
  auto start = std::chrono::steady_clock::now();
  RenderReels(reels, request.reels.jobs);
  std::size_t frames = 0;
  for (const Reel& reel : reels) frames += reel.frames.size();
  const CameraModel& camera = reels.front().scenario.camera.render.camera;
  fmt::print("{} frames of {}x{} rendered in {:.0f} s: {} streams, seeds {} to {}\n", frames, camera.width,
             camera.height, SecondsSince(start), request.reels.scenarios.size(), reels.front().seed(),
             reels.back().seed());
  std::fflush(stdout);
  LongRun run(request, reels);
  start = std::chrono::steady_clock::now();
  run.Play();
  fmt::print("played in {:.0f} s, one detector, {} memory between frames, budget {}\n\n", SecondsSince(start),
             request.memory ? "with" : "without",
             request.budget == 0 ? "unlimited" : fmt::format("{} units", request.budget));
  return run.Report();
}

void AddOptions(CLI::App& app, Request& request) {
  app.add_option("--scenario", request.reels.scenarios,
                 "Scenario files; the first one's camera films all [examples/scenarios]")
      ->check(CLI::ExistingFile);
  app.add_option("--frames", request.reels.frames,
                 "About so many are rendered, 1.8 MB each at 1280x720; more seeds as needed")
      ->check(CLI::Range(10, 100'000))
      ->capture_default_str();
  app.add_option("--total", request.total, "So many are played")
      ->check(CLI::Range(1, 1'000'000'000))
      ->capture_default_str();
  app.add_option("--seed", request.reels.seed, "Of the first; others follow")->capture_default_str();
  app.add_option("--size", request.size,
                 "Instead of the first scenario's, with the same focal length and fewer robots");
  app.add_option("--robots", request.reels.robots, "In each stream")->check(CLI::Range(1, 1000));
  app.add_option("--budget", request.budget, "Units a frame; 0: no limit")->capture_default_str();
  app.add_flag("--memory,!--no-memory", request.memory, "Begin each frame with what the last ones taught, as chequerd does")
      ->default_str("true");
  app.add_option("--threads", request.threads, "Of the detector")->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--jobs", request.reels.jobs, "Threads that render")->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--keep", request.keep, "Folder for frames with mistakes, at most 100, with camera and truth");
  app.add_option("--report-every", request.report_every, "Print the tables after each N frames, too");
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  chequer::bench::Request request;
  CLI::App app("Plays rendered streams over and over through one detector and holds every frame against the truth.");
  chequer::bench::AddOptions(app, request);
  CLI11_PARSE(app, argc, argv);
  try {
    request.reels.size = chequer::bench::ParseSize(request.size);
    if (request.reels.scenarios.empty())
      for (const char* name : {"reference", "flicker", "shadows", "traffic", "reopen"})
        request.reels.scenarios.push_back(std::filesystem::path(CHEQUER_SCENARIOS) / (std::string(name) + ".toml"));
    return chequer::bench::Run(request) ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "long_stream: {}\n", error.what());
    return 2;
  }
}
