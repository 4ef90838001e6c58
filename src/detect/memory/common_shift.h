#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "detect/boards/boards.h"
#include "detect/common/board_geometry.h"
#include "detect/common/light.h"

namespace chequer {

/// Boards that are asked, evenly among all: those of a few directions leave no other shift at which cells meet cells.
inline constexpr std::size_t kMostAskedForShift = 8;
/// Fewer may all have moved by themselves.
inline constexpr std::size_t kFewestAskedForShift = 3;

/// How far all boards of an image lie from where they are expected, image pixels: a camera that is knocked shifts them
/// alike. It is the shift of at most 16 px along each axis at which their light cells stand out most from the dark
/// ones, to about a pixel: near enough for a fit to start from, also with motion blur. Zero where none is clearly
/// better than none. Takes 0.35 million instructions for each board of 10 px cells that is asked (measured).
/// @param asked so many boards at most: kMostAskedForShift or fewer. @param cells workspace
Eigen::Vector2d FindCommonShift(std::span<const AnchoredBoard> boards, std::size_t asked, const LightReader& reader,
                                const Lens& lens, std::vector<float>& cells);

/// How far one board lies from where it is expected, image pixels: the shift of less than 4 px along each axis at which
/// its light cells stand out most from the dark ones, found as FindCommonShift() finds the one of all boards, and
/// finer; of cells of 9 px and more, less than 8 px, to 2 px. Zero where none is clearly better than none. Takes 84,000
/// instructions for 36 cells (measured). @param cells workspace
Eigen::Vector2d FindOwnShift(const AnchoredBoard& board, const LightReader& reader, const Lens& lens,
                             std::vector<float>& cells);

/// Michelson contrast of a board's light cells and its dark ones, as sampled: another exposure or illumination leaves
/// it as it was. 0 where no light shows.
double SampledContrast(const AnchoredBoard& board);

/// The homography of a board that lies so much farther on in the image.
Eigen::Matrix3d Shifted(const Eigen::Matrix3d& plane_from_board, const Eigen::Vector2d& shift_px, const Lens& lens);

}  // namespace chequer
