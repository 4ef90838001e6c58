#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace chequer {

/// A point pair of a homography.
struct PointPair {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

/// The homography to ← from with the least squared algebraic error over normalised coordinates (Hartley 1997), its last
/// entry 1. Nothing with fewer than 4 pairs, or with pairs that do not determine it.
std::optional<Eigen::Matrix3d> FitHomography(std::span<const PointPair> pairs);

}  // namespace chequer
