#include "detect/fit/shading.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "simulate/random.h"

namespace chequer {
namespace {

constexpr MarkerSize kShadedSize{6, 6};
constexpr double kWhiteInk = 0.4, kYellowInk = 0.3, kDarkInk = 0.02;

/// A board in a light that falls as told by light(x, y); every second light cell is yellow.
struct ShadedBoard {
  template <class Light>
  explicit ShadedBoard(const Light& light) {
    for (int row = 0; row < kShadedSize.rows; ++row)
      for (int col = 0; col < kShadedSize.cols; ++col) {
        saturated.push_back(static_cast<std::uint8_t>(col % 2));
        const double ink = IsDark(row, col) ? kDarkInk : col % 2 ? kYellowInk : kWhiteInk;
        levels.emplace_back().fill(static_cast<float>(ink * light(col - 2.5, row - 2.5)));
      }
  }
  ShadedCells Cells() const {
    return {.size = kShadedSize, .levels = levels, .saturated = saturated, .hidden = hidden};
  }

  std::vector<PhaseValues> levels;
  std::vector<std::uint8_t> saturated;
  std::vector<Hidden> hidden;
};

TEST(Shading, FindsAWeakGradient) {
  const ShadedBoard board([](double x, double y) { return std::exp(0.02 * x - 0.01 * y); });
  ShadedCells cells = board.Cells();
  cells.fine = true;
  const auto shading = FindShading(cells);
  ASSERT_TRUE(shading);
  EXPECT_FALSE(shading->bent);
  EXPECT_NEAR(shading->slope.x(), 0.02, 1e-6);
  EXPECT_NEAR(shading->slope.y(), -0.01, 1e-6);
}

TEST(Shading, CellsThatWereTakenForTheOtherInkAreReadByTheirColour) {
  for (const double slope : {0.0, 0.03}) {
    ShadedBoard board([&](double x, double y) { return std::exp(slope * (x - y)); });
    // In color, of which yellow has no blue: as in BGR images, the last phase.
    for (std::size_t cell = 0; cell < board.levels.size(); ++cell)
      if (board.saturated[cell]) board.levels[cell][3] *= 0.2f;
    for (const std::size_t misread : {1u, 35u}) board.saturated[misread] ^= 1;
    ShadedCells cells = board.Cells();
    cells.phases = 4;
    cells.blue_phase = 3;
    cells.fine = true;
    const auto shading = FindShading(cells);
    ASSERT_TRUE(shading);
    EXPECT_NEAR(shading->slope.x(), slope, 1e-6);
    EXPECT_NEAR(shading->slope.y(), -slope, 1e-6);
  }
}

TEST(Shading, FineCellsTellHowAWeakLightBends) {
  const auto light = [](double x, double y) { return std::exp(0.01 * x - 0.002 * x * x + 0.001 * x * y); };
  const ShadedBoard board(light);
  ShadedCells cells = board.Cells();
  cells.fine = true;
  const auto shading = FindShading(cells);
  ASSERT_TRUE(shading);
  EXPECT_FALSE(shading->bent);
  EXPECT_NEAR(shading->At({2, -1}), light(2, -1), 1e-6);
  EXPECT_NEAR(shading->At({-2.5, 2.5}), light(-2.5, 2.5), 1e-6);
}

/// What noise of 4 in 1,000 leaves of a light.
template <class Light>
std::optional<Shading> FindInNoise(const Light& light, Random& random) {
  return FindShading(
      ShadedBoard([&](double x, double y) { return light(x, y) * (1 + 0.004 * random.Normal()); }).Cells());
}

TEST(Shading, CoarseCellsTellABendThatIsMoreThanNoise) {
  // Over a sensor whose rows are exposed one after the other, a lamp's flicker bends the light by as much.
  const auto bent = [](double x, double y) { return std::exp(0.01 * x + 0.04 * y - 0.006 * y * y); };
  const auto linear = [](double x, double y) { return 1 + 0.01 * x + 0.04 * y; };
  Random random(3);
  int bent_by_chance = 0;
  for (int i = 0; i < 200; ++i) {
    const auto found = FindInNoise(bent, random);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->bend[2], -0.006, 0.003) << "board " << i;
    EXPECT_NE(found->bend[2], 0) << "board " << i;
    const auto sloped = FindInNoise(linear, random);
    ASSERT_TRUE(sloped);
    bent_by_chance += !(sloped->bend - Shading::BendOfLinear(sloped->slope)).isZero(1e-12);
  }
  EXPECT_LE(bent_by_chance, 4) << "of 200 boards without a bend";
}

TEST(Shading, IsTheSameHoweverMuchOfItWasTakenOutBefore) {
  // A weak slope and a bend near what noise makes: neither may depend on the order in which it was found.
  const auto light = [](double x, double y) { return std::exp(0.006 * x - 0.004 * y - 0.0015 * y * y); };
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random all_random(seed), rest_random(seed);
    const auto all = FindInNoise(light, all_random);
    ASSERT_TRUE(all);
    Shading part;
    part.slope = {0.01, 0.02};
    part.bend = {0.002, 0, -0.003};
    const ShadedBoard left([&](double x, double y) {
      return light(x, y) * (1 + 0.004 * rest_random.Normal()) / part.At({x, y});
    });
    ShadedCells cells = left.Cells();
    cells.before = part;
    const auto rest = FindShading(cells);
    ASSERT_TRUE(rest);
    EXPECT_LT((part.slope + rest->slope - all->slope).norm(), 1e-6) << "seed " << seed;
    EXPECT_LT((part.bend + rest->bend - all->bend).norm(), 1e-6) << "seed " << seed;
  }
}

TEST(Shading, CountsTheMoreTheSurerItIs) {
  const auto slope_of = [](double true_slope) {
    return FindShading(ShadedBoard([&](double x, double) { return std::exp(true_slope * x); }).Cells())->slope.x();
  };
  EXPECT_EQ(slope_of(0.002), 0);
  EXPECT_NEAR(slope_of(0.006), 0.006 * 3 / 4, 1e-6);
  EXPECT_NEAR(slope_of(0.03), 0.03 * 0.99, 1e-6);
}

TEST(Shading, FindsALightThatFallsLinearly) {
  // From 1 at one rim to 0.1 at the other: an exponential function would miss it by 40 %.
  const auto light = [](double x, double y) { return 0.55 * (1 - 0.22 * x - 0.05 * y); };
  const auto shading = FindShading(ShadedBoard(light).Cells());
  ASSERT_TRUE(shading);
  EXPECT_TRUE(shading->bent);
  for (const double x : {-3.0, 0.0, 2.5})
    for (const double y : {-3.0, 1.0, 3.0}) {
      EXPECT_NEAR(shading->At({x, y}), light(x, y) / light(0, 0), 1e-4) << x << ' ' << y;
      EXPECT_NEAR(shading->SlopeAt({x, y}).x(), -0.22, 1e-4);
    }
}

/// A board under light that does not fall off, of a share of white; levels with errors of so much of it.
ShadedBoard VeiledBoard(double veil, double slope, double error, std::uint64_t seed) {
  ShadedBoard board([&](double x, double y) { return std::exp(slope * (0.8 * x - 0.6 * y)); });
  Random random(seed);
  for (PhaseValues& cell : board.levels)
    for (float& level : cell) level += static_cast<float>(kWhiteInk * (veil + error * random.Normal()));
  return board;
}

PhaseValues VeilOf(const ShadedBoard& board) {
  ShadedCells cells = board.Cells();
  cells.phases = 4;
  cells.blue_phase = 3;
  const auto shading = FindShading(cells);
  return shading ? FindVeil(cells, *shading) : PhaseValues{-1, -1, -1, -1};
}

TEST(Veil, IsFoundByDarkCellsThatFallOffLess) {
  for (const double true_veil : {0.05, 0.2, 0.6}) {
    // Blue sees white alone among the light cells, which are lighter than yellow.
    for (const float light : VeilOf(VeiledBoard(true_veil, 0.06, 0.002, 5)))
      EXPECT_NEAR(light, kWhiteInk * true_veil, 0.12 * kWhiteInk * true_veil);
  }
}

TEST(Veil, IsNoneWhereLevelsTellOfNone) {
  double most = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const float light : VeilOf(VeiledBoard(0, 0.05, 0.003, seed))) most = std::max(most, std::abs(double{light}));
  }
  EXPECT_LT(most, 0.01 * kWhiteInk) << "without a veil";
}

TEST(Veil, IsNoneWhereCellsAreNotWhatTheySeemToBe) { EXPECT_EQ(VeilOf(VeiledBoard(0.2, 0.05, 0.2, 1)), PhaseValues{}); }

TEST(Veil, IsTakenOffTheLevelsThatTellTheShading) {
  // Light that falls off linearly, seen through a veil.
  ShadedBoard board([](double x, double y) { return 1 - 0.1 * x + 0.04 * y; });
  for (PhaseValues& cell : board.levels)
    for (float& level : cell) level += 0.1f;
  ShadedCells cells = board.Cells();
  cells.veil.fill(0.1f);
  const auto shading = FindShading(cells);
  ASSERT_TRUE(shading);
  EXPECT_TRUE(shading->bent);
  EXPECT_NEAR(shading->At({2, -1}), 0.76, 1e-4);
}

TEST(Veil, LiesOverLevelsThatAreShaded) {
  std::vector<PhaseValues> levels(2, PhaseValues{0.1f, 0.2f, 0.3f, 0.4f});
  Shade(levels, std::vector<float>{1, 0.5f}, {0, 0.1f, 0.3f, -0.1f});
  EXPECT_EQ(levels[0], (PhaseValues{0.1f, 0.2f, 0.3f, 0.4f}));
  for (std::size_t phase = 0; phase < 4; ++phase)
    EXPECT_NEAR(levels[1][phase], (std::array{0.05, 0.15, 0.3, 0.15})[phase], 1e-6);
}

TEST(Shading, FindsABentLight) {
  const auto light = [](double x, double y) { return 1 - 0.1 * x + 0.012 * x * x - 0.01 * x * y; };
  const auto shading = FindShading(ShadedBoard(light).Cells());
  ASSERT_TRUE(shading);
  EXPECT_NEAR(shading->At({2, 2}), light(2, 2), 1e-4);
  EXPECT_NEAR(shading->At({-2, 1}), light(-2, 1), 1e-4);
}

TEST(Shading, DoesNotTakeACoverForShade) {
  ShadedBoard board([](double, double) { return 1.0; });
  board.hidden.assign(board.levels.size(), Hidden::kNot);
  for (std::size_t cell = 0; cell < 6; ++cell) {
    board.levels[cell].fill(0.15f);
    board.hidden[cell] = Hidden::kFlat;
  }
  const auto shading = FindShading(board.Cells());
  ASSERT_TRUE(shading);
  EXPECT_LT(shading->slope.norm(), 1e-6);
  board.hidden.clear();
  const auto covered = FindShading(board.Cells());
  EXPECT_TRUE(!covered || covered->slope.norm() > 0.05) << "the test's cover is none";
}

TEST(Shading, SaysNothingOfCellsThatDoNotTell) {
  ShadedBoard board([](double, double) { return 1.0; });
  board.hidden.assign(board.levels.size(), Hidden::kFlat);
  EXPECT_FALSE(FindShading(board.Cells()));
}

}  // namespace
}  // namespace chequer
