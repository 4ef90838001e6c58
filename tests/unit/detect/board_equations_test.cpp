#include "detect/fit/board_equations.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "support/dense.h"

namespace chequer {
namespace {

constexpr MarkerSize kSize{4, 5};
constexpr int kCorners = CornerCount(kSize), kCells = 20;
/// Pixels of a lane.
constexpr int kRows = 40;

/// Pixels around the corners of a plain board, with sums of random rows in every lane.
class BoardEquationsTest : public testing::TestWithParam<int> {
 protected:
  BoardEquationsTest() {
    std::vector<std::uint8_t> bytes(200 * 200, 128);
    const Plane plane{bytes.data(), 200};
    const ImageView image(PixelFormat::kBayerRg8, 200, 200, {&plane, 1});
    std::array<float, 256> table{};
    Eigen::Matrix3d h;
    h << 12, 0, 100, 0, 12, 100, 0, 0, 1;
    pixels_.Collect(LightReader(image, table), Lens(), kSize, BoardGeometry(h), 1);
    hidden_[3] = Hidden::kMisfit;
    for (CornerDerivative& by : derivatives_)
      for (int k = 0; k < BoardGeometry::kParameters; ++k) by.x[k] = value_(random_), by.y[k] = value_(random_);
    FillLanes();
  }

  static int LevelsOf(bool own_levels) { return own_levels ? 4 * kCorners : kCells; }

  void FillLanes() {
    LaneBlock& lanes = pixels_.lanes();
    for (int lane = 0; lane < lanes.lanes(); ++lane) {
      Eigen::MatrixXf rows(kRows, int{kLaneColumns});
      for (float& value : rows.reshaped()) value = static_cast<float>(value_(random_));
      rows_.push_back(rows.cast<double>());
      const Eigen::MatrixXf products = rows.transpose() * rows;
      for (int a = 0; a < kLaneColumns; ++a)
        for (int b = a; b < kLaneColumns; ++b) lanes.sum_data(ProductSum(a, b))[lane] = products(a, b);
    }
  }

  /// The rows of all lanes over every unknown: geometry, blur, then the levels by channel and cell, or quadrant.
  Eigen::MatrixXd Dense(const std::array<int, 4>& channel_of_phase, int channels, bool own_levels,
                        Eigen::VectorXd* residual) const {
    const int levels = LevelsOf(own_levels), unknowns = BoardEquations::kUnknowns + channels * levels;
    const std::ptrdiff_t most = 4 * kCorners * kRows;
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(most, unknowns);
    residual->setZero(most);
    std::ptrdiff_t next = 0;
    for (int corner = 0; corner < kCorners; ++corner) {
      if (hidden_[static_cast<std::size_t>(corner)] != Hidden::kNot) continue;
      const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
      for (int phase = 0; phase < 4; ++phase) {
        const Eigen::MatrixXd& rows = rows_[static_cast<std::size_t>(pixels_.Lane(corner) + phase)];
        auto block = dense.middleRows(next, kRows);
        for (int k = 0; k < BoardGeometry::kParameters; ++k)
          block.col(k) = rows.col(kShiftX) * by.x[k] + rows.col(kShiftY) * by.y[k];
        block.col(BoardGeometry::kParameters) = rows.col(kBlur);
        const int first = BoardEquations::kUnknowns + channel_of_phase[static_cast<std::size_t>(phase)] * levels,
                  cell = pixels_.Cell(corner);
        const std::array<int, 4> cells{cell, cell + 1, cell + kSize.cols, cell + kSize.cols + 1};
        for (int a = 0; a < 4; ++a)
          block.col(first + (own_levels ? 4 * corner + a : cells[static_cast<std::size_t>(a)])) =
              rows.col(kLevel00 + a);
        residual->segment(next, kRows) = rows.col(kResidual);
        next += kRows;
      }
    }
    return dense;
  }

  std::mt19937 random_{3};
  std::uniform_real_distribution<double> value_{-1, 1};
  BoardPixels pixels_;
  std::array<CornerDerivative, kCorners> derivatives_;
  std::array<Hidden, kCorners> hidden_{};
  std::vector<Eigen::MatrixXd> rows_;
};

std::array<int, 4> ChannelsOfPhases(int red) {
  std::array<int, 4> channel_of_phase{};
  if (red >= 0)
    for (int phase = 0; phase < 4; ++phase)
      channel_of_phase[static_cast<std::size_t>(phase)] = phase == red ? 0 : (phase == 3 - red ? 2 : 1);
  return channel_of_phase;
}

TEST_P(BoardEquationsTest, SolvesAsADenseSolverDoes) {
  for (const bool own_levels : {false, true}) {
    SCOPED_TRACE(own_levels ? "levels of quadrants" : "levels of cells");
    const int red = GetParam(), count = LevelsOf(own_levels);
    const std::array<int, 4> channel_of_phase = ChannelsOfPhases(red);
    const int channels = red >= 0 ? 3 : 1;
    Eigen::VectorXd residual;
    const Eigen::MatrixXd dense = Dense(channel_of_phase, channels, own_levels, &residual);
    Eigen::MatrixXd normal = dense.transpose() * dense;
    normal.diagonal().tail(channels * count).array() += 1e-3;  // for cells that nothing has seen
    const Eigen::LLT<Eigen::MatrixXd> factor(normal);
    const Eigen::VectorXd solution = factor.solve(dense.transpose() * residual);

    BoardEquations equations;
    equations.SetDerivatives(derivatives_);
    equations.Assemble({.pixels = &pixels_, .hidden = hidden_, .red_phase = red, .own_levels = own_levels});
    const BoardEquations::Vector step = equations.normal().llt().solve(equations.gradient());
    EXPECT_LT((step - solution.head<BoardEquations::kUnknowns>()).norm(), 1e-4);
    EXPECT_NEAR(equations.chi_square() - step.dot(equations.gradient()), (residual - dense * solution).squaredNorm(),
                1e-2);
    constexpr int kUnknowns = BoardEquations::kUnknowns;
    const Eigen::MatrixXd covariance =
        factor.solve(Eigen::MatrixXd::Identity(normal.rows(), kUnknowns)).topRows<kUnknowns>();
    EXPECT_LT((test::Inverse(equations.normal()) - covariance).norm(), 1e-3 * covariance.norm());

    std::vector<PhaseValues> levels(static_cast<std::size_t>(count), PhaseValues{});
    equations.MoveLevels(step, levels);
    for (int level = 0; level < count; ++level)
      for (std::size_t phase = 0; phase < 4; ++phase)
        EXPECT_NEAR(levels[static_cast<std::size_t>(level)][phase],
                    solution[kUnknowns + channel_of_phase[phase] * count + level], 1e-4)
            << "level " << level << ", phase " << phase;
  }
}

TEST_P(BoardEquationsTest, FixedLevelsLeaveTheShapesAlone) {
  Eigen::VectorXd residual;
  const Eigen::MatrixXd dense =
      Dense(ChannelsOfPhases(GetParam()), 3, false, &residual).leftCols<int{BoardEquations::kUnknowns}>();
  BoardEquations equations;
  equations.SetDerivatives(derivatives_);
  equations.Assemble({.pixels = &pixels_, .hidden = hidden_, .red_phase = GetParam(), .fixed_levels = true});
  EXPECT_LT((equations.normal() - dense.transpose() * dense).norm(), 1e-4 * equations.normal().norm());
  EXPECT_LT((equations.gradient() - dense.transpose() * residual).norm(), 1e-4 * equations.gradient().norm());
}

TEST_P(BoardEquationsTest, TellsWhatIsLeftOfACornersShift) {
  BoardEquations equations;
  equations.SetDerivatives(derivatives_);
  equations.Assemble({.pixels = &pixels_, .hidden = hidden_, .red_phase = GetParam()});
  std::vector<PhaseValues> moves(kCells, PhaseValues{});
  const BoardEquations::Vector step = 0.01 * BoardEquations::Vector::LinSpaced(-1, 1);
  equations.MoveLevels(step, moves);
  std::array<BoardEquations::CornerShift, kCorners> shifts;
  equations.FindShifts({.pixels = &pixels_, .hidden = hidden_, .red_phase = GetParam()}, step, shifts);
  for (int corner = 0; corner < kCorners; ++corner) {
    if (hidden_[static_cast<std::size_t>(corner)] != Hidden::kNot) continue;
    const int cell = pixels_.Cell(corner), lane = pixels_.Lane(corner);
    Eigen::Vector2d expected = Eigen::Vector2d::Zero();
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    for (std::size_t phase = 0; phase < 4; ++phase) {
      const Eigen::MatrixXd& rows = rows_[static_cast<std::size_t>(lane) + phase];
      const Eigen::MatrixXd shifts = rows.middleCols(kShiftX, 2);
      information += shifts.transpose() * shifts;
      expected += shifts.transpose() * rows.col(kResidual);
      const std::array<int, 4> cells{cell, cell + 1, cell + kSize.cols, cell + kSize.cols + 1};
      for (int a = 0; a < 4; ++a)
        expected -= double{moves[static_cast<std::size_t>(cells[static_cast<std::size_t>(a)])][phase]} *
                    shifts.transpose() * rows.col(kLevel00 + a);
    }
    const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
    const auto of_geometry = step.head<BoardGeometry::kParameters>();
    expected -= information * Eigen::Vector2d(by.x.dot(of_geometry), by.y.dot(of_geometry));
    const BoardEquations::CornerShift& shift = shifts[static_cast<std::size_t>(corner)];
    EXPECT_LT((Eigen::Vector2d(shift.x, shift.y) - expected).norm(), 1e-4 * (1 + expected.norm()))
        << "corner " << corner;
    const Eigen::Vector3d told(shift.xx, shift.xy, shift.yy),
        truth(information(0, 0), information(0, 1), information(1, 1));
    EXPECT_LT((told - truth).norm(), 1e-4 * truth.norm()) << "corner " << corner;
  }
}

INSTANTIATE_TEST_SUITE_P(RedPhase, BoardEquationsTest, testing::Values(-1, 0, 1, 2, 3));

}  // namespace
}  // namespace chequer
