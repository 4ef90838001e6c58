// Boards in several hard conditions at once, drawn at random: where models that hold one by one do not hold together.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "chequer/detector.h"
#include "core/file.h"
#include "simulate/board.h"
#include "simulate/random.h"
#include "simulate/render.h"
#include "support/pose_errors.h"

namespace chequer {
namespace {

/// A squared error over covariance and dimension beyond that is gross: one board in 20,000 where covariances are
/// honest.
constexpr double kGross = 8;
/// A squared error counts this much at most in means: one flipped pose would outweigh all others.
constexpr double kMostSquare = 20;
constexpr double kSideM = 0.12, kFocalPx = 1000;
constexpr int kWidth = 640, kHeight = 480;

double Turn(Random& random) { return random.Uniform(0, 2 * std::numbers::pi); }

/// Of a frame, or of the print that all its boards are of.
struct FrameCondition {
  const char* name;
  double share;  ///< of frames
  void (*apply)(Random&, RenderOptions&, std::vector<SceneMarker>&);
};

constexpr FrameCondition kFrameConditions[] = {
    {"blur", 0.15, [](Random& random, RenderOptions& to, auto&) { to.blur_sigma_px = random.Uniform(1, 2.2); }},
    {"noise", 0.15,
     [](Random& random, RenderOptions& to, auto&) { to.sensor.full_well_electrons = random.LogUniform(300, 3000); }},
    {"dark", 0.12, [](Random& random, RenderOptions& to, auto&) { to.sensor.exposure = random.Uniform(0.06, 0.4); }},
    {"overexposed", 0.1,
     [](Random& random, RenderOptions& to, auto&) { to.sensor.exposure = random.Uniform(1.1, 1.7); }},
    {"haze", 0.15, [](Random& random, RenderOptions& to, auto&) { to.lighting.haze = random.Uniform(0.05, 0.35); }},
    {"balance", 0.2,
     [](Random& random, RenderOptions& to, auto&) {
       to.sensor.white_balance = {random.Uniform(0.75, 1.3), 1, random.Uniform(0.75, 1.3)};
     }},
    {"vignetting", 0.2,
     [](Random& random, RenderOptions& to, auto&) { to.lighting.vignetting = random.Uniform(0.1, 0.6); }},
    {"motion", 0.3,
     [](Random& random, RenderOptions& to, auto&) {
       to.motion_px = random.Uniform(0.5, 10);
       to.motion_angle_rad = Turn(random);
     }},
    {"jpeg", 0.1,
     [](Random& random, RenderOptions& to, auto&) {
       to.format = PixelFormat::kBgr8;
       to.jpeg_quality = static_cast<int>(random.Uniform(60, 96));
     }},
    {"shadow", 0.25,
     [](Random& random, RenderOptions& to, auto&) {
       to.shadow = {.takes = random.Uniform(0.2, 0.85),
                    .direction_rad = Turn(random),
                    .through_x = kWidth * random.Uniform(0.25, 0.75),
                    .through_y = kHeight * random.Uniform(0.25, 0.75),
                    .width_px = random.LogUniform(0.5, 12)};
     }},
    {"ink", 0.3,
     [](Random& random, RenderOptions&, std::vector<SceneMarker>& markers) {
       const double cells = random.Uniform(0.02, 0.12);
       for (SceneMarker& marker : markers) marker.ink_spread_cells = cells;
     }},
};

/// A side, a corner or a strip across the board, of one colour or in patches.
void Cover(Random& random, SceneMarker& marker) {
  const double part = random.Uniform(0.05, 0.45), from = random.Uniform(-0.1, 0.8);
  const Occluder kinds[] = {{.from = {-0.1, -0.1}, .to = {1.1, part}},
                            {.from = {1 - part, -0.1}, .to = {1.1, 1.1}},
                            {.from = {-0.1, -0.1}, .to = {part, part}},
                            {.from = {from, -0.1}, .to = {from + part / 2, 1.1}}};
  Occluder cover = kinds[random.Below(4)];
  cover.patches = random.Below(2) == 0 ? 0 : 8;
  for (float& value : cover.colour) value = static_cast<float>(random.Uniform(0.02, 0.8));
  cover.seed = random.Bits();
  marker.occluders.push_back(cover);
}

struct BoardCondition {
  const char* name;
  double share;  ///< of boards
  void (*apply)(Random&, SceneMarker&);
};

constexpr BoardCondition kBoardConditions[] = {
    {"tilt", 0.3,
     [](Random& random, SceneMarker& marker) {
       marker.camera_from_marker =
           FacingPose(marker.camera_from_marker.translation, Turn(random), random.Uniform(0.3, 1.1), Turn(random));
     }},
    {"gradient", 0.15,
     [](Random& random, SceneMarker& marker) {
       marker.gradient = random.Uniform(0.2, 0.7);
       marker.gradient_angle_rad = Turn(random);
     }},
    {"gloss", 0.08,
     [](Random& random, SceneMarker& marker) {
       marker.highlight = {.strength = random.Uniform(0.1, 0.8),
                           .at = {random.Uniform(), random.Uniform()},
                           .sigma = random.Uniform(0.1, 0.4)};
     }},
    {"cover", 0.2, Cover},
};

struct Request {
  std::vector<std::string> only;  ///< conditions that may be; empty: all
  double share = 0;               ///< of frames or boards that have each; 0: its own
  int frames = 100;
  std::uint64_t first = 1;
  Variant variant = Variant::kSecded;
  std::string keep;  ///< folder for frames with mistakes; empty: none is kept
};

struct DrawnFrame {
  Scene scene;
  RenderOptions render;
  std::vector<std::vector<const char*>> conditions;  ///< by marker
};

/// One to nine boards, by their size, each in a place of its own.
void PlaceBoards(Random& random, const MarkerCode& code, Scene& scene) {
  const double side_px = random.LogUniform(30, 200), ids = static_cast<double>(code.max_id()) + 1;
  const int across = side_px < 60 ? 3 : side_px < 120 ? 2 : 1;
  const InkSet inks = *NamedInks(std::array{"laser", "inkjet", "matte"}[static_cast<std::size_t>(random.Below(3))]);
  for (int i = 0; i < across * across; ++i) {
    SceneMarker marker;
    marker.board = MakeBoard(code, static_cast<std::uint64_t>(random.Uniform() * ids));
    marker.side_m = kSideM;
    marker.inks = inks;
    const double depth = kSideM * kFocalPx / side_px * random.Uniform(0.95, 1.1), m_per_px = depth / kFocalPx,
                 x = (i % across + random.Uniform(0.45, 0.55)) * kWidth / across - 0.5 * kWidth,
                 y = (i / across + random.Uniform(0.45, 0.55)) * kHeight / across - 0.5 * kHeight;
    marker.camera_from_marker =
        FacingPose({x * m_per_px, y * m_per_px, depth}, Turn(random), random.Uniform(0, 0.3), Turn(random));
    scene.markers.push_back(std::move(marker));
  }
}

DrawnFrame Draw(const Request& request, const MarkerCode& code, std::uint64_t seed) {
  Random random(900000 + seed);
  DrawnFrame frame;
  RenderOptions& render = frame.render;
  render.camera = {
      .width = kWidth, .height = kHeight, .fx = kFocalPx, .fy = kFocalPx, .cx = 0.5 * kWidth, .cy = 0.5 * kHeight};
  render.camera.kind = CameraModel::Kind::kBrownConrady;
  render.camera.distortion = {-0.1, 0.02, 0, 0, 0};
  render.blur_sigma_px = random.Uniform(0.5, 1);
  render.sensor.full_well_electrons = random.LogUniform(3000, 20000);
  render.sensor.exposure = random.Uniform(0.5, 1.05);
  if (random.Below(2) == 0) render.format = PixelFormat::kBayerRg8;
  constexpr BackgroundKind kKinds[] = {BackgroundKind::kPlain, BackgroundKind::kNoise, BackgroundKind::kTiles,
                                       BackgroundKind::kWood};
  frame.scene.background.kind = kKinds[random.Below(4)];
  frame.scene.background.seed = random.Bits();
  PlaceBoards(random, code, frame.scene);
  const auto has = [&](const auto& condition) {
    const bool may = request.only.empty() ||
                     std::find(request.only.begin(), request.only.end(), condition.name) != request.only.end();
    return random.Uniform() < (request.share > 0 ? request.share : condition.share) && may;
  };
  std::vector<const char*> of_frame;
  for (const FrameCondition& condition : kFrameConditions) {
    if (!has(condition)) continue;
    condition.apply(random, render, frame.scene.markers);
    of_frame.push_back(condition.name);
  }
  for (SceneMarker& marker : frame.scene.markers) {
    frame.conditions.push_back(of_frame);
    for (const BoardCondition& condition : kBoardConditions) {
      if (!has(condition)) continue;
      condition.apply(random, marker);
      frame.conditions.back().push_back(condition.name);
    }
  }
  return frame;
}

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
  test::PoseErrors errors;
  errors.Add(marker.camera_from_marker, pose);
  const bool wrong = pose.id && *pose.id != marker.board.id, ambiguous = pose.Has(Warning::kAmbiguous),
             gross = !ambiguous && std::max(errors.position(), errors.orientation()) > kGross;
  for (Tally* tally : tallies) {
    ++tally->found;
    tally->read += pose.id.has_value();
    tally->wrong += wrong;
    tally->ambiguous += ambiguous;
    tally->gross += gross;
    if (ambiguous) continue;
    tally->position += std::min(errors.position(), kMostSquare);
    tally->orientation += std::min(errors.orientation(), kMostSquare);
  }
  if (!wrong && !gross) return false;
  fmt::print("{}squared errors {:.1f} {:.1f}, {} corners, ", wrong ? "wrong id, " : "", errors.position(),
             errors.orientation(), pose.corners_used);
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
    all_.Print("all");
    for (const auto& [name, tally] : tallies_) tally.Print(name);
    if (ghosts_ > 0) fmt::print("{} poses where no board is\n", ghosts_);
  }

 private:
  void Look(std::uint64_t seed) {
    const DrawnFrame frame = Draw(request_, code_, seed);
    DetectorOptions options;
    options.families = {{.code = code_, .side_m = kSideM, .roster = {}}};
    options.camera = frame.render.camera;
    const std::vector<SceneMarker>& markers = frame.scene.markers;
    for (std::size_t i = 0; i < markers.size(); ++i)
      for (Tally* tally : TalliesOf(frame.conditions[i])) ++tally->boards;
    const Image image = Render(frame.scene, frame.render, seed);
    bool mistaken = false;
    for (const MarkerPose& pose : Detector(options).Detect(image.view())) {
      const auto far = [&](const SceneMarker& marker) {
        return (pose.camera_from_marker.translation.hnormalized() - marker.camera_from_marker.translation.hnormalized())
            .norm();
      };
      const auto there = std::min_element(markers.begin(), markers.end(),
                                          [&](const auto& a, const auto& b) { return far(a) < far(b); });
      if (far(*there) > kSideM / there->camera_from_marker.translation.z() / 2) {
        ++ghosts_;
        continue;
      }
      const std::size_t board = static_cast<std::size_t>(there - markers.begin());
      if (!Count(*there, pose, TalliesOf(frame.conditions[board]))) continue;
      fmt::print("frame {} board {}: {}\n", seed, board, fmt::join(frame.conditions[board], ", "));
      mistaken = true;
    }
    if (mistaken && !request_.keep.empty()) Keep(frame, image, seed);
  }

  /// Keeps a frame with a mistake and its camera, so that others can look at it.
  void Keep(const DrawnFrame& frame, const Image& image, std::uint64_t seed) const {
    namespace fs = std::filesystem;
    fs::create_directories(request_.keep);
    const auto file = [&](const char* end) { return fs::path(request_.keep) / fmt::format("{}.{}", seed, end); };
    WriteFileAtomically(file("png"), EncodeFrame(image.view(), {}));
    WriteCamera(file("toml"), frame.render.camera);
  }

  std::vector<Tally*> TalliesOf(const std::vector<const char*>& conditions) {
    std::vector<Tally*> tallies{&all_};
    for (const char* name : conditions) tallies.push_back(&tallies_[name]);
    return tallies;
  }

  const Request request_;
  const MarkerCode code_{{6, 6}, request_.variant};
  Tally all_;
  std::map<std::string, Tally> tallies_;
  int ghosts_ = 0;
};

}  // namespace
}  // namespace chequer

int main(int argc, char** argv) {
  CLI::App app(
      "Boards in several hard conditions at once, drawn at random: how many are found and read, and how large their\n"
      "errors are against their covariances, for each condition. Lists wrong ids and gross errors.");
  chequer::Request request;
  app.add_option("--frames", request.frames, "Frames, of one to nine boards")->capture_default_str();
  app.add_option("--first", request.first, "First seed")->capture_default_str();
  app.add_option("--only", request.only, "Conditions that may be, comma-separated [all]")->delimiter(',');
  app.add_option("--share", request.share, "Of frames or boards that have each [its own]");
  app.add_option_function<std::string>(
         "--variant",
         [&](const std::string& name) {
           const auto variant = chequer::ParseVariant(name);
           if (!variant) throw CLI::ValidationError("--variant", "no variant is called " + name);
           request.variant = *variant;
         },
         "How ids are coded: unconstrained ids are wrong with every cell that is")
      ->default_str("secded");
  app.add_option("--keep", request.keep,
                 "Folder for frames with mistakes, as SEED.png, each with its camera, SEED.toml");
  CLI11_PARSE(app, argc, argv);
  chequer::Survey(request).Run();
}
