#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/hard_scenes.h"
#include "capture/png.h"
#include "capture/recording_writer.h"
#include "chequer/detector.h"
#include "core/convert.h"
#include "core/file.h"
#include "support/pose_errors.h"

// What surveys of hard frames have in common.

namespace chequer::bench {

/// A squared error over covariance and dimension beyond that is gross: one board in 20,000 where covariances are
/// honest.
constexpr double kGross = 8;
/// A squared error counts this much at most in means: one flipped pose would outweigh all others.
constexpr double kMostSquare = 20;

/// Squared errors over covariance and dimension.
struct Squares {
  double position = 0, orientation = 0;

  double largest() const { return std::max(position, orientation); }
  double mean() const { return (position + orientation) / 2; }
};

inline Squares SquaresOf(const RigidTransform& camera_from_marker, const MarkerPose& pose) {
  test::PoseErrors errors;
  errors.Add(camera_from_marker, pose);
  return {errors.position(), errors.orientation()};
}

/// A tally of all boards, and one for each condition.
template <class Tally>
class Tallies {
 public:
  Tally& all() { return all_; }
  /// Those that a board under such conditions counts for.
  std::vector<Tally*> Of(const std::vector<const char*>& conditions) {
    std::vector<Tally*> tallies{&all_};
    for (const char* name : conditions) tallies.push_back(&of_condition_[name]);
    return tallies;
  }
  void Print() const {
    all_.Print("all");
    for (const auto& [name, tally] : of_condition_) tally.Print(name);
  }

 private:
  Tally all_;
  std::map<std::string, Tally> of_condition_;
};

/// A detector's options for hard frames of one camera.
inline DetectorOptions OptionsFor(const CameraModel& camera, Variant variant) {
  DetectorOptions options;
  options.families = {{.code = MarkerCode({6, 6}, variant), .side_m = HardFrame::kSideM, .roster = {}}};
  options.camera = camera;
  return options;
}

/// Writes a frame as PNG; those of YUV formats, which PNG does not hold, as the BGR image that they are read as.
inline void KeepFrame(const std::filesystem::path& png, const Image& image) {
  const auto write = [&](const ImageView& view) { WriteFileAtomically(png, EncodeFrame(view, {})); };
  PngHolds(image.view().format()) ? write(image.view()) : write(ToBgr(image.view()).view());
}

/// The options of a command that say which frames are drawn.
inline void AddSceneOptions(CLI::App& app, HardSceneOptions& scenes, std::uint64_t& first) {
  app.add_option("--first", first, "First seed")->capture_default_str();
  app.add_option("--only", scenes.only, "Conditions that may be, comma-separated [all]")->delimiter(',');
  app.add_option("--share", scenes.share, "Of frames or boards that have each [its own]");
}

}  // namespace chequer::bench
