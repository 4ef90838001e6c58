// Streams in several hard conditions, drawn at random, which change from frame to frame: what memory makes of them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/hard_survey.h"
#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "chequer/detector_memory.h"
#include "simulate/random.h"
#include "simulate/render.h"

namespace chequer::bench {
namespace {

/// A difference between a pose with and without memory beyond that is listed: root mean square, standard deviations.
constexpr double kFarApart = 1;
constexpr std::chrono::milliseconds kFrameTime{33};

struct Request {
  HardSceneOptions scenes;
  int streams = 20, frames = 20;
  std::uint64_t first = 1;
  std::string keep;  ///< folder for the frames; empty: none is kept
};

/// What one way of looking made of boards, or of one.
struct Looks {
  int read = 0, carried = 0, wrong = 0, twice = 0, ghosts = 0, posed = 0, gross = 0;
  double squares = 0;

  void Add(const Looks& more) {
    read += more.read, carried += more.carried, wrong += more.wrong, posed += more.posed, gross += more.gross;
    squares += more.squares;
  }
  void Print() const {
    fmt::print("{:6d} {:5d} {:5d} {:5d} {:5d} {:6.3f}", read, carried, wrong + twice + ghosts, gross, posed,
               squares / std::max(posed, 1));
  }
};

struct Tally {
  int boards = 0, lost = 0, both = 0, apart = 0;
  double differences = 0;
  Looks cold, memory;

  void Add(const Tally& more) {
    boards += more.boards, lost += more.lost, both += more.both, apart += more.apart;
    differences += more.differences;
    cold.Add(more.cold), memory.Add(more.memory);
  }
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
    tallies_.Print();
  }

 private:
  void Look(std::uint64_t seed) {
    HardStream stream(request_.scenes, seed);
    HardFrame frame = stream.Next();
    const DetectorOptions options = OptionsFor(frame.render.camera, request_.scenes.variant);
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
    KeepFrame(folder / fmt::format("{:03d}.png", number), image);
    WriteCamera(folder / "camera.toml", frame.render.camera);
  }

  void Compare(const HardFrame& frame, const std::vector<MarkerPose>& alone, const std::vector<MarkerPose>& remembered,
               const std::string& name) {
    const auto cold = ByBoard(frame, alone, tallies_.all().cold),
               memory = ByBoard(frame, remembered, tallies_.all().memory);
    for (std::size_t i = 0; i < cold.size(); ++i) {
      const SceneMarker& marker = frame.scene.markers[i];
      Tally board;
      board.boards = 1;
      std::string mistake;
      if (cold[i] != nullptr) Tell("cold: ", Count(marker, *cold[i], board.cold), mistake);
      if (memory[i] != nullptr) Tell("memory: ", Count(marker, *memory[i], board.memory), mistake);
      mistake += Differ(cold[i], memory[i], board);
      if (!mistake.empty()) fmt::print("{} board {}: {}{}\n", name, i, mistake, fmt::join(frame.conditions[i], ", "));
      for (Tally* tally : tallies_.Of(frame.conditions[i])) tally->Add(board);
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

  const Request request_;
  Tallies<Tally> tallies_;
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
  AddSceneOptions(app, request.scenes, request.first);
  app.add_option("--keep", request.keep, "Folder for the frames: SEED/FRAME.png, and SEED/camera.toml");
  CLI11_PARSE(app, argc, argv);
  chequer::bench::Survey(request).Run();
}
