#include "world/tie_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/rotations.h"

namespace chequer {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// How flat a sheet lies on a floor and how well it is aligned by hand: 2 degrees each. Positions that are exact to a
/// millimetre outweigh it as soon as they span some centimetres.
constexpr double kFlatRad = 0.035, kHeadingRad = 0.035;
/// A seen orientation that disagrees more, standard deviations, counts no further: it may be a mirrored pose.
constexpr double kMostDisagreement = 3;
/// Places whose spread across their line is below this share of it lie on a line.
constexpr double kOnALine = 0.02;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// What is added up for Gauss-Newton.
struct Normal {
  Matrix6d matrix = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
  void Add(double residual, const Vector6d& row, double sigma) {
    const double beyond = std::max(1.0, std::abs(residual) / (kMostDisagreement * sigma));
    const double weight = 1 / (sigma * sigma * beyond);
    matrix += weight * row * row.transpose();
    gradient += weight * row * residual;
  }
};

double OrientationSigma(const Tie& tie, double sigma) {
  return std::sqrt(sigma * sigma + tie.marker.covariance.bottomRightCorner<3, 3>().trace() / 3);
}

double AddPosition(const Tie& tie, const RigidTransform& world_from_camera, double sigma_m, Normal& normal) {
  const Eigen::Matrix3d rotation = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d turned = rotation * tie.marker.camera_from_marker.translation;
  const Eigen::Matrix3d covariance = rotation * tie.marker.covariance.topLeftCorner<3, 3>() * rotation.transpose() +
                                     sigma_m * sigma_m * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d weight = covariance.inverse();
  Eigen::Matrix<double, 3, 6> by;
  by << Eigen::Matrix3d::Identity(), -Cross(turned);
  const Eigen::Vector3d offset = Offset(tie, world_from_camera);
  normal.matrix += by.transpose() * weight * by;
  normal.gradient += by.transpose() * weight * offset;
  return offset.dot(weight * offset);
}

void AddOrientation(const Tie& tie, const RigidTransform& world_from_camera, Normal& normal) {
  if (!tie.said.lies_flat) return;
  const Eigen::Quaterniond seen = world_from_camera.rotation * tie.marker.camera_from_marker.rotation;
  const Eigen::Vector3d up = seen * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3d up_by_turn = -Cross(up);
  for (int axis = 0; axis < 2; ++axis) {
    Vector6d row = Vector6d::Zero();
    row.tail<3>() = up_by_turn.row(axis).transpose();
    normal.Add(up[axis], row, OrientationSigma(tie, kFlatRad));
  }
  if (!tie.said.heading_rad) return;
  const Eigen::Vector3d x = seen * Eigen::Vector3d::UnitX();
  Vector6d row = Vector6d::Zero();
  row[5] = 1;
  normal.Add(std::remainder(std::atan2(x.y(), x.x()) - *tie.said.heading_rad, 2 * M_PI), row,
             OrientationSigma(tie, kHeadingRad));
}

struct Centered {
  Eigen::Matrix3Xd seen, said;
  Eigen::Vector3d seen_mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d said_mean = Eigen::Vector3d::Zero();
};

Centered Center(std::span<const Tie> ties) {
  Centered c;
  c.seen.resize(3, static_cast<Eigen::Index>(ties.size()));
  c.said.resize(3, c.seen.cols());
  for (Eigen::Index i = 0; i < c.seen.cols(); ++i) {
    const Tie& tie = ties[static_cast<std::size_t>(i)];
    c.seen.col(i) = tie.marker.camera_from_marker.translation;
    c.said.col(i) = tie.said.position_in_world;
  }
  c.seen_mean = c.seen.rowwise().mean();
  c.said_mean = c.said.rowwise().mean();
  c.seen.colwise() -= c.seen_mean;
  c.said.colwise() -= c.said_mean;
  return c;
}

/// The rotation that takes places as seen to places as said (Kabsch 1976). Nothing where they lie on a line.
std::optional<Eigen::Quaterniond> RotationFromPlaces(const Centered& c) {
  if (c.seen.cols() < 3) return std::nullopt;
  const NearestRotation nearest = FindNearestRotation(c.said * c.seen.transpose());
  if (nearest.scales[1] < kOnALine * kOnALine * nearest.scales[0]) return std::nullopt;
  return Eigen::Quaterniond(nearest.rotation);
}

/// The same with what faces and headings say: up from the boards that lie flat, the turn about it from places.
Eigen::Quaterniond RotationFromFaces(std::span<const Tie> ties, const Centered& c) {
  Eigen::Vector3d up_in_camera = Eigen::Vector3d::Zero();
  for (const Tie& tie : ties)
    if (tie.said.lies_flat) up_in_camera += tie.marker.camera_from_marker.rotation * Eigen::Vector3d::UnitZ();
  if (up_in_camera.norm() < 1e-9) up_in_camera = -Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond upright = RotationBetween(up_in_camera, Eigen::Vector3d::UnitZ());
  double sine = 0, cosine = 0;
  for (Eigen::Index i = 0; i < c.seen.cols(); ++i) {
    const Eigen::Vector3d from = upright * c.seen.col(i), to = c.said.col(i);
    sine += from.x() * to.y() - from.y() * to.x();
    cosine += from.x() * to.x() + from.y() * to.y();
  }
  for (const Tie& tie : ties) {
    if (ties.size() > 1 || !tie.said.heading_rad) continue;
    const Eigen::Vector3d x = upright * (tie.marker.camera_from_marker.rotation * Eigen::Vector3d::UnitX());
    const double turn = *tie.said.heading_rad - std::atan2(x.y(), x.x());
    sine = std::sin(turn);
    cosine = std::cos(turn);
  }
  return RotationFromVector({0, 0, std::atan2(sine, cosine)}) * upright;
}

RigidTransform Start(std::span<const Tie> ties) {
  const Centered c = Center(ties);
  RigidTransform start;
  start.rotation = RotationFromPlaces(c).value_or(RotationFromFaces(ties, c));
  start.translation = c.said_mean - start.rotation * c.seen_mean;
  return start;
}

}  // namespace

Eigen::Vector3d Offset(const Tie& tie, const RigidTransform& world_from_camera) {
  return world_from_camera * tie.marker.camera_from_marker.translation - tie.said.position_in_world;
}

double OffsetLimit(const Tie& tie, double sigma_m) {
  return 5 * sigma_m + 3 * std::sqrt(tie.marker.covariance.topLeftCorner<3, 3>().trace());
}

bool AllAgree(std::span<const Tie> ties, const RigidTransform& world_from_camera, double sigma_m) {
  return std::all_of(ties.begin(), ties.end(), [&](const Tie& tie) {
    return Offset(tie, world_from_camera).norm() <= OffsetLimit(tie, sigma_m);
  });
}

double ScaleOf(std::span<const Tie> ties) {
  const Centered c = Center(ties);
  const double said = c.said.norm();
  return said > 0 && ties.size() > 1 ? c.seen.norm() / said : 1.0;
}

TieFit FitTies(std::span<const Tie> ties, double sigma_m) {
  TieFit fit;
  fit.world_from_camera = Start(ties);
  Normal normal;
  for (int pass = 0; pass < 30; ++pass) {
    normal = Normal();
    fit.chi_square = 0;
    for (const Tie& tie : ties) {
      fit.chi_square += AddPosition(tie, fit.world_from_camera, sigma_m, normal);
      AddOrientation(tie, fit.world_from_camera, normal);
    }
    const Vector6d step = normal.matrix.ldlt().solve(-normal.gradient);
    if (!step.allFinite()) break;
    fit.world_from_camera.translation += step.head<3>();
    fit.world_from_camera.rotation = (RotationFromVector(step.tail<3>()) * fit.world_from_camera.rotation).normalized();
    if (step.norm() < 1e-12) break;
  }
  fit.world_from_camera.rotation = Canonical(fit.world_from_camera.rotation);
  fit.covariance = normal.matrix.ldlt().solve(Matrix6d::Identity());
  // Where the places turn out to be less exact than was said, so is the result.
  const double freedom = 3.0 * static_cast<double>(ties.size()) - 6;
  if (freedom > 0) fit.covariance *= std::max(1.0, fit.chi_square / freedom);
  return fit;
}

}  // namespace chequer
