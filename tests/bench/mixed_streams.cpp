// Streams in several hard conditions, drawn at random, which change from frame to frame: what memory makes of them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/hard_scenes.h"
#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "chequer/detector_memory.h"
#include "core/file.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "support/pose_errors.h"

namespace chequer::bench {
namespace {

/// A squared error over covariance and dimension beyond that is gross.
constexpr double kGross = 8;
/// A squared error or difference counts this much at most in means.
constexpr double kMostSquare = 20;
/// A difference between a pose with and without memory beyond that is listed: root mean square, standard deviations.
constexpr double kFarApart = 1;
constexpr std::chrono::milliseconds kFrameTime{33};

struct Request {
  HardSceneOptions scenes;
  int streams = 20, frames = 20;
  std::uint64_t first = 1;
  std::string keep;  ///< folder for the frames; empty: none is kept
};

struct Squares {
  double position = 0, orientation = 0;  ///< squared errors over covariance and dimension

  double largest() const { return std::max(position, orientation); }
  double mean() const { return (position + orientation) / 2; }
};

Squares SquaresOf(const RigidTransform& camera_from_marker, const MarkerPose& pose) {
  test::PoseErrors errors;
  errors.Add(camera_from_marker, pose);
  return {errors.position(), errors.orientation()};
}

/// What one way of looking made of boards.
struct Looks {
  int read = 0, carried = 0, wrong = 0, twice = 0, ghosts = 0, posed = 0, gross = 0;
  double squares = 0;

  void Print() const {
    fmt::print("{:6d} {:5d} {:5d} {:5d} {:5d} {:6.3f}", read, carried, wrong + twice + ghosts, gross, posed,
               squares / std::max(posed, 1));
  }
};

struct Tally {
  int boards = 0, lost = 0, both = 0, apart = 0;
  double differences = 0;
  Looks cold, memory;

  void Print(const std::string& name) const {
    fmt::print("{:<12} {:6d} |", name, boards);
    cold.Print();
    fmt::print(" |");
    memory.Print();
    fmt::print(" | {:5d} {:5d} {:6.3f}\n", lost, apart, std::sqrt(differences / std::max(both, 1)));
  }
};

/// Poses of a frame by the board that they are of; null where it was not found.
std::vector<const MarkerPose*> ByBoard(const HardFrame& frame, const std::vector<MarkerPose>& poses, Looks& all) {
  std::vector<const MarkerPose*> found(frame.conditions.size());
  for (const MarkerPose& pose : poses) {
    const auto board = frame.BoardOf(pose.camera_from_marker);
    if (!board)
      ++all.ghosts;
    else if (found[*board] != nullptr)
      ++all.twice;
    else
      found[*board] = &pose;
  }
  return found;
}

/// Names what is wrong with a pose; empty where nothing is.
std::string Count(const SceneMarker& marker, const MarkerPose& pose, Looks& looks) {
  std::string mistake;
  looks.read += pose.id.has_value();
  looks.carried += pose.Has(Warning::kIdCarried);
  if (pose.id && *pose.id != marker.board.id) {
    ++looks.wrong;
    mistake = "wrong id, ";
  }
  if (pose.Has(Warning::kAmbiguous)) return mistake;
  const Squares squares = SquaresOf(marker.camera_from_marker, pose);
  ++looks.posed;
  looks.squares += std::min(squares.mean(), kMostSquare);
  if (squares.largest() <= kGross) return mistake;
  ++looks.gross;
  return mistake + fmt::format("squared errors {:.1f} {:.1f}, {} corners, ", squares.position, squares.orientation,
                               pose.corners_used);
}

class Survey {
 public:
  explicit Survey(const Request& request) : request_(request) {}

  void Run() {
    const std::uint64_t past = request_.first + static_cast<std::uint64_t>(request_.streams);
    for (std::uint64_t seed = request_.first; seed < past; ++seed) Look(seed);
    fmt::print(
        "{:<12} {:>6} |{:>6} {:>5} {:>5} {:>5} {:>5} {:>6} |{:>6} {:>5} {:>5} {:>5} {:>5} {:>6} | {:>5} {:>5} {:>6}\n",
        "condition", "boards", "read", "carry", "wrong", "gross", "posed", "sq", "read", "carry", "wrong", "gross",
        "posed", "sq", "lost", "apart", "differ");
    all_.Print("all");
    for (const auto& [name, tally] : tallies_) tally.Print(name);
  }

 private:
  void Look(std::uint64_t seed) {
    HardStream stream(request_.scenes, seed);
    HardFrame frame = stream.Next();
    DetectorOptions options;
    options.families = {
        {.code = MarkerCode({6, 6}, request_.scenes.variant), .side_m = HardFrame::kSideM, .roster = {}}};
    options.camera = frame.render.camera;
    Detector cold(options), detector(options);
    DetectorMemory memory;
    std::vector<MarkerPose> alone, remembered;
    for (int i = 0; i < request_.frames; ++i) {
      const Image image = Render(frame.scene, frame.render, DeriveSeed(seed, static_cast<std::uint64_t>(i)));
      if (!request_.keep.empty()) Keep(frame, image, seed, i);
      cold.Detect(image.view(), alone);
      detector.Detect(image.view(), i * kFrameTime, memory, remembered);
      Compare(frame, alone, remembered, fmt::format("stream {} frame {}", seed, i));
      frame = stream.Next();
    }
  }

  void Keep(const HardFrame& frame, const Image& image, std::uint64_t seed, int number) const {
    const std::filesystem::path folder = std::filesystem::path(request_.keep) / std::to_string(seed);
    std::filesystem::create_directories(folder);
    WriteFileAtomically(folder / fmt::format("{:03d}.png", number), EncodeFrame(image.view(), {}));
    WriteCamera(folder / "camera.toml", frame.render.camera);
  }

  void Compare(const HardFrame& frame, const std::vector<MarkerPose>& alone, const std::vector<MarkerPose>& remembered,
               const std::string& name) {
    const auto cold = ByBoard(frame, alone, all_.cold), memory = ByBoard(frame, remembered, all_.memory);
    for (std::size_t i = 0; i < cold.size(); ++i) {
      const SceneMarker& marker = frame.scene.markers[i];
      for (Tally* tally : TalliesOf(frame.conditions[i])) {
        ++tally->boards;
        std::string mistake;
        if (cold[i] != nullptr) Tell("cold: ", Count(marker, *cold[i], tally->cold), mistake);
        if (memory[i] != nullptr) Tell("memory: ", Count(marker, *memory[i], tally->memory), mistake);
        Tell("", Differ(cold[i], memory[i], *tally), mistake);
        if (tally == &all_ && !mistake.empty())
          fmt::print("{} board {}: {}{}\n", name, i, mistake, fmt::join(frame.conditions[i], ", "));
      }
    }
  }

  static void Tell(const char* of, const std::string& what, std::string& mistake) {
    if (!what.empty()) mistake += of + what;
  }

  /// How far a board's poses without and with memory are apart.
  static std::string Differ(const MarkerPose* cold, const MarkerPose* memory, Tally& tally) {
    if (cold == nullptr || !cold->id) return {};
    if (memory == nullptr || !memory->id) {
      ++tally.lost;
      return "lost, ";
    }
    if (cold->Has(Warning::kAmbiguous) || memory->Has(Warning::kAmbiguous)) return {};
    const double square = SquaresOf(cold->camera_from_marker, *memory).mean();
    ++tally.both;
    tally.differences += std::min(square, kMostSquare);
    if (square < kFarApart * kFarApart) return {};
    ++tally.apart;
    return fmt::format("apart by {:.2f}, ", std::sqrt(square));
  }

  std::vector<Tally*> TalliesOf(const std::vector<const char*>& conditions) {
    std::vector<Tally*> tallies{&all_};
    for (const char* name : conditions) tallies.push_back(&tallies_[name]);
    return tallies;
  }

  const Request request_;
  Tally all_;
  std::map<std::string, Tally> tallies_;
};

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Streams in several hard conditions, drawn at random, which change from frame to frame: boards read, wrong ids,\n"
      "gross errors and squared errors over covariance, each frame alone and with memory of those before; boards that\n"
      "are read alone but not with memory, and how far the poses are apart. Lists what is wrong.");
  chequer::bench::Request request;
  app.add_option("--streams", request.streams, "Streams, of one to nine boards")->capture_default_str();
  app.add_option("--frames", request.frames, "Frames of each")->capture_default_str();
  app.add_option("--first", request.first, "First seed")->capture_default_str();
  app.add_option("--only", request.scenes.only, "Conditions that may be, comma-separated [all]")->delimiter(',');
  app.add_option("--share", request.scenes.share, "Of frames or boards that have each [its own]");
  app.add_option("--keep", request.keep, "Folder for the frames: SEED/FRAME.png, and SEED/camera.toml");
  CLI11_PARSE(app, argc, argv);
  chequer::bench::Survey(request).Run();
}
