#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "chequer/detector.h"
#include "detect/common/light.h"
#include "detect/fit/fitted_board.h"
#include "detect/identity/identify.h"
#include "detect/pose/plane_pose.h"

namespace chequer {

/// Writes what a fit and the colours say of a marker, all but its pose, with the warnings that they call for.
/// @param identity of one of the options' families, whose size the board has.
void Describe(const FittedBoard& fitted, const Identity& identity, const DetectorOptions& options, const Lens& lens,
              MarkerPose& marker);

/// Gives a marker whose identity is not decided that of the board which was followed there.
/// @param family index into DetectorOptions::families.
void CarryIdentity(int family, std::uint64_t id, const DetectorOptions& options, MarkerPose& marker);

/// What a fit says of where a board of that size lies whose cells are that wide and high, with what its print and the
/// lens may be off.
BoardMeasurement MeasurementOf(const FittedBoard& fitted, MarkerSize size, const Eigen::Vector2d& cell_m,
                               const PrintTolerance& tolerance, const Lens& lens);

/// As PlanePoses.
std::optional<std::array<PlanePose, 2>> PosesOf(const BoardMeasurement& measured);

/// Adds the likelier of two poses, which this measurement led to, and how likely the other one is, which its covariance
/// allows for. Where even it leaves more unexplained than noise can be, the covariance is widened by as much (the ratio
/// of Birge 1932), and the warning set.
void DescribePose(const std::array<PlanePose, 2>& poses, const BoardMeasurement& measured, MarkerPose& marker);

}  // namespace chequer
