#include "detect/fit/model_equations.h"

#include <gtest/gtest.h>

#include <random>

#include "support/dense.h"

namespace chequer {
namespace {

constexpr MarkerSize kModelSize{4, 5};
constexpr int kModelCorners = CornerCount(kModelSize), kModelCells = 20, kModelRows = 60;

/// Sums of random rows around the corners of a board, against one dense system of all of them.
class ModelEquationsTest : public testing::TestWithParam<int> {
 protected:
  ModelEquationsTest() {
    std::vector<std::uint8_t> bytes(200 * 200, 128);
    const Plane plane{bytes.data(), 200};
    const ImageView image(PixelFormat::kBayerRg8, 200, 200, {&plane, 1});
    std::array<float, 256> table{};
    Eigen::Matrix3d h;
    h << 12, 0, 100, 0, 12, 100, 0, 0, 1;
    pixels_.Collect(LightReader(image, table), Lens(), kModelSize, BoardGeometry(h), 1);
    hidden_[5] = Hidden::kMisfit;
    lanes_.Reset(pixels_.lanes().padded(), columns_.products());
    for (int lane = 0; lane < pixels_.lanes().lanes(); ++lane) {
      Eigen::MatrixXf rows(kModelRows, columns_.count);
      for (float& value : rows.reshaped()) value = static_cast<float>(value_(random_));
      rows_.push_back(rows.cast<double>());
      const Eigen::MatrixXf products = rows.transpose() * rows;
      for (int a = 0; a < columns_.count; ++a)
        for (int b = a; b < columns_.count; ++b) lanes_.sum_data(columns_.Product(a, b), lane)[0] = products(a, b);
    }
    levels_.resize(kModelCorners);
    for (int corner = 0; corner < kModelCorners; ++corner) {
      const int row = corner / (kModelSize.cols - 1), col = corner % (kModelSize.cols - 1);
      for (int i = 0; i < ModelColumns::kLevels; ++i) {
        const int r = row + i / 4 - 1, c = col + i % 4 - 1;
        const bool inside = r >= 0 && c >= 0 && r < kModelSize.rows && c < kModelSize.cols;
        levels_[static_cast<std::size_t>(corner)][static_cast<std::size_t>(i)] =
            inside ? r * kModelSize.cols + c : ModelEquations::kNoLevel;
      }
    }
  }

  ModelEquations::Input Input(const std::array<int, 4>& channel_of_phase) const {
    ModelEquations::Input input;
    input.pixels = &pixels_;
    input.lanes = &lanes_;
    input.columns = columns_;
    input.hidden = hidden_;
    input.levels = levels_;
    input.channel_of_phase = channel_of_phase;
    input.level_count = kModelCells;
    input.band = 3 * kModelSize.cols + 3;
    return input;
  }

  /// All unknowns in one: the shared ones, then each channel's levels.
  struct Dense {
    Eigen::MatrixXd normal;
    Eigen::VectorXd right;
    double square = 0;

    Eigen::VectorXd Solve() const { return test::Product(test::Inverse(normal), right); }
  };
  Dense DenseSystem(int channels, const std::array<int, 4>& channel_of_phase) const {
    const int shared = columns_.shared, unknowns = shared + channels * kModelCells;
    Dense dense{Eigen::MatrixXd::Zero(unknowns, unknowns), Eigen::VectorXd::Zero(unknowns)};
    for (int corner = 0; corner < kModelCorners; ++corner) {
      if (hidden_[static_cast<std::size_t>(corner)] != Hidden::kNot) continue;
      for (int phase = 0; phase < 4; ++phase) {
        const Eigen::MatrixXd& rows = rows_[static_cast<std::size_t>(pixels_.Lane(corner) + phase)];
        Eigen::MatrixXd all = Eigen::MatrixXd::Zero(kModelRows, unknowns);
        all.leftCols(shared) = rows.leftCols(shared);
        for (int i = 0; i < ModelColumns::kLevels; ++i) {
          const int level = levels_[static_cast<std::size_t>(corner)][static_cast<std::size_t>(i)];
          if (level != ModelEquations::kNoLevel)
            all.col(shared + channel_of_phase[static_cast<std::size_t>(phase)] * kModelCells + level) +=
                rows.col(columns_.levels + i);
        }
        const Eigen::VectorXd residual = rows.col(columns_.residual());
        dense.normal += test::Product(all.transpose(), all);
        dense.right += test::Product(all.transpose(), residual);
        dense.square += residual.squaredNorm();
      }
    }
    return dense;
  }

  void ExpectSteps(const ModelEquations& equations, int channels, const Eigen::VectorXd& expected) const {
    const int shared = columns_.shared;
    for (int i = 0; i < shared; ++i) EXPECT_NEAR(equations.step()[i], expected[i], 1e-4) << "shared " << i;
    for (int channel = 0; channel < channels; ++channel)
      for (int level = 0; level < kModelCells; ++level)
        EXPECT_NEAR(equations.LevelStep(level, channel), expected[shared + channel * kModelCells + level], 1e-4)
            << "level " << level << " of channel " << channel;
  }

  static std::array<int, 4> ChannelsOf(int channels) {
    return channels == 3 ? std::array<int, 4>{0, 1, 1, 2} : std::array<int, 4>{0, 0, 0, 0};
  }

  std::mt19937 random_{5};
  std::uniform_real_distribution<double> value_{-1, 1};
  ModelColumns columns_{ModelTerms().With<MotionTerm, DotGainTerm, ShadowTerm>()};
  BoardPixels pixels_;
  ModelLanes lanes_;
  std::array<Hidden, kModelCorners> hidden_{};
  std::vector<Eigen::MatrixXd> rows_;
  std::vector<ModelEquations::LevelsAround16> levels_;
};

TEST_P(ModelEquationsTest, SolveAsADenseSystemDoes) {
  const int channels = GetParam(), shared = columns_.shared;
  const Dense dense = DenseSystem(channels, ChannelsOf(channels));
  const Eigen::VectorXd expected = dense.Solve();
  ModelEquations equations;
  // Twice, so that the second finds what the first has left behind.
  for (int times = 0; times < 2; ++times) ASSERT_TRUE(equations.Solve(Input(ChannelsOf(channels))));
  ExpectSteps(equations, channels, expected);
  EXPECT_NEAR(equations.chi_square(), dense.square - expected.dot(dense.right), 1e-3 * dense.square);
  const Eigen::MatrixXd covariance = test::Inverse(dense.normal).topLeftCorner(shared, shared);
  EXPECT_LT((equations.information() * covariance - Eigen::MatrixXd::Identity(shared, shared)).norm(), 1e-2);
}

TEST_P(ModelEquationsTest, FollowStepsThatAreNotMadeInFull) {
  const int channels = GetParam();
  Dense dense = DenseSystem(channels, ChannelsOf(channels));
  ModelEquations equations;
  ASSERT_TRUE(equations.Solve(Input(ChannelsOf(channels))));
  ModelEquations::Shared made = equations.step();
  EXPECT_FALSE(equations.Follow(made));
  // One after the other: the second call holds what the first was given, too.
  for (const int limited : {columns_.blur, columns_.of<DotGainTerm>()}) {
    made = equations.step();
    made[limited] *= 0.3;
    const double step = made[limited];
    EXPECT_TRUE(equations.Follow(made));
    dense.right -= step * dense.normal.col(limited);
    dense.normal.col(limited).setZero(), dense.normal.row(limited).setZero();
    dense.normal(limited, limited) = 1;
    dense.right[limited] = step;
  }
  ExpectSteps(equations, channels, dense.Solve());
}

INSTANTIATE_TEST_SUITE_P(Channels, ModelEquationsTest, testing::Values(1, 3));

TEST_F(ModelEquationsTest, WithoutPixelsNothingIsSolved) {
  hidden_.fill(Hidden::kMisfit);
  ModelEquations equations;
  EXPECT_FALSE(equations.Solve(Input({0, 1, 1, 2})));
}

}  // namespace
}  // namespace chequer
