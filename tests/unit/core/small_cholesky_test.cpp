#include "core/small_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

namespace chequer {
namespace {

using FiveByFive = Eigen::Matrix<double, 5, 5>;

FiveByFive Positive() {
  FiveByFive root;
  for (int i = 0; i < 25; ++i) root(i / 5, i % 5) = std::sin(1.7 * i + 0.3 * i * i);
  return root * root.transpose() + 0.1 * FiveByFive::Identity();
}

TEST(SmallCholesky, SolvesAndInverts) {
  const FiveByFive matrix = Positive();
  const SmallCholesky<5> factor(matrix);
  ASSERT_TRUE(factor.positive());
  const SmallCholesky<5>::Vector right(1, -2, 3, 0.5, -1);
  EXPECT_LT((matrix * factor.Solve(right) - right).norm(), 1e-12);
  EXPECT_LT((factor.Inverse() - matrix.inverse()).norm(), 1e-12 * matrix.inverse().norm());
  Eigen::Matrix<double, 5, Eigen::Dynamic> columns(5, 2);
  columns << right, 2 * matrix.col(3);
  EXPECT_LT((matrix * factor.SolveEach(columns) - columns).norm(), 1e-12);
}

TEST(SmallCholesky, TellsWhatIsNotPositive) {
  FiveByFive matrix = Positive();
  matrix(3, 3) = -1;
  EXPECT_FALSE(SmallCholesky<5>(matrix).positive());
  matrix(3, 3) = std::nan("");
  EXPECT_FALSE(SmallCholesky<5>(matrix).positive());
}

}  // namespace
}  // namespace chequer
