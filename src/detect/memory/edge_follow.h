#pragma once

#include <Eigen/Core>
#include <optional>

#include "detect/boards/boards.h"
#include "detect/common/board_geometry.h"
#include "detect/common/light.h"

namespace chequer {

/// Whether a board's cells are large enough for that: of smaller ones, FindOwnShift() tells.
bool HasEdgesToFollow(const AnchoredBoard& board, const Lens& lens);

/// Where a board lies that is up to a quarter of a cell, or 1.5 px, from where it is expected: by the light at edges
/// between its cells, each of which tells how far off it is. Right to two fifths of the way, or 0.25 px (measured).
/// Fits that start there take fewer steps, and keep the pixels that were chosen for them. Nothing where it lies as
/// expected, by the edges along its rim at first, or most edges do not agree. Of 36 cells, takes 9,000 instructions by
/// the rim, 20,000 by all (measured). Nothing of cells that are too small for it.
std::optional<Eigen::Matrix3d> FollowEdges(const AnchoredBoard& board, const LightReader& reader, const Lens& lens);

}  // namespace chequer
