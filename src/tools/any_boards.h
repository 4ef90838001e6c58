#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "chequer/image.h"

namespace chequer {

/// A board that an image shows, whatever it is a marker of.
struct AnyBoard {
  Eigen::Vector2d center_px{0, 0};
  double reach_px = 0;  ///< from the centre to the outer corners, about
  MarkerSize size;
  /// As its cells were seen; nothing where some are in doubt.
  std::optional<std::uint64_t> kernel;
};

/// The boards that an image shows: of the sizes that are sought, then of all from 4x4 to 10x10. @param image BGR8.
/// @param mirrored whether those are found whose mirror image is a board.
std::vector<AnyBoard> FindAnyBoards(const ImageView& image, const DetectorOptions& sought, bool mirrored);

}  // namespace chequer
