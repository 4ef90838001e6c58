// Boards in several hard conditions at once, drawn at random: where models that hold one by one do not hold together.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/hard_survey.h"
#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "simulate/render.h"

namespace chequer::bench {
namespace {

struct Request {
  HardSceneOptions scenes;
  int frames = 100;
  std::uint64_t first = 1;
  std::string keep;  ///< folder for frames with mistakes; empty: none is kept
};

struct Tally {
  int boards = 0, found = 0, read = 0, wrong = 0, ambiguous = 0, gross = 0;
  double position = 0, orientation = 0;  ///< sums of squared errors

  void Print(const std::string& name) const {
    const double n = std::max(boards, 1), posed = std::max(found - ambiguous, 1);
    fmt::print("{:<12} {:6d} {:6.3f} {:6.3f} {:6d} {:7d} {:8.4f}  {:7.2f} {:7.2f}\n", name, boards, found / n, read / n,
               wrong, gross, gross / posed, position / posed, orientation / posed);
  }
};

/// Counts a board that was found. Prints how it fared and returns true if its id is wrong or its error gross.
bool Count(const SceneMarker& marker, const MarkerPose& pose, const std::vector<Tally*>& tallies) {
  const Squares squares = SquaresOf(marker.camera_from_marker, pose);
  const bool wrong = pose.id && *pose.id != marker.board.id, ambiguous = pose.Has(Warning::kAmbiguous),
             gross = !ambiguous && squares.largest() > kGross;
  for (Tally* tally : tallies) {
    ++tally->found;
    tally->read += pose.id.has_value();
    tally->wrong += wrong;
    tally->ambiguous += ambiguous;
    tally->gross += gross;
    if (ambiguous) continue;
    tally->position += std::min(squares.position, kMostSquare);
    tally->orientation += std::min(squares.orientation, kMostSquare);
  }
  if (!wrong && !gross) return false;
  fmt::print("{}squared errors {:.1f} {:.1f}, {} corners, ", wrong ? "wrong id, " : "", squares.position,
             squares.orientation, pose.corners_used);
  return true;
}

class Survey {
 public:
  explicit Survey(const Request& request) : request_(request) {}

  void Run() {
    const std::uint64_t past = request_.first + static_cast<std::uint64_t>(request_.frames);
    for (std::uint64_t seed = request_.first; seed < past; ++seed) Look(seed);
    fmt::print("{:<12} {:>6} {:>6} {:>6} {:>6} {:>7} {:>8}  {:>7} {:>7}\n", "condition", "boards", "found", "read",
               "wrong", "gross", "share", "sq/pos", "sq/rot");
    tallies_.Print();
    if (ghosts_ > 0) fmt::print("{} poses where no board is\n", ghosts_);
  }

 private:
  void Look(std::uint64_t seed) {
    const HardFrame frame = DrawHardFrame(request_.scenes, seed);
    const DetectorOptions options = OptionsFor(frame.render.camera, request_.scenes.variant);
    const std::vector<SceneMarker>& markers = frame.scene.markers;
    for (std::size_t i = 0; i < markers.size(); ++i)
      for (Tally* tally : tallies_.Of(frame.conditions[i])) ++tally->boards;
    const Image image = Render(frame.scene, frame.render, seed);
    bool mistaken = false;
    for (const MarkerPose& pose : Detector(options).Detect(image.view())) {
      const std::optional<std::size_t> board = frame.BoardOf(pose.camera_from_marker);
      if (!board) {
        ++ghosts_;
        continue;
      }
      const std::vector<const char*>& conditions = frame.conditions[*board];
      if (!Count(markers[*board], pose, tallies_.Of(conditions))) continue;
      fmt::print("frame {} board {}: {}\n", seed, *board, fmt::join(conditions, ", "));
      mistaken = true;
    }
    if (mistaken && !request_.keep.empty()) Keep(frame, image, seed);
  }

  /// Keeps a frame with a mistake and its camera, so that others can look at it.
  void Keep(const HardFrame& frame, const Image& image, std::uint64_t seed) const {
    namespace fs = std::filesystem;
    fs::create_directories(request_.keep);
    const auto file = [&](const char* end) { return fs::path(request_.keep) / fmt::format("{}.{}", seed, end); };
    KeepFrame(file("png"), image);
    WriteCamera(file("toml"), frame.render.camera);
  }

  const Request request_;
  Tallies<Tally> tallies_;
  int ghosts_ = 0;
};

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  CLI::App app(
      "Boards in several hard conditions at once, drawn at random: how many are found and read, and how large their\n"
      "errors are against their covariances, for each condition. Lists wrong ids and gross errors.");
  chequer::bench::Request request;
  app.add_option("--frames", request.frames, "Frames, of one to nine boards")->capture_default_str();
  AddSceneOptions(app, request.scenes, request.first);
  app.add_option_function<std::string>(
         "--variant",
         [&](const std::string& name) {
           const auto variant = chequer::ParseVariant(name);
           if (!variant) throw CLI::ValidationError("--variant", "no variant is called " + name);
           request.scenes.variant = *variant;
         },
         "How ids are coded: unconstrained ids are wrong with every cell that is")
      ->default_str("secded");
  app.add_option("--keep", request.keep,
                 "Folder for frames with mistakes, as SEED.png, each with its camera, SEED.toml");
  CLI11_PARSE(app, argc, argv);
  chequer::bench::Survey(request).Run();
}
