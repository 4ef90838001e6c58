#include "detect/fit/blur_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

namespace chequer {
namespace {

constexpr double kBlurPx = 0.8, kPitchPx = 10;

/// Across the edges of a board that lies turned by 20 degrees.
Eigen::Matrix2d Across() {
  Eigen::Matrix2d across;
  const double angle = 20 * M_PI / 180;
  across << std::cos(angle), std::sin(angle), -std::sin(angle), std::cos(angle);
  return across;
}

/// Corners of a board of 5 × 5, from its middle.
std::vector<Eigen::Vector2d> Corners() {
  std::vector<Eigen::Vector2d> corners;
  for (int row = -2; row <= 2; ++row)
    for (int col = -2; col <= 2; ++col) corners.push_back(Across().transpose() * Eigen::Vector2d(col, row) * kPitchPx);
  return corners;
}

WayByTurn<double> ByTurn(const BlurShapeFit& fit, const Eigen::Vector2d& off_px) {
  return fit.ByTurn(off_px.x(), off_px.y());
}

CornerBlur<double> BlurAt(const BlurShapeFit& fit, const Eigen::Vector2d& off_px) {
  return fit.At(ByTurn(fit, off_px));
}

BlurShapeFit FitOf(const BlurShape& shape) {
  BlurShapeFit fit(shape, Across(), kBlurPx);
  double square = 0;
  for (const Eigen::Vector2d& corner : Corners()) {
    const WayByTurn<double> by_turn = ByTurn(fit, corner);
    square += (by_turn.x * by_turn.x + by_turn.y * by_turn.y) / 25;
  }
  fit.SetMeanSquare(square);
  return fit;
}

/// A fit at a shape, with what pixels without noise would tell of another one.
BlurShapeFit LitBy(const BlurShape& truth, double information, const BlurShape& shape) {
  BlurShapeFit fit = FitOf(shape);
  const BlurShapeFit true_fit = FitOf(truth);
  for (const Eigen::Vector2d& corner : Corners()) {
    const CornerBlur<double> is = BlurAt(fit, corner), should = BlurAt(true_fit, corner);
    const double x = std::log(should.wider_x / is.wider_x), y = std::log(should.wider_y / is.wider_y);
    fit.Add<double>(ByTurn(fit, corner),
                    {information * (x + y) / 2, information, information * (x - y) / 2, information,
                     information * (should.skew - is.skew), information},
                    true);
  }
  return fit;
}

/// One step towards it.
double StepTowards(const BlurShape& truth, double information, double least_gain, BlurShape& shape) {
  return LitBy(truth, information, shape).Step(least_gain, shape);
}

TEST(BlurShape, AWayBlursAlongItself) {
  BlurShape shape;
  shape.way_px = Across().row(0).transpose() * 2;  // across edges of constant x
  const BlurShapeFit fit = FitOf(shape);
  const CornerBlur<double> blur = BlurAt(fit, {0, 0});
  const double along = blur.wider_x * kBlurPx, across = blur.wider_y * kBlurPx;
  EXPECT_NEAR(along * along - across * across, 2.0 * 2 / 12, 1e-9);
  EXPECT_NEAR(along * along + across * across, 2 * kBlurPx * kBlurPx, 1e-9) << "the mean stays";
  EXPECT_NEAR(blur.skew, 0, 1e-9);
}

TEST(BlurShape, OneSideOfABoardThatTurnsIsBlurredMore) {
  const BlurShape shape{{1.5, 0}, 0.04};
  const BlurShapeFit fit = FitOf(shape);
  const auto variance = [&](const CornerBlur<double>& blur) {
    return (blur.wider_x * blur.wider_x + blur.wider_y * blur.wider_y) / 2;
  };
  // Points below the middle go the other way by the turn.
  EXPECT_GT(variance(BlurAt(fit, {0, -20})), variance(BlurAt(fit, {0, 20})) + 0.1);
  double mean = 0;
  for (const Eigen::Vector2d& corner : Corners()) mean += variance(BlurAt(fit, corner)) / 25;
  EXPECT_NEAR(mean, 1, 1e-9);
}

TEST(BlurShape, StepsFindWayAndTurn) {
  const BlurShape truth{{1.4, -0.9}, 0.03};
  BlurShape shape;
  for (int step = 0; step < 8; ++step) StepTowards(truth, 1e5, 12, shape);
  const double sign = shape.way_px.dot(truth.way_px) > 0 ? 1 : -1;
  EXPECT_LT((sign * shape.way_px - truth.way_px).norm(), 0.01) << shape.way_px.transpose();
  EXPECT_NEAR(sign * shape.turn, truth.turn, 1e-3);
  EXPECT_NEAR(shape.BendPx().x(), truth.BendPx().x(), 1e-3) << "there and back are bent alike";
  EXPECT_NEAR(shape.BendPx().y(), truth.BendPx().y(), 1e-3);
}

TEST(BlurShape, StepsFindATurnOnTheSpot) {
  const BlurShape truth{{0, 0}, 0.04};
  BlurShape shape;
  EXPECT_GT(StepTowards(truth, 1e4, 12, shape), 12);
  for (int step = 0; step < 5; ++step) StepTowards(truth, 1e4, 12, shape);
  EXPECT_LT(shape.way_px.norm(), 0.01) << shape.way_px.transpose();
  EXPECT_NEAR(std::abs(shape.turn), truth.turn, 1e-3);
  EXPECT_FALSE(shape.round());
  BlurShape round;
  EXPECT_EQ(StepTowards({{0, 0}, 0.005}, 100, 12, round), 0);
  EXPECT_TRUE(round.round()) << "noise would do";
}

TEST(BlurShape, ARoundBlurStaysOneWhereNoiseWouldDo) {
  const BlurShape truth{{0.3, 0}, 0};
  BlurShape shape;
  EXPECT_EQ(StepTowards(truth, 100, 12, shape), 0);
  EXPECT_TRUE(shape.round());
  EXPECT_GT(StepTowards(truth, 1e5, 12, shape), 12);
  EXPECT_NEAR(shape.way_px.norm(), 0.3, 0.03);
}

TEST(BlurShape, TellsWhatARoundBlurWouldLeave) {
  const BlurShape truth{{0.6, 0.2}, 0};
  BlurShape round;
  const double explained = StepTowards(truth, 1e4, 12, round);
  EXPECT_NEAR(LitBy(truth, 1e4, truth).round_leaves(), explained, 0.1 * explained);
  BlurShape shape = truth;
  BlurShapeFit of_round = LitBy({}, 1e4, shape);
  EXPECT_NEAR(of_round.round_leaves(), -explained, 0.1 * explained) << "it is what there is";
  EXPECT_LT(of_round.round_leaves() + of_round.Step(12, shape), 0.3 * explained);
}

TEST(BlurShape, AWayAsWideAsTheBlurLeavesSomeOfTheLens) {
  const BlurShapeFit fit = FitOf({{20, 0}, 0.3});
  for (const Eigen::Vector2d& corner : Corners()) {
    const CornerBlur<double> blur = BlurAt(fit, corner);
    EXPECT_TRUE(std::isfinite(blur.wider_x) && std::isfinite(blur.wider_y) && std::abs(blur.skew) < 1);
  }
}

}  // namespace
}  // namespace chequer
