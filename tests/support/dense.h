#pragma once

#include <Eigen/Core>

namespace chequer::test {

// For matrices of any size, compiled once for all tests: every size that Eigen inverts or multiplies as one of its own
// takes half a second to compile, or a whole one.

Eigen::MatrixXd Inverse(const Eigen::MatrixXd& matrix);
/// a b
Eigen::MatrixXd Product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// a b aᵀ
Eigen::MatrixXd Sandwich(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
/// errorᵀ covariance⁻¹ error: χ² of so many degrees of freedom as there are errors.
double SquareOver(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance);
/// Errors with that covariance, or that information, from white noise of variance 1.
Eigen::VectorXd WithCovariance(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& white);
Eigen::VectorXd WithInformation(const Eigen::MatrixXd& information, const Eigen::VectorXd& white);

}  // namespace chequer::test
