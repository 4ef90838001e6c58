#include "detect/banded.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>

namespace chequer {
namespace {

TEST(BandedSystem, SolvesAsADenseSolverDoes) {
  constexpr int kSize = 20, kBand = 5, kColumns = BandedSystem::kColumns;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  BandedSystem system;
  system.Reset(kSize, kBand);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(kSize, kSize), right(kSize, kColumns);
  for (int i = 0; i < kSize; ++i) {
    for (int j = std::max(0, i - kBand); j <= i; ++j) {
      matrix(i, j) = matrix(j, i) = i == j ? 2.0 * kBand : value(random);
      system.At(i, j) = matrix(i, j);
    }
    for (int c = 0; c < kColumns; ++c) right(i, c) = system.Rhs(i)[c] = value(random);
  }
  const Eigen::MatrixXd solution = matrix.llt().solve(right);
  system.Factor(0);
  system.SolveLower();
  // Products of half-solved columns have the inverse between them.
  double product = 0;
  for (int i = 0; i < kSize; ++i) product += system.Rhs(i)[0] * system.Rhs(i)[1];
  EXPECT_NEAR(product, right.col(0).dot(solution.col(1)), 1e-12);
  system.SolveUpper(2);
  for (int i = 0; i < kSize; ++i) EXPECT_NEAR(system.Rhs(i)[2], solution(i, 2), 1e-12) << "row " << i;
}

TEST(BandedSystem, UnknownsThatNothingHasSeenStayZero) {
  BandedSystem system;
  system.Reset(3, 1);
  system.At(0, 0) = 4;
  system.Rhs(0)[0] = 8;
  system.Factor(1e-3);
  system.SolveLower();
  system.SolveUpper(0);
  EXPECT_NEAR(system.Rhs(0)[0], 2, 1e-3);
  EXPECT_EQ(system.Rhs(2)[0], 0);
}

}  // namespace
}  // namespace chequer
