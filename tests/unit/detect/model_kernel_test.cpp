// The model of a board's picture with all its terms: its derivatives against differences, on every instruction set.
#include "detect/fit/model_kernel.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <functional>
#include <vector>

#include "support/targets.h"

namespace chequer {
namespace {

constexpr int kModelPixels = LaneBlock::kGroup;

/// What the model is given, one pixel a lane, all around the corner (0.5, -0.5) of a board whose cells are a pixel
/// wide.
struct CornerScene {
  ModelTerms terms;
  double dx = 0, dy = 0, blur = 0.3, covariance = 0.02, way_x = 0.7, way_y = -0.4, turn = 0.02, gain = 0.1;
  double takes = 0.6, direction = 0.5, offset = 0.1, width = 0.8;
  double grows_x = 0.06, grows_y = -0.04, veil = 0.15;
  double amount = 0.5, spot_x = 0.2, spot_y = -0.1, spot_width = 0.7;
  bool even_dark = true;
  /// Of the board's coordinates: the blur and the way stay what they are in the image.
  BoardGeometry::Parameters moves = BoardGeometry::Parameters::Zero();
};

struct CornerPicture {
  std::vector<double> light;
  std::vector<std::vector<double>> by;  ///< column, pixel
};

Eigen::Vector2d MoveAt(const CornerScene& s, const Eigen::Vector2d& board) {
  return BoardGeometry::Move(BoardGeometry::MoveByParameters(board, 0), BoardGeometry::MoveByParameters(board, 1),
                             s.moves);
}

CornerPicture Evaluate(const CornerScene& s) {
  const ModelColumns columns(s.terms);
  constexpr double kCornerX = 0.5, kCornerY = -0.5;
  const Eigen::Vector2d corner(kCornerX, kCornerY), along_x(1e-4, 0), along_y(0, 1e-4);
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
  stretch.col(0) += (MoveAt(s, corner + along_x) - MoveAt(s, corner - along_x)) / 2e-4;
  stretch.col(1) += (MoveAt(s, corner + along_y) - MoveAt(s, corner - along_y)) / 2e-4;
  LaneBlock block;
  block.Reset(kModelPixels, 4);
  for (int lane = 0; lane < kModelPixels; ++lane) {
    block.SetCount(lane, 1);
    const std::size_t at = block.Place(lane, 0);
    const Eigen::Vector2d pixel = corner + 0.45 * Eigen::Vector2d(std::cos(1.3 * lane), std::sin(2.1 * lane)),
                          board = pixel + MoveAt(s, pixel);
    block.u_data()[at] = static_cast<float>(board.x() + s.dx);
    block.v_data()[at] = static_cast<float>(board.y() + s.dy);
    block.light_data()[at] = 0;
  }
  ModelLanes model;
  model.Reset(block.padded(), columns.products());
  const auto set = [&](int which, double value) {
    std::fill_n(model.parameter_data(which), kModelPixels, static_cast<float>(value));
  };
  // Its covariance grows with the blur as its variances do.
  constexpr double kBlur = 0.3;
  const double covariance = s.covariance * std::pow(s.blur / kBlur, 2);
  Eigen::Matrix2d blur;
  blur << s.blur * s.blur, covariance, covariance, s.blur * s.blur;
  blur = stretch * blur * stretch.transpose();
  const Eigen::Vector2d of_middle(s.way_x, s.way_y), of_turn = s.turn * Eigen::Vector2d(-kCornerY, kCornerX),
                                                     way = stretch * (of_middle + of_turn),
                                                     across = stretch * of_middle;
  set(ModelLanes::kCornerX, kCornerX), set(ModelLanes::kCornerY, kCornerY);
  set(ModelLanes::kScaleX, 1 / std::sqrt(blur(0, 0))), set(ModelLanes::kScaleY, 1 / std::sqrt(blur(1, 1)));
  set(ModelLanes::kBlurX, 1 / s.blur), set(ModelLanes::kBlurY, 1 / s.blur);
  set(ModelLanes::kCovariance, blur(0, 1));
  set(ModelLanes::kSkew, blur(0, 1));
  set(ModelLanes::kSkewByBlur, 2 * s.covariance * s.blur / (kBlur * kBlur));
  set(ModelLanes::kByPixelXx, 1), set(ModelLanes::kByPixelXy, 0), set(ModelLanes::kByPixelYx, 0),
      set(ModelLanes::kByPixelYy, 1);
  set(ModelLanes::Of<MotionTerm>(MotionTerm::kWayX), way.x()),
      set(ModelLanes::Of<MotionTerm>(MotionTerm::kWayY), way.y());
  set(ModelLanes::Of<MotionTerm>(MotionTerm::kAcrossX), -across.y()),
      set(ModelLanes::Of<MotionTerm>(MotionTerm::kAcrossY), across.x());
  const auto set_ink = [&](int which, double value) { set(ModelLanes::Of<DotGainTerm>(which), value); };
  set_ink(DotGainTerm::kGain, s.even_dark ? s.gain : -s.gain);
  for (const int first : {DotGainTerm::kEvenX0, DotGainTerm::kEvenY0}) {
    set_ink(first, 1), set_ink(first + 1, 1), set_ink(first + 2, -1), set_ink(first + 3, -1);
  }
  set_ink(DotGainTerm::kHalfEven, s.even_dark ? 0.5 : 0), set_ink(DotGainTerm::kHalfOdd, s.even_dark ? 0 : 0.5);
  set(ModelLanes::Of<ShadowTerm>(ShadowTerm::kMixedX), s.blur * s.blur * std::cos(0.5)),
      set(ModelLanes::Of<ShadowTerm>(ShadowTerm::kMixedY), s.blur * s.blur * std::sin(0.5));
  set(ModelLanes::Of<ShadingTerm>(ShadingTerm::kBlurXx), s.blur * s.blur),
      set(ModelLanes::Of<ShadingTerm>(ShadingTerm::kBlurXy), 0.1 * s.blur * s.blur),
      set(ModelLanes::Of<ShadingTerm>(ShadingTerm::kBlurYy), s.blur * s.blur);
  set(ModelLanes::Of<VeilTerm>(VeilTerm::kWhiteUnderVeil), 0.9);
  set(ModelLanes::Of<HighlightTerm>(HighlightTerm::kWhite), 0.9);
  set(ModelLanes::kNoiseFloor, 1), set(ModelLanes::kNoiseSlope, 0);
  for (int i = 0; i < ModelColumns::kLevels; ++i) {
    const bool even = (i / 4 + i % 4) % 2 == 0;
    set(ModelLanes::kLevel00 + i, (even == s.even_dark ? 0.1 : 0.8) + 0.02 * i);
  }
  ModelInput input;
  input.terms = s.terms;
  input.board_from_plane[0] = input.board_from_plane[4] = input.board_from_plane[8] = 1;
  input.taps = s.terms.on<MotionTerm>() ? 5 : 1;
  input.turn = static_cast<float>(s.turn);
  static_cast<ShadowTerm::Input&>(input) = {static_cast<float>(s.takes), static_cast<float>(std::cos(s.direction)),
                                            static_cast<float>(std::sin(s.direction)), static_cast<float>(s.offset),
                                            static_cast<float>(1 / s.width)};
  static_cast<ShadingTerm::Input&>(input) = {static_cast<float>(s.grows_x), static_cast<float>(s.grows_y)};
  static_cast<VeilTerm::Input&>(input) = {static_cast<float>(s.veil)};
  static_cast<HighlightTerm::Input&>(input) = {static_cast<float>(s.amount), static_cast<float>(s.spot_x),
                                               static_cast<float>(s.spot_y),
                                               static_cast<float>(1 / (s.spot_width * s.spot_width))};
  AccumulateModel(input, block, model);
  // Of one pixel without light, of a weight of one: the residual is what the model has, turned around.
  CornerPicture picture;
  picture.by.resize(static_cast<std::size_t>(columns.shared + ModelColumns::kLevels));
  for (int lane = 0; lane < kModelPixels; ++lane) {
    const int last = columns.residual();
    const double light = std::sqrt(double{model.sum_data(columns.Product(last, last), lane)[0]});
    picture.light.push_back(light);
    for (std::size_t a = 0; a < picture.by.size(); ++a)
      picture.by[a].push_back(-double{model.sum_data(columns.Product(static_cast<int>(a), last), lane)[0]} / light);
  }
  return picture;
}

/// Holds a column against what the light changes by; to a share of its largest value.
void ExpectColumn(const CornerScene& scene, int column, const std::function<void(CornerScene&, double)>& move,
                  double within, const char* what) {
  constexpr double kStep = 0.004;
  CornerScene more = scene, less = scene;
  move(more, kStep), move(less, -kStep);
  const CornerPicture here = Evaluate(scene), above = Evaluate(more), below = Evaluate(less);
  double most = 0;
  for (const double value : here.by[static_cast<std::size_t>(column)]) most = std::max(most, std::abs(value));
  ASSERT_GT(most, 0.01) << what << " does nothing";
  for (std::size_t i = 0; i < here.light.size(); ++i)
    EXPECT_NEAR(here.by[static_cast<std::size_t>(column)][i], (above.light[i] - below.light[i]) / (2 * kStep),
                within * most + 1e-3)
        << what << " of pixel " << i;
}

std::vector<CornerScene> Scenes() {
  std::vector<CornerScene> scenes;
  for (const bool motion : {false, true})
    for (const bool gain : {false, true})
      for (const bool shadow : {false, true}) {
        CornerScene scene;
        scene.even_dark = scenes.size() % 2 == 0;
        scene.terms.on<MotionTerm>() = motion, scene.terms.on<DotGainTerm>() = gain,
        scene.terms.on<ShadowTerm>() = shadow;
        scenes.push_back(scene);
      }
  for (const ModelTerms& terms : {ModelTerms().With<HighlightTerm>(), ModelTerms().With<ShadingTerm, HighlightTerm>(),
                                  ModelTerms().With<ShadowTerm, ShadingTerm>(),
                                  ModelTerms().With<ShadowTerm, ShadingTerm, VeilTerm, HighlightTerm>()}) {
    scenes.emplace_back();
    scenes.back().terms = terms;
  }
  return scenes;
}

TEST(ModelKernel, DerivativesAreThoseOfDifferences) {
  for (CornerScene scene : Scenes()) {
    // Those by terms leave out how the blur's covariance mixes the edges' own.
    scene.covariance = 0.004;
    SCOPED_TRACE(testing::Message() << "motion " << scene.terms.on<MotionTerm>() << " gain "
                                    << scene.terms.on<DotGainTerm>() << " shadow " << scene.terms.on<ShadowTerm>()
                                    << " shading " << scene.terms.on<ShadingTerm>() << " highlight "
                                    << scene.terms.on<HighlightTerm>());
    const ModelColumns columns(scene.terms);
    // And how a shadow's edge mixes with the slope of what it falls on, which is wider than here.
    const double within = !scene.terms.on<ShadowTerm>() ? 0.05 : scene.terms.on<MotionTerm>() ? 0.2 : 0.12;
    ExpectColumn(
        scene, 0, [](CornerScene& s, double by) { s.dx += by; }, within, "a move along x");
    ExpectColumn(
        scene, 3, [](CornerScene& s, double by) { s.dy += by; }, within, "a move along y");
    if (!scene.terms.on<ShadowTerm>())
      ExpectColumn(
          scene, columns.blur, [](CornerScene& s, double by) { s.blur += by; }, 0.07, "blur");
    if (scene.terms.on<MotionTerm>()) {
      ExpectColumn(
          scene, columns.of<MotionTerm>(), [](CornerScene& s, double by) { s.way_x += by; }, within + 0.01,
          "motion along x");
      ExpectColumn(
          scene, columns.of<MotionTerm>() + 1, [](CornerScene& s, double by) { s.way_y += by; }, within + 0.01,
          "motion along y");
      ExpectColumn(
          scene, columns.of<MotionTerm>() + 2, [](CornerScene& s, double by) { s.turn += by; }, within + 0.05, "turn");
    }
    if (scene.terms.on<DotGainTerm>())
      ExpectColumn(
          scene, columns.of<DotGainTerm>(), [](CornerScene& s, double by) { s.gain += by; }, within, "dot gain");
    if (scene.terms.on<VeilTerm>())
      ExpectColumn(
          scene, columns.of<VeilTerm>(), [](CornerScene& s, double by) { s.veil += by; }, 0.01, "veil");
    if (scene.terms.on<ShadingTerm>()) {
      ExpectColumn(
          scene, columns.of<ShadingTerm>(), [](CornerScene& s, double by) { s.grows_x += by; }, 0.01,
          "shading along x");
      ExpectColumn(
          scene, columns.of<ShadingTerm>() + 1, [](CornerScene& s, double by) { s.grows_y += by; }, 0.01, "along y");
    }
    if (scene.terms.on<HighlightTerm>()) {
      const int first = columns.of<HighlightTerm>();
      ExpectColumn(
          scene, first, [](CornerScene& s, double by) { s.amount += by; }, 0.01, "a highlight's amount");
      ExpectColumn(
          scene, first + 1, [](CornerScene& s, double by) { s.spot_x += by; }, 0.01, "its x");
      ExpectColumn(
          scene, first + 2, [](CornerScene& s, double by) { s.spot_y += by; }, 0.01, "its y");
      ExpectColumn(
          scene, first + 3, [](CornerScene& s, double by) { s.spot_width *= std::exp(by); }, 0.01, "its width");
    }
    if (!scene.terms.on<ShadowTerm>()) continue;
    ExpectColumn(
        scene, columns.of<ShadowTerm>(), [](CornerScene& s, double by) { s.takes += by; }, 0.02, "the share taken");
    ExpectColumn(
        scene, columns.of<ShadowTerm>() + 1, [](CornerScene& s, double by) { s.direction += by; }, 0.1, "direction");
    ExpectColumn(
        scene, columns.of<ShadowTerm>() + 2, [](CornerScene& s, double by) { s.offset += by; }, 0.1, "offset");
    // Shading leaves out how its slope mixes with the edge's.
    const double within_width = scene.terms.on<ShadingTerm>() ? 0.25 : 0.2;
    ExpectColumn(
        scene, columns.of<ShadowTerm>() + 3, [](CornerScene& s, double by) { s.width *= std::exp(by); }, within_width,
        "width");
  }
}

TEST(ModelKernel, MovesOfTheBoardStretchWhatTheImageHas) {
  for (CornerScene scene : Scenes()) {
    // Terms have places and directions of their own on the board, which do not move with these.
    if (scene.terms.on<ShadowTerm>() || scene.terms.on<ShadingTerm>() || scene.terms.on<HighlightTerm>()) continue;
    scene.covariance = 0.004;
    SCOPED_TRACE(testing::Message() << "motion " << scene.terms.on<MotionTerm>() << " gain "
                                    << scene.terms.on<DotGainTerm>());
    for (int column = 0; column < BoardGeometry::kParameters; ++column)
      ExpectColumn(
          scene, column, [column](CornerScene& s, double by) { s.moves[column] += by; }, 0.05,
          ("move " + std::to_string(column)).c_str());
  }
}

TEST(ModelKernel, SharesOfCellsAddUp) {
  for (const CornerScene& scene : Scenes()) {
    const ModelColumns columns(scene.terms);
    const CornerPicture picture = Evaluate(scene);
    for (std::size_t i = 0; i < picture.light.size(); ++i) {
      double sum = 0;
      for (int level = 0; level < ModelColumns::kLevels; ++level)
        sum += picture.by[static_cast<std::size_t>(columns.levels + level)][i];
      // These pixels lie within a cell of the middle, where shading changes the light by less than a tenth.
      const double shading = scene.terms.on<ShadingTerm>() ? 0.1 : 0;
      if (scene.terms.on<ShadowTerm>())
        EXPECT_TRUE(sum > 0.35 && sum < 1.01 + shading) << sum;
      else if (shading > 0)
        EXPECT_NEAR(sum, 1, shading);
      else
        EXPECT_NEAR(sum, 1, 2e-3);
    }
  }
}

TEST(ModelKernel, AWiderBlurAlongOneDirectionIsHalfTheSecondDerivative) {
  CornerScene scene{.terms = ModelTerms().With<UnevenBlurTerm>(), .covariance = 0};
  const ModelColumns columns(scene.terms);
  constexpr double kStep = 0.02;
  const auto at = [&](double dx, double dy) {
    CornerScene moved = scene;
    moved.dx = dx, moved.dy = dy;
    return Evaluate(moved);
  };
  const CornerPicture here = at(0, 0), left = at(-kStep, 0), right = at(kStep, 0), up = at(0, -kStep),
                      down = at(0, kStep);
  for (std::size_t i = 0; i < here.light.size(); ++i) {
    const double xx = (right.light[i] + left.light[i] - 2 * here.light[i]) / (kStep * kStep),
                 yy = (down.light[i] + up.light[i] - 2 * here.light[i]) / (kStep * kStep);
    EXPECT_NEAR(here.by[static_cast<std::size_t>(columns.of<UnevenBlurTerm>())][i], (xx - yy) / 2, 0.15)
        << "pixel " << i;
  }
}

TEST(ModelKernel, AllInstructionSetsSumUpTheSame) {
  for (const CornerScene& scene : Scenes()) {
    const CornerPicture expected = Evaluate(scene);
    for (const std::int64_t target : test::AllTargets()) {
      SCOPED_TRACE(hwy::TargetName(target));
      hwy::SetSupportedTargetsForTest(target);
      const CornerPicture found = Evaluate(scene);
      hwy::SetSupportedTargetsForTest(0);
      for (std::size_t i = 0; i < expected.light.size(); ++i) EXPECT_NEAR(found.light[i], expected.light[i], 2e-4);
    }
  }
}

}  // namespace
}  // namespace chequer
