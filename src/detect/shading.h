#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "detect/board_equations.h"

namespace chequer {

/// The gradient of the light over a board: log light per cell, along x and y; by least squares over the levels of the
/// light cells, with an ink of its own for each phase and saturation. Nothing where the cells do not determine it or
/// differ too much for the model.
/// @param levels, saturated by cell, row by row. @param blue_phase phase that hardly sees yellow, −1 for none.
std::optional<Eigen::Vector2d> FindShading(MarkerSize size, std::span<const PhaseValues> levels,
                                           std::span<const std::uint8_t> saturated, int phases, int blue_phase);

}  // namespace chequer
