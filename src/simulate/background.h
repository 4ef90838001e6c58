#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "simulate/linear_image.h"

namespace chequer {

/// What lies behind the markers.
enum class BackgroundKind : std::uint8_t {
  kPlain,  ///< one colour
  kNoise,  ///< coloured noise at many scales, as concrete or carpet
  kChess,  ///< black, grey and coloured chessboards of many sizes, turned and sheared
  kText,   ///< strokes and letters
  kTiles,  ///< a floor of tiles with joints
  kWood,   ///< planks with grain
  kBlobs,  ///< discs and boxes of all colours, some as large as markers
  kMixed,  ///< patches of all the others
  kImage,  ///< an image file, cut to fill the frame
};

struct Background {
  BackgroundKind kind = BackgroundKind::kPlain;
  Eigen::Vector3f colour{0.35f, 0.35f, 0.35f};  ///< of kPlain: linear RGB, 0..1
  std::uint64_t seed = 0;                       ///< of the procedural kinds
  std::string file{};                           ///< of kImage

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// "plain", "noise", "chess", "text", "tiles", "wood", "blobs", "mixed", "image".
std::string_view BackgroundName(BackgroundKind kind);
std::optional<BackgroundKind> ParseBackground(std::string_view name);
/// The names of the kinds that need no file, comma-separated, for messages.
std::string BackgroundNames();

/// What the background reflects, pixel by pixel. Throws std::runtime_error naming the file where it cannot be read.
/// @pre background.Check() is empty.
LinearImage DrawBackground(const Background& background, int width, int height);

}  // namespace chequer
