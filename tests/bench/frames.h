#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/bound.h"
#include "bench/prints.h"
#include "bench/score.h"
#include "chequer/camera_model.h"
#include "chequer/image.h"

namespace chequer::bench {

/// A frame in memory, with what is truly to be seen.
struct BenchFrame {
  std::string condition;       ///< frames of one condition are scored together
  Image colour;                ///< BGR8
  std::optional<Image> bayer;  ///< the same exposure, raw
  std::vector<TrueMarker> truth;
};

/// The same kind of scene for every pattern.
struct Suite {
  std::string name;
  double side_m = 0;  ///< of the boards' sides as the patterns define them
  CameraModel camera;
  bool straight_tracks = false;  ///< the markers of a condition stand on a straight line, in one orientation
  /// Between frames, where they are those of a stream; 0: they have nothing to do with each other.
  std::chrono::nanoseconds interval{0};
  std::map<Pattern, std::vector<BenchFrame>> frames;
  /// By condition, where the noise of the frames is known: what is possible with our boards at best.
  std::map<std::string, ErrorBounds> bounds;

  bool HasMarkers() const;
};

/// Side of the markers of the suites that have a name here: paper, stress, stream1 0.12 m, swarm50, swarm100,
/// stream50 0.1 m, swarm200, stream200 0.08 m; 0.12 m otherwise.
double DefaultSide(std::string_view suite);

/// Reads FOLDER/PATTERN/{camera.json,truth.jsonl,*.png,raw_*.png}; patterns without a folder are left out. raw_X.png is
/// the BayerRG8 exposure of X.png. Throws std::runtime_error naming the file and what is wrong.
Suite LoadSuite(const std::filesystem::path& folder, double side_m, const std::vector<Print>& prints);

/// Names that RenderSuite knows.
std::vector<std::string> RenderedSuites();

/// Renders a suite: the same scenes in all prints, colour and raw. Throws std::runtime_error on an unknown name,
/// listing those that exist.
Suite RenderSuite(std::string_view name, std::uint64_t seed, const std::vector<Print>& prints);

}  // namespace chequer::bench
