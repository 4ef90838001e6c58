#include "world/estimate.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "world/contradiction.h"
#include "world/tie_fit.h"

namespace chequer {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// An L whose arms include an angle farther from a right one is something else than an L.
constexpr double kMostSkewRad = 3 * M_PI / 180;
/// Arms with a smaller angle determine no plane.
constexpr double kLeastAngleRad = 30 * M_PI / 180;

std::vector<Tie> TieUp(const ReferenceList& list, std::span<const StillMarker> seen, WorldEstimate& estimate) {
  std::vector<Tie> ties;
  for (const Reference& reference : list.references) {
    const auto match = std::find_if(seen.begin(), seen.end(), [&](const StillMarker& marker) {
      return marker.id == reference.id && marker.family == reference.family;
    });
    if (match == seen.end()) {
      estimate.unseen.push_back(reference.id);
      continue;
    }
    ties.push_back({reference, *match, static_cast<std::size_t>(match - seen.begin())});
  }
  return ties;
}

void CheckStandsStill(const StillMarker& marker, double limit_m) {
  if (marker.spread_m > limit_m)
    throw std::runtime_error(fmt::format(
        "marker {} moved by {:.0f} mm while it was watched, or there are two of it; references must stand still and be "
        "the only ones of their id",
        marker.id, marker.spread_m * 1000));
}

void CheckEnough(std::span<const Tie> ties, const ReferenceList& list) {
  if (ties.empty())
    throw std::runtime_error(
        fmt::format("none of the {} references is seen; are size, variant and ids right?", list.references.size()));
  if (ties.size() == 1 && !(ties[0].said.heading_rad && ties[0].said.lies_flat))
    throw std::runtime_error(fmt::format(
        "only reference {} is seen, and it has no heading; one needs a heading, two or more do not", ties[0].said.id));
}

std::vector<ReferenceResidual> Residuals(std::span<const Tie> ties, const TieFit& fit, double sigma_m) {
  std::vector<ReferenceResidual> residuals;
  for (const Tie& tie : ties) {
    ReferenceResidual residual;
    residual.seen = tie.seen;
    residual.offset_m = Offset(tie, fit.world_from_camera);
    residual.limit_m = OffsetLimit(tie, sigma_m);
    const Eigen::Quaterniond seen = fit.world_from_camera.rotation * tie.marker.camera_from_marker.rotation;
    const Eigen::Vector3d up = seen * Eigen::Vector3d::UnitZ(), x = seen * Eigen::Vector3d::UnitX();
    if (tie.said.lies_flat) residual.tilt_rad = std::acos(std::clamp(up.z(), -1.0, 1.0));
    if (tie.said.heading_rad)
      residual.heading_rad = std::remainder(std::atan2(x.y(), x.x()) - *tie.said.heading_rad, 2 * M_PI);
    residuals.push_back(residual);
  }
  return residuals;
}

double Rms(const std::vector<ReferenceResidual>& residuals) {
  double square = 0;
  for (const ReferenceResidual& residual : residuals) square += residual.offset_m.squaredNorm();
  return residuals.empty() ? 0 : std::sqrt(square / static_cast<double>(residuals.size()));
}

/// Covariance of what a function makes of poses, by its derivative: each pose is moved a little in each of its six
/// directions, with R_moved = Exp(θ) · R.
using WorldOfPoses = std::function<RigidTransform(std::span<const RigidTransform>)>;
Matrix6d Propagate(const WorldOfPoses& world, std::span<const StillMarker> markers) {
  constexpr double kStep = 1e-6;
  std::vector<RigidTransform> poses;
  for (const StillMarker& marker : markers) poses.push_back(marker.camera_from_marker);
  const RigidTransform center = world(poses);
  Matrix6d covariance = Matrix6d::Zero();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Matrix6d by;
    for (int k = 0; k < 6; ++k) {
      std::vector<RigidTransform> moved = poses;
      if (k < 3) moved[i].translation[k] += kStep;
      if (k >= 3) moved[i].rotation = RotationFromVector(kStep * Eigen::Vector3d::Unit(k - 3)) * moved[i].rotation;
      const RigidTransform there = world(moved);
      by.col(k) << (there.translation - center.translation) / kStep,
          VectorFromRotation(there.rotation * center.rotation.inverse()) / kStep;
    }
    covariance += by * markers[i].covariance * by.transpose();
  }
  return covariance;
}

RigidTransform WorldOfMarker(std::span<const RigidTransform> camera_from_marker) {
  RigidTransform world_from_camera = camera_from_marker[0].Inverse();
  world_from_camera.rotation = Canonical(world_from_camera.rotation);
  return world_from_camera;
}

RigidTransform WorldOfL(std::span<const RigidTransform> poses) {
  const Eigen::Vector3d origin = poses[0].translation;
  const Eigen::Vector3d x = (poses[1].translation - origin).normalized();
  const Eigen::Vector3d z = x.cross(poses[2].translation - origin).normalized();
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
  RigidTransform world_from_camera;
  world_from_camera.rotation = Canonical(Eigen::Quaterniond(rotation));
  world_from_camera.translation = -(rotation * origin);
  return world_from_camera;
}

void CheckL(std::span<const StillMarker, 3> seen, const RigidTransform& world_from_camera, double skew_rad) {
  if (std::abs(skew_rad) > M_PI / 2 - kLeastAngleRad)
    throw std::runtime_error(fmt::format("markers {}, {} and {} lie nearly on a line; an L has a right angle at {}",
                                         seen[0].id, seen[1].id, seen[2].id, seen[0].id));
  double up = 0;
  for (const StillMarker& marker : seen)
    up += (world_from_camera.rotation * (marker.camera_from_marker.rotation * Eigen::Vector3d::UnitZ())).z();
  if (up < 0)
    throw std::runtime_error(
        fmt::format("the L is left-handed: seen from above, marker {} must lie a quarter turn counter-clockwise from "
                    "marker {}; swap the two",
                    seen[2].id, seen[1].id));
  if (std::abs(skew_rad) > kMostSkewRad)
    throw std::runtime_error(
        fmt::format("the arms of the L include {:.2f} degrees at marker {}; they must include 90 to within 3 degrees: "
                    "is the corner "
                    "named first, and do all three lie on the floor?",
                    90 - skew_rad * 180 / M_PI, seen[0].id));
}

}  // namespace

WorldEstimate EstimateFromReferences(const ReferenceList& list, std::span<const StillMarker> seen) {
  WorldEstimate estimate;
  const std::vector<Tie> ties = TieUp(list, seen, estimate);
  CheckEnough(ties, list);
  for (const Tie& tie : ties) CheckStandsStill(tie.marker, OffsetLimit(tie, list.sigma_m));
  const TieFit fit = FitTies(ties, list.sigma_m);
  if (!AllAgree(ties, fit.world_from_camera, list.sigma_m) ||
      (IsUpsideDown(ties, fit.world_from_camera) && IsMirrored(ties, list.sigma_m)))
    throw std::runtime_error(ExplainContradiction(ties, list.sigma_m));
  estimate.world_from_camera = fit.world_from_camera;
  estimate.covariance = fit.covariance;
  estimate.residuals = Residuals(ties, fit, list.sigma_m);
  estimate.rms_m = Rms(estimate.residuals);
  return estimate;
}

WorldEstimate EstimateFromMarker(const StillMarker& origin) {
  CheckStandsStill(origin, ReferenceList().sigma_m * 5);
  WorldEstimate estimate;
  estimate.world_from_camera = WorldOfMarker(std::span(&origin.camera_from_marker, 1));
  estimate.covariance = Propagate(WorldOfMarker, std::span(&origin, 1));
  estimate.residuals.resize(1);
  return estimate;
}

WorldEstimate EstimateFromL(std::span<const StillMarker, 3> seen) {
  for (const StillMarker& marker : seen) CheckStandsStill(marker, ReferenceList().sigma_m * 5);
  const std::array poses{seen[0].camera_from_marker, seen[1].camera_from_marker, seen[2].camera_from_marker};
  WorldEstimate estimate;
  estimate.world_from_camera = WorldOfL(poses);
  const Eigen::Vector3d third = estimate.world_from_camera * poses[2].translation;
  const double skew_rad = std::atan2(third.x(), third.y());
  CheckL(seen, estimate.world_from_camera, skew_rad);
  estimate.covariance = Propagate(WorldOfL, seen);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Eigen::Quaterniond turned = estimate.world_from_camera.rotation * poses[i].rotation;
    const double up = (turned * Eigen::Vector3d::UnitZ()).z();
    ReferenceResidual residual;
    residual.seen = i;
    residual.tilt_rad = std::acos(std::clamp(up, -1.0, 1.0));
    if (i == 2) residual.offset_m = {third.x(), 0, 0};
    estimate.residuals.push_back(residual);
  }
  estimate.rms_m = Rms(estimate.residuals);
  return estimate;
}

}  // namespace chequer
