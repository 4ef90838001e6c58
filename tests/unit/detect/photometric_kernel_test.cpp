#include "detect/fit/photometric_kernel.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "detect/fit/edge_noise.h"
#include "detect/fit/edge_tally.h"
#include "support/dense.h"
#include "support/edge_terms.h"

namespace chequer {
namespace {

constexpr int kLanes = 20, kPixels = 37;

struct Lane {
  double corner_x, corner_y, px_x, px_y, correlation, level[4], floor, slope, gain = 0;
};

/// The model as the header states it, in double precision.
double Model(const Lane& lane, double x, double y, double blur) {
  const auto integral = [](double a) { return 0.5 * std::erfc(-a / std::sqrt(2)); };
  const auto density = [](double a) { return std::exp(-0.5 * a * a) / std::sqrt(2 * M_PI); };
  const double ax = x * lane.px_x / blur, ay = y * lane.px_y / blur;
  const double twist = lane.correlation * density(ax) * density(ay);
  // What cells of the first and last kind reach over, beyond their own edges; half of where they meet is the other's.
  const double gain_x = lane.gain * lane.px_x / blur, gain_y = lane.gain * lane.px_y / blur;
  const double to_first_x = integral(ax - gain_x), from_last_x = integral(ax + gain_x);
  const double to_first_y = integral(ay - gain_y), from_last_y = integral(ay + gain_y);
  const double meet = (lane.gain < 0 ? -0.5 : 0.5) * (from_last_x - to_first_x) * (from_last_y - to_first_y);
  const double first = (1 - to_first_x) * (1 - to_first_y), last = from_last_x * from_last_y;
  // Where the others grow, these are what is left of both.
  const double across = to_first_x * (1 - from_last_y), down = (1 - from_last_x) * to_first_y;
  const double cells[] = {lane.gain < 0 ? first : first - meet, lane.gain < 0 ? across + meet : across,
                          lane.gain < 0 ? down + meet : down, lane.gain < 0 ? last : last - meet};
  return lane.level[0] * (cells[0] + twist) + lane.level[1] * (cells[1] - twist) + lane.level[2] * (cells[2] - twist) +
         lane.level[3] * (cells[3] + twist);
}

class Kernel : public testing::Test {
 protected:
  Kernel() {
    block_.Reset(kLanes, 64);
    for (int lane = 0; lane < kLanes; ++lane) {
      Lane& at = lanes_.emplace_back();
      at = {value_(random_),
            value_(random_),
            8 + value_(random_),
            9 + value_(random_),
            0.1 * value_(random_),
            {},
            1e-4,
            1e-3,
            0};
      for (double& level : at.level) level = 0.4 + 0.3 * value_(random_);
      const double parameters[] = {at.corner_x, at.corner_y, at.px_x,     at.px_y,  at.correlation, at.level[0],
                                   at.level[1], at.level[2], at.level[3], at.floor, at.slope};
      for (std::size_t i = 0; i < std::size(parameters); ++i)
        block_.parameter_data(static_cast<int>(i))[lane] = static_cast<float>(parameters[i]);
      block_.SetCount(lane, kPixels - lane % 3);
      for (int i = 0; i < block_.count(lane); ++i) {
        const std::size_t place = block_.Place(lane, i);
        block_.u_data()[place] = static_cast<float>(8 * (at.corner_x + 0.5 * value_(random_)));
        block_.v_data()[place] = static_cast<float>(8 * (at.corner_y + 0.5 * value_(random_)));
        block_.light_data()[place] = static_cast<float>(0.4 + 0.1 * value_(random_));
      }
    }
    const float board_from_plane[9] = {0.125f, 0.002f, 0.01f, -0.003f, 0.125f, -0.02f, 1e-4f, -2e-4f, 1};
    std::copy(board_from_plane, board_from_plane + 9, input_.board_from_plane);
    input_.blur_px = 1.1f;
  }

  /// Lets cells grow: by turns of either kind, as much as the blur at most.
  void SetGain() {
    input_.grown = true;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      lanes_[lane].gain = (lane % 2 == 0 ? 0.006 : -0.006) * static_cast<double>(lane);
      lanes_[lane].correlation = 0;
      block_.parameter_data(LaneBlock::kGain)[lane] = static_cast<float>(lanes_[lane].gain);
      block_.parameter_data(LaneBlock::kCorrelation)[lane] = 0;
    }
  }

  void ExpectSumsOfTheModel(const char* target) const;

  /// Offset of a pixel from its corner on the board.
  std::pair<double, double> Offset(int lane, int i) const {
    const double u = block_.u_data()[block_.Place(lane, i)], v = block_.v_data()[block_.Place(lane, i)];
    const float* h = input_.board_from_plane;
    const double w = h[6] * u + h[7] * v + h[8];
    const Lane& at = lanes_[static_cast<std::size_t>(lane)];
    return {(h[0] * u + h[1] * v + h[2]) / w - at.corner_x, (h[3] * u + h[4] * v + h[5]) / w - at.corner_y};
  }

  /// A lane's columns by central differences of the model.
  std::array<double, kLaneColumns> Row(int lane, int i) const {
    const auto [x, y] = Offset(lane, i);
    Lane at = lanes_[static_cast<std::size_t>(lane)];
    const double blur = double{input_.blur_px}, h = 1e-5;
    std::array<double, kLaneColumns> row{};
    row[kShiftX] = (Model(at, x + h, y, blur) - Model(at, x - h, y, blur)) / (2 * h);
    row[kShiftY] = (Model(at, x, y + h, blur) - Model(at, x, y - h, blur)) / (2 * h);
    row[kBlur] = (Model(at, x, y, blur + h) - Model(at, x, y, blur - h)) / (2 * h);
    const double model = Model(at, x, y, blur);
    for (std::size_t k = 0; k < 4; ++k) {
      const double level = at.level[k];
      at.level[k] = level + 1;
      row[kLevel00 + k] = Model(at, x, y, blur) - model;
      at.level[k] = level;
    }
    row[kResidual] = double{block_.light_data()[block_.Place(lane, i)]} - model;
    const double root = 1 / std::sqrt(at.floor + at.slope * std::max(model, 0.0));
    for (double& value : row) value *= root;
    return row;
  }

  std::mt19937 random_{11};
  std::uniform_real_distribution<double> value_{-1, 1};
  std::vector<Lane> lanes_;
  LaneBlock block_;
  KernelInput input_;
};

TEST_F(Kernel, ErrorsAlongEdgesAreThoseOfThePixelsAtEachDistance) {
  // Two groups; lanes of neither are left out.
  AlikeEdges wanted[2];
  for (int lane = 0; lane < kLanes; ++lane)
    for (int axis = 0; axis < 2; ++axis)
      wanted[axis].group_of_lane[static_cast<std::size_t>(lane)] = (lane + axis) % 3 - 1;
  struct Sums {
    double score = 0, information = 0;
  };
  std::map<std::array<int, 3>, Sums> sums;  // by axis, group and distance
  for (int lane = 0; lane < kLanes; ++lane)
    for (int i = 0; i < block_.count(lane); i += AlikeEdges::kStride) {
      const Lane& at = lanes_[static_cast<std::size_t>(lane)];
      const auto [x, y] = Offset(lane, i);
      const auto row = Row(lane, i);
      const double off_px[2] = {x * at.px_x, y * at.px_y}, by_px[2] = {row[kShiftX] / at.px_x, row[kShiftY] / at.px_y};
      for (int axis = 0; axis < 2; ++axis) {
        Sums& sum = sums[{axis, wanted[axis].group_of_lane[static_cast<std::size_t>(lane)],
                          static_cast<int>(std::floor(off_px[axis])) + AlikeEdges::kDistances / 2}];
        sum.score += by_px[axis] * row[kResidual];
        sum.information += by_px[axis] * by_px[axis];
      }
    }
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    AlikeEdges edges[2] = {wanted[0], wanted[1]};
    AddEdgeErrors(input_, block_, edges[0], edges[1], nullptr);
    for (int axis = 0; axis < 2; ++axis)
      for (int group = 0; group < AlikeEdges::kBlockPx; ++group)
        for (int distance = 0; distance < AlikeEdges::kDistances; ++distance) {
          const EdgeErrors& found =
              edges[axis].errors[static_cast<std::size_t>(group)][static_cast<std::size_t>(distance)];
          const auto expected = sums.find({axis, group, distance});
          if (expected == sums.end()) {
            EXPECT_EQ(found.information, 0) << hwy::TargetName(target);
            continue;
          }
          // Both have factors that all pixels share, which this is without.
          const double deviation = expected->second.score / std::sqrt(expected->second.information);
          EXPECT_NEAR(double{found.score} / std::sqrt(double{found.information}), deviation,
                      2e-3 * std::max(std::abs(deviation), 1.0))
              << hwy::TargetName(target) << ", axis " << axis << ", group " << group << ", distance " << distance;
        }
  }
  hwy::SetSupportedTargetsForTest(0);
}

/// Of two groups along each axis, five pixels across their edges: as many times what noise would be.
EdgeTally DrawTally(std::mt19937& random, float times) {
  constexpr float kInformation = 40, kVariance = 1.5f;
  std::normal_distribution<float> normal;
  EdgeTally tally;
  for (int axis = 0; axis < 2; ++axis) {
    AlikeEdges edges;
    for (std::size_t group = 0; group < 2; ++group)
      for (std::size_t distance = 5; distance < 10; ++distance)
        edges.errors[group][distance] = {std::sqrt(kInformation * kVariance * times) * normal(random), kInformation};
    tally.Add(edges, double{kVariance});
  }
  return tally;
}

TEST_F(Kernel, ErrorsAtPlacesAreThoseOfThePixelsThere) {
  AlikeEdges wanted;
  for (int lane = 0; lane < kLanes; ++lane) wanted.group_of_lane[static_cast<std::size_t>(lane)] = lane % 3 - 1;
  std::map<std::size_t, std::array<double, 3>> sums;  // by place: deviations, their squares, pixels
  for (int lane = 0; lane < kLanes; ++lane)
    for (int i = 0; lane % 3 > 0 && i < block_.count(lane); i += AlikeEdges::kStride) {
      const Lane& at = lanes_[static_cast<std::size_t>(lane)];
      const auto [x, y] = Offset(lane, i);
      const auto place_of = [](double px) { return static_cast<int>(std::floor(px)) + AlikeEdges::kDistances / 2; };
      const double contrast = at.level[0] - at.level[1] - at.level[2] + at.level[3],
                   deviation = std::copysign(1.0, contrast) * Row(lane, i)[kResidual];
      auto& sum =
          sums[static_cast<std::size_t>(place_of(y * at.px_y) * AlikeEdges::kDistances + place_of(x * at.px_x))];
      sum[0] += deviation, sum[1] += deviation * deviation, ++sum[2];
    }
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    AlikeEdges x = wanted, y;
    AlikePlaces places;
    AddEdgeErrors(input_, block_, x, y, &places);
    for (std::size_t place = 0; place < places.errors.size(); ++place) {
      const auto expected = sums.find(place);
      const AlikePlaces::Errors& found = places.errors[place];
      const std::array<double, 3> wanted_there = expected == sums.end() ? std::array{0.0, 0.0, 0.0} : expected->second;
      EXPECT_EQ(found.count, wanted_there[2]) << hwy::TargetName(target) << ", place " << place;
      EXPECT_NEAR(double{found.sum}, wanted_there[0], 5e-3 * std::max(std::abs(wanted_there[0]), 1.0));
      EXPECT_NEAR(double{found.square}, wanted_there[1], 5e-3 * std::max(wanted_there[1], 1.0));
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(ErrorsAtPlaces, ThatCornersShareAreToldFromNoise) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  constexpr int kDraws = 200, kPlaces = 36, kCorners = 25;
  int by_chance = 0;
  double shared = 0;
  for (int draw = 0; draw < kDraws; ++draw)
    for (const float of_all : {0.0f, 0.8f}) {
      AlikePlaces places;
      for (std::size_t place = 0; place < kPlaces; ++place) {
        const float error = of_all * normal(random);
        for (int corner = 0; corner < kCorners; ++corner) {
          const float deviation = error + normal(random);
          AlikePlaces::Errors& there = places.errors[place];
          there.sum += deviation, there.square += deviation * deviation, ++there.count;
        }
      }
      if (of_all > 0)
        shared += places.Shared() / kDraws;
      else
        by_chance += places.Shared() > 0;
    }
  EXPECT_LE(by_chance, kDraws / 50);
  // Less what chance may make of noise.
  EXPECT_NEAR(shared / AlikeEdges::kStride, 0.64 * kPlaces * kCorners, 0.1 * kPlaces * kCorners);
  EXPECT_EQ(AlikePlaces().Shared(), 0) << "no pixels";
}

TEST(ErrorsAlongEdges, CountWhereTheyAreMoreThanNoise) {
  std::mt19937 random(3);
  constexpr int kDraws = 300;
  double of_noise = 0, of_errors = 0;
  for (int i = 0; i < kDraws; ++i) {
    of_noise += DrawTally(random, 1).More() / kDraws;
    of_errors += DrawTally(random, 11).More() / kDraws;
  }
  EXPECT_LT(of_noise / AlikeEdges::kStride, 0.1);
  EXPECT_NEAR(of_errors / AlikeEdges::kStride, 10, 1);
  EXPECT_EQ(EdgeTally().More(), 0) << "nothing follows the pixels";
}

TEST(ErrorsAlongEdges, ThatAreFewCountWhereManyBoardsHaveThem) {
  std::mt19937 random(4);
  constexpr int kBoards = 1000;
  constexpr float kTimes = 1.3f;
  double of_each = 0;
  EdgeTally all;
  for (int i = 0; i < kBoards; ++i) {
    const EdgeTally own = DrawTally(random, kTimes);
    of_each += own.More() / kBoards;
    all.Add(own);
  }
  EXPECT_LT(of_each / AlikeEdges::kStride, 0.2) << "one board may have them by chance";
  EXPECT_NEAR(all.More() / AlikeEdges::kStride, double{kTimes} - 1, 0.1);
  EdgeTally faded = all;
  faded.Forget(0.001);
  const EdgeTally other = DrawTally(random, 11);
  faded.Add(other);
  all.Add(other);
  EXPECT_GT(faded.More(), 10 * all.More());
}

TEST(ErrorsAlongEdges, AreCountedAsOthersHaveThem) {
  std::mt19937 random(5);
  SharedEdgeErrors errors{.own = DrawTally(random, 1)};
  EdgeTally all = errors.own;
  for (int i = 0; i < 100; ++i) all.Add(DrawTally(random, 11));
  BoardGeometry::Information information = BoardGeometry::Information::Constant(0.5);
  information.diagonal().array() += 2;
  EXPECT_FALSE(errors.Recounted(information, all)) << "no edges follow the pixels";
  errors.covariance = 0.01 * BoardGeometry::Information::Identity();
  errors.counted = all.MoreOf(errors.own);
  EXPECT_GT(errors.counted, all.More()) << "fits follow a part of them";
  EXPECT_LT(errors.counted, 1.3 * all.More());
  EXPECT_FALSE(errors.Recounted(information, all)) << "they are counted";
  for (const double counted : {0.0, 2 * errors.counted}) {
    SharedEdgeErrors others = errors;
    others.counted = counted;
    // What was counted before lies within the board's covariance.
    const auto widened = [&](double units) {
      return BoardGeometry::Information(test::Inverse(test::Inverse(information) + units * errors.covariance));
    };
    const BoardGeometry::Information before = widened(counted), as_all = widened(errors.counted);
    const auto recounted = others.Recounted(before, all);
    ASSERT_TRUE(recounted);
    EXPECT_TRUE(recounted->isApprox(as_all, 1e-9)) << counted;
  }
}

TEST_F(Kernel, EdgesAndCornersAreAsTold) {
  input_.edge_x.by_power = {-0.3f, 0.2f, -0.2f, 0.05f, 0.01f, -0.001f};
  input_.corner = {.square = -0.2f, .product = 0.3f, .moved_x = 0.15f, .moved_y = -0.1f, .moved_product = 0.2f};
  input_.narrower_x = 0.03f;
  input_.narrower_y = -0.05f;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    AccumulateLanes(input_, block_);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Lane& at = lanes_[static_cast<std::size_t>(lane)];
      double sum = 0;
      for (int i = 0; i < block_.count(lane); ++i) {
        const auto [x, y] = Offset(lane, i);
        double a = x * at.px_x / double{input_.blur_px}, b = y * at.px_y / double{input_.blur_px};
        const double product = a * b;
        a += 0.03 * product, b -= 0.05 * product;
        const double wx = test::LightOf(input_.edge_x, a), wy = test::LightOf(input_.edge_y, b), size = a * a + b * b;
        const double more = std::exp(-0.5 * size) / (2 * M_PI) *
                            (at.correlation + (-0.2 * (a * a - b * b) + 0.3 * a * b) * (1 - 0.2235 * size) +
                             0.15 * (a * a - 1) - 0.1 * (b * b - 1) + 0.2 * a * b);
        const double model = at.level[0] * ((1 - wx) * (1 - wy) + more) + at.level[1] * (wx * (1 - wy) - more) +
                             at.level[2] * ((1 - wx) * wy - more) + at.level[3] * (wx * wy + more);
        const double residual = double{block_.light_data()[block_.Place(lane, i)]} - model;
        sum += residual * residual / (at.floor + at.slope * std::max(model, 0.0));
      }
      EXPECT_NEAR(block_.sum(ProductSum(kResidual, kResidual), lane), sum, 2e-3 * sum)
          << hwy::TargetName(target) << ", lane " << lane;
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

void Kernel::ExpectSumsOfTheModel(const char* target) const {
  for (int lane = 0; lane < kLanes; ++lane) {
    std::array<std::array<double, kLaneColumns>, kLaneColumns> sums{};
    for (int i = 0; i < block_.count(lane); ++i) {
      const auto row = Row(lane, i);
      for (std::size_t a = 0; a < kLaneColumns; ++a)
        for (std::size_t b = a; b < kLaneColumns; ++b) sums[a][b] += row[a] * row[b];
    }
    for (std::size_t a = 0; a < kLaneColumns; ++a)
      for (std::size_t b = a; b < kLaneColumns; ++b)
        EXPECT_NEAR(block_.sum(ProductSum(static_cast<int>(a), static_cast<int>(b)), lane), sums[a][b],
                    2e-3 * std::sqrt(sums[a][a] * sums[b][b]) + 1e-3)
            << target << ", lane " << lane << ", columns " << a << " and " << b;
    EXPECT_EQ(block_.sum(kWeight, lane), static_cast<float>(block_.count(lane)));
    EXPECT_EQ(block_.sum(kDarkCount, lane) + block_.sum(kLightCount, lane), static_cast<float>(block_.count(lane)));
  }
}

TEST_F(Kernel, SumsAreThoseOfTheModelOnEveryTarget) {
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    AccumulateLanes(input_, block_);
    ExpectSumsOfTheModel(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(Kernel, CellsThatGrowMoveTheirEdges) {
  SetGain();
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    AccumulateLanes(input_, block_);
    ExpectSumsOfTheModel(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(Kernel, CellsThatGrowByNothingAreAsOthers) {
  AccumulateLanes(input_, block_);
  const LaneBlock plain = block_;
  input_.grown = true;
  std::fill_n(block_.parameter_data(LaneBlock::kGain), kLanes, 0.0f);
  AccumulateLanes(input_, block_);
  for (int lane = 0; lane < kLanes; ++lane)
    for (int a = 0; a < kLaneColumns; ++a)
      EXPECT_NEAR(block_.sum(ProductSum(a, a), lane), plain.sum(ProductSum(a, a), lane),
                  1e-4f * plain.sum(ProductSum(a, a), lane))
          << "lane " << lane << ", column " << a;
}

/// As BlurShape has them: by half the difference of the logarithms of the deviations across the two edges, and by the
/// correlation.
TEST_F(Kernel, TellsOfTheBlursShape) {
  constexpr double kStep = 1e-4;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    for (const LaneSums sums : {LaneSums::kShapes, LaneSums::kNoise}) {
      input_.sums = sums;
      AccumulateLanes(input_, block_);
      for (int lane = 0; lane < kLanes; ++lane) {
        const Lane& at = lanes_[static_cast<std::size_t>(lane)];
        double uneven_residual = 0, uneven_square = 0, skew_residual = 0, skew_square = 0;
        for (int i = 0; i < block_.count(lane); ++i) {
          const std::pair<double, double> off = Offset(lane, i);
          const double x = off.first, y = off.second;
          const double blur = double{input_.blur_px}, model = Model(at, x, y, blur);
          const double weight = 1 / (at.floor + at.slope * std::max(model, 0.0)),
                       residual = double{block_.light_data()[block_.Place(lane, i)]} - model;
          const auto by = [&](const auto& change) {
            Lane more = at, less = at;
            change(more, kStep);
            change(less, -kStep);
            return (Model(more, x, y, blur) - Model(less, x, y, blur)) / (2 * kStep);
          };
          const double by_uneven = by([](Lane& of, double step) {
            of.px_x *= std::exp(-step);
            of.px_y *= std::exp(step);
          });
          const double by_skew = by([](Lane& of, double step) { of.correlation += step; });
          uneven_residual += weight * by_uneven * residual;
          uneven_square += weight * by_uneven * by_uneven;
          skew_residual += weight * by_skew * residual;
          skew_square += weight * by_skew * by_skew;
        }
        // The kernel leaves out what the correlation changes by the deviations.
        EXPECT_NEAR(block_.sum(kUnevenSquare, lane), uneven_square, 0.05 * uneven_square) << hwy::TargetName(target);
        EXPECT_NEAR(block_.sum(kSkewSquare, lane), skew_square, 2e-3 * skew_square) << hwy::TargetName(target);
        const double scale = block_.sum(ProductSum(kResidual, kResidual), lane);
        EXPECT_NEAR(block_.sum(kUnevenResidual, lane), uneven_residual, 0.02 * std::sqrt(scale * uneven_square));
        EXPECT_NEAR(block_.sum(kSkewResidual, lane), skew_residual, 2e-3 * std::sqrt(scale * skew_square));
      }
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(Kernel, FoldedLanesAreSummedAlike) {
  // The first four lanes, alone in a block.
  LaneBlock few;
  few.Reset(LaneBlock::kFold, 64);
  const auto each_value = [&](auto&& act) {
    for (int lane = 0; lane < LaneBlock::kFold; ++lane)
      for (int i = 0; i < block_.count(lane); ++i) {
        const std::size_t from = block_.Place(lane, i), to = few.Place(lane, i);
        act(block_.u_data()[from], few.u_data()[to]);
        act(block_.v_data()[from], few.v_data()[to]);
        act(block_.light_data()[from], few.light_data()[to]);
      }
  };
  each_value([](float from, float& to) { to = from; });
  for (int lane = 0; lane < LaneBlock::kFold; ++lane) {
    few.SetCount(lane, block_.count(lane));
    for (int i = 0; i < LaneBlock::kParameters; ++i) few.parameter_data(i)[lane] = block_.parameter_data(i)[lane];
  }
  few.Fold();
  each_value([](float from, float& to) { EXPECT_EQ(to, from); });
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    AccumulateLanes(input_, block_);
    AccumulateLanes(input_, few);
    for (int lane = 0; lane < LaneBlock::kFold; ++lane) {
      EXPECT_EQ(few.count(lane), block_.count(lane));
      for (int a = 0; a < kLaneColumns; ++a) {
        const float size = block_.sum(ProductSum(a, a), lane);
        EXPECT_NEAR(few.sum(ProductSum(a, a), lane), size, 1e-5f * size) << hwy::TargetName(target);
      }
      EXPECT_EQ(few.sum(kWeight, lane), block_.sum(kWeight, lane));
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(Kernel, ShapesAreSummedAlikeWithoutTheLevels) {
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    input_.sums = LaneSums::kLevels;
    AccumulateLanes(input_, block_);
    const LaneBlock all = block_;
    std::fill_n(block_.sum_data(0), kLaneSums * block_.padded(), -7.0f);
    input_.sums = LaneSums::kShapes;
    AccumulateLanes(input_, block_);
    const std::set<int> shapes{kShiftX, kShiftY, kBlur, kResidual};
    for (int lane = 0; lane < kLanes; ++lane)
      for (int a = 0; a < kLaneColumns; ++a)
        for (int b = a; b < kLaneColumns; ++b) {
          const bool told = shapes.contains(a) && shapes.contains(b);
          const float sum = all.sum(ProductSum(a, b), lane);
          EXPECT_NEAR(block_.sum(ProductSum(a, b), lane), told ? sum : 0, told ? 1e-5f * std::abs(sum) + 1e-6f : 0)
              << hwy::TargetName(target) << ", lane " << lane << ", columns " << a << " and " << b;
        }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(Kernel, LooksAtTheFirstLanesAlone) {
  constexpr int kFirst = 8, kWidest = 16;
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    input_.lanes = KernelInput::kAllLanes;
    AccumulateLanes(input_, block_);
    const LaneBlock all = block_;
    std::fill_n(block_.sum_data(0), kLaneSums * block_.padded(), -7.0f);
    input_.lanes = kFirst;
    AccumulateLanes(input_, block_);
    for (int sum = 0; sum < kLaneSums; ++sum) {
      for (int lane = 0; lane < kFirst; ++lane)
        EXPECT_EQ(block_.sum(sum, lane), all.sum(sum, lane)) << hwy::TargetName(target) << ", lane " << lane;
      for (int lane = kWidest; lane < kLanes; ++lane)
        EXPECT_EQ(block_.sum(sum, lane), -7.0f) << hwy::TargetName(target) << ", lane " << lane;
    }
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST_F(Kernel, APixelFarOffCountsLess) {
  const std::size_t place = block_.Place(4, 2);
  AccumulateLanes(input_, block_);
  const float before = block_.sum(ProductSum(kResidual, kResidual), 4);
  block_.light_data()[place] += 0.5f;
  input_.robust_limit = 1e9f;
  AccumulateLanes(input_, block_);
  const float plain = block_.sum(ProductSum(kResidual, kResidual), 4);
  input_.robust_limit = 4;
  AccumulateLanes(input_, block_);
  EXPECT_GT(plain, before);
  EXPECT_LT(block_.sum(ProductSum(kResidual, kResidual), 4), 0.7f * plain);
  EXPECT_LT(block_.sum(kWeight, 4), static_cast<float>(block_.count(4)));
}

/// Derivatives of log Φ, by how far the model lies above full scale, standard deviations.
struct LogNormal {
  double score, information;

  explicit LogNormal(double above) {
    const double ratio = std::exp(-0.5 * above * above) / std::sqrt(2 * M_PI) * 2 / std::erfc(-above / std::sqrt(2));
    score = ratio, information = ratio * (ratio + above);
  }
};

TEST_F(Kernel, ASaturatedPixelSaysThatItsLightIsFullScaleOrMore) {
  constexpr double kFull = 0.99;
  input_.robust_limit = 1e9f;
  for (int i = 0; i < block_.count(0); ++i) block_.light_data()[block_.Place(0, i)] = 1;
  MarkSaturated(static_cast<float>(kFull), block_);
  const auto sigma_at = [&](double light) { return std::sqrt(lanes_[0].floor + lanes_[0].slope * light); };
  const double pixels = block_.count(0);
  for (const double above : {-9.0, -4.0, -2.6, -2.4, -1.0, 0.0, 1.0, 2.0, 4.0, 30.0}) {
    double model = kFull;
    for (int i = 0; i < 50; ++i) model = kFull + above * sigma_at(model);
    for (int i = 0; i < 4; ++i) block_.parameter_data(LaneBlock::kL00 + i)[0] = static_cast<float>(model);
    AccumulateLanes(input_, block_);
    const LogNormal wanted(above);
    EXPECT_NEAR(block_.sum(kWeight, 0), pixels * wanted.information, 0.006 * pixels) << above;
    double score = 0, information = 0;
    for (int level = kLevel00; level <= kLevel11; ++level) {
      score += double{block_.sum(ProductSum(level, kResidual), 0)};
      for (int other = kLevel00; other <= kLevel11; ++other)
        information += double{block_.sum(ProductSum(std::min(level, other), std::max(level, other)), 0)};
    }
    const double sigma = sigma_at(model);
    EXPECT_NEAR(score * sigma, pixels * wanted.score, 0.006 * pixels * std::max(1.0, wanted.score)) << above;
    EXPECT_NEAR(information * sigma * sigma, pixels * wanted.information, 0.008 * pixels) << above;
    EXPECT_EQ(block_.sum(kLightCount, 0) + block_.sum(kDarkCount, 0), 0) << "it does not tell the noise";
  }
}

/// A gradient was taken out of the light before it was asked whether a pixel is saturated: bright pixels that are not
/// seemed to be, and saturated ones in brighter light said more than they know.
TEST_F(Kernel, APixelIsSaturatedByItsCodeNotByItsCorrectedLight) {
  const auto weight_of = [&](float code, float scale, float model) {
    for (int i = 0; i < 4; ++i) block_.parameter_data(LaneBlock::kL00 + i)[0] = model;
    for (int i = 0; i < block_.count(0); ++i) {
      const std::size_t at = block_.Place(0, i);
      block_.u_data()[at] = 1, block_.v_data()[at] = 0, block_.light_data()[at] = code;
    }
    MarkSaturated(0.99f, block_);
    EvenOutLanes({.by_u = -std::log(scale)}, {}, block_);
    AccumulateLanes(input_, block_);
    return block_.sum(kWeight, 0);
  };
  EXPECT_GT(weight_of(0.9f, 1.2f, 1.2f), 0) << "it says 1.08, though that is above full scale";
  const auto saturated_weight = [&](double limit, double model) {
    const double above = (model - limit) / std::sqrt(lanes_[0].floor + lanes_[0].slope * model);
    return block_.count(0) * LogNormal(above).information;
  };
  EXPECT_NEAR(weight_of(1.0f, 0.8f, 0.9f), saturated_weight(0.99 * 0.8, 0.9), 0.02) << "it says at least 0.8";
  EXPECT_NEAR(weight_of(1.0f, 1.2f, 1.1f), saturated_weight(0.99 * 1.2, 1.1), 0.02 * block_.count(0))
      << "it says at least 1.2";
}

TEST_F(Kernel, EvenOutTakesAGradientOut) {
  const std::size_t plain = block_.Place(3, 5), saturated = block_.Place(3, 6);
  block_.light_data()[saturated] = 1;
  const auto fall_at = [&](std::size_t at) {
    const float u = block_.u_data()[at], v = block_.v_data()[at];
    return 0.02f * u - 0.03f * v + 0.004f * u * u - 0.003f * u * v + 0.002f * v * v;
  };
  const float light = block_.light_data()[plain];
  MarkSaturated(0.99f, block_);
  EvenOutLanes({0.02f, -0.03f, 0.004f, -0.003f, 0.002f}, {}, block_);
  EXPECT_NEAR(block_.light_data()[plain], light * std::exp(-fall_at(plain)), 1e-4);
  EXPECT_NEAR(block_.light_data()[saturated], -0.99 * std::exp(-fall_at(saturated)), 1e-4) << "marked as it was";
}

TEST_F(Kernel, EvenOutLeavesAVeilAsItIs) {
  const PhaseValues veil{0.02f, 0.05f, -0.03f, 0.1f};
  for (int lane = 0; lane < 4; ++lane) {
    const std::size_t plain = block_.Place(lane, 5), saturated = block_.Place(lane, 6);
    block_.light_data()[saturated] = 1;
    block_.u_data()[plain] = block_.u_data()[saturated] = 2;
  }
  std::array<float, 4> before;
  for (int lane = 0; lane < 4; ++lane)
    before[static_cast<std::size_t>(lane)] = block_.light_data()[block_.Place(lane, 5)];
  MarkSaturated(0.99f, block_);
  EvenOutLanes({.by_u = 0.1f}, veil, block_);
  for (int lane = 0; lane < 4; ++lane) {
    const double over = veil[static_cast<std::size_t>(lane)], share = std::exp(0.2);
    EXPECT_NEAR(block_.light_data()[block_.Place(lane, 5)],
                over + (before[static_cast<std::size_t>(lane)] - over) / share, 1e-4);
    EXPECT_NEAR(block_.light_data()[block_.Place(lane, 6)], -(over + (0.99 - over) / share), 1e-4)
        << "marked as it was";
  }
}

}  // namespace
}  // namespace chequer
