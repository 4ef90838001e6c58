#include "support/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace chequer::test {

Eigen::MatrixXd Inverse(const Eigen::MatrixXd& matrix) { return matrix.inverse(); }

Eigen::MatrixXd Product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b; }

Eigen::MatrixXd Sandwich(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * b * a.transpose(); }

double SquareOver(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
  return error.dot(covariance.inverse() * error);
}

Eigen::VectorXd WithCovariance(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& white) {
  return covariance.llt().matrixL() * white;
}

Eigen::VectorXd WithInformation(const Eigen::MatrixXd& information, const Eigen::VectorXd& white) {
  // With information = L Lᵀ, L⁻ᵀ makes white noise into that of the covariance.
  return information.llt().matrixU().solve(white);
}

}  // namespace chequer::test
