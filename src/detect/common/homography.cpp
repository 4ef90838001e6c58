#include "detect/common/homography.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// Shift and scale that bring points to mean 0 and a root mean square distance of √2.
struct Normalization {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double scale = 1;

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const { return scale * (p - mean); }
  Eigen::Matrix3d Matrix() const {
    return (Eigen::Matrix3d() << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1).finished();
  }
  Eigen::Matrix3d Inverse() const {
    return (Eigen::Matrix3d() << 1 / scale, 0, mean.x(), 0, 1 / scale, mean.y(), 0, 0, 1).finished();
  }
};

Normalization Normalize(std::span<const PointPair> pairs, Eigen::Vector2d PointPair::*member) {
  Normalization n;
  for (const PointPair& pair : pairs) n.mean += pair.*member;
  n.mean /= static_cast<double>(pairs.size());
  double square = 0;
  for (const PointPair& pair : pairs) square += (pair.*member - n.mean).squaredNorm();
  n.scale = std::sqrt(2.0 * static_cast<double>(pairs.size()) / std::max(square, 1e-24));
  return n;
}

}  // namespace

std::optional<Eigen::Matrix3d> FitHomography(std::span<const PointPair> pairs) {
  if (pairs.size() < 4) return std::nullopt;
  const Normalization from = Normalize(pairs, &PointPair::from), to = Normalize(pairs, &PointPair::to);
  // Each pair adds the rows (p, 0, −u p') and (0, p, −v p') with p = (x, y, 1), p' = (x, y) to the design; their normal
  // matrix is made of the same moments of p weighted with 1, u, v and u² + v².
  // Each moment is symmetric: its upper triangle, row by row.
  using Moment = Eigen::Array<double, 6, 1>;
  Moment plain_sum = Moment::Zero(), by_u_sum = plain_sum, by_v_sum = plain_sum, by_square_sum = plain_sum;
  for (const PointPair& pair : pairs) {
    const Eigen::Vector2d p = from(pair.from), q = to(pair.to);
    Moment moment;
    moment << p.x() * p.x(), p.x() * p.y(), p.x(), p.y() * p.y(), p.y(), 1;
    plain_sum += moment;
    by_u_sum += q.x() * moment;
    by_v_sum += q.y() * moment;
    by_square_sum += q.squaredNorm() * moment;
  }
  const auto whole = [](const Moment& m) {
    return (Eigen::Matrix3d() << m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]).finished();
  };
  const Eigen::Matrix3d plain = whole(plain_sum), by_u = whole(by_u_sum), by_v = whole(by_v_sum),
                        by_square = whole(by_square_sum);
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  normal.block<3, 3>(0, 0) = plain;
  normal.block<3, 3>(3, 3) = plain;
  normal.block<2, 3>(6, 0) = -by_u.topRows<2>();
  normal.block<2, 3>(6, 3) = -by_v.topRows<2>();
  normal.block<2, 2>(6, 6) = by_square.topLeftCorner<2, 2>();
  normal.block<3, 2>(0, 6) = normal.block<2, 3>(6, 0).transpose();
  normal.block<3, 2>(3, 6) = normal.block<2, 3>(6, 3).transpose();
  Eigen::Matrix<double, 8, 1> right;
  right << by_u.col(2), by_v.col(2), -by_square.col(2).head<2>();
  const SmallCholesky<8> solver(normal);
  if (!solver.IsSound(1e-9)) return std::nullopt;
  const Eigen::Matrix<double, 8, 1> h = solver.Solve(right);
  Eigen::Matrix3d normalized;
  normalized << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], 1;
  Eigen::Matrix3d homography = to.Inverse() * normalized * from.Matrix();
  if (!homography.allFinite() || std::abs(homography(2, 2)) < 1e-12) return std::nullopt;
  homography /= homography(2, 2);
  return homography;
}

}  // namespace chequer
