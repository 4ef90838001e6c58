// Of BoardFit: what the frames of a stream have learnt of a board makes its pose better.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/small_cholesky.h"
#include "detect/fit/board_fit.h"
#include "detect/fit/board_fit_limits.h"

namespace chequer {
namespace {

constexpr int kShapes = 3, kLevels = 4, kLights = LevelProducts::kLights, kGeometry = BoardGeometry::kParameters,
              kShared = LevelProducts::kShared;
static_assert(kShared == BoardEquations::kUnknowns && kShared == ModelColumns::kGeometry + 1,
              "without terms, both models have the same");

using ByShared = Eigen::Matrix<double, kShared, 1 + kLights>;
using Square = Eigen::Matrix<double, 1 + kLights, 1 + kLights>;
/// Of a cell's level: by how much it differs from what was learnt, and changes with its illumination.
using LevelRow = Eigen::Matrix<double, 1, 1 + kLights>;

/// A cell's middle, ±1 at the rim of the board's longer side.
Eigen::Vector2d PlaceOf(MarkerSize size, int cell) {
  return 2.0 / std::max(size.rows, size.cols) * MiddleOfCell(size, cell);
}

/// Those of all cells and channels.
class LevelRows {
 public:
  LevelRows(const BoardRun& run, const LearntBoard& learnt) : channels_(static_cast<std::size_t>(run.view.channels)) {
    rows_.Assign(channels_ * run.result.levels.size(), LevelRow::Zero());
    LevelRow* row = rows_.begin();
    for (std::size_t cell = 0; cell < run.result.levels.size(); ++cell) {
      const Eigen::Vector2d at = PlaceOf(run.view.size, static_cast<int>(cell));
      for (std::size_t channel = 0; channel < channels_; ++channel) {
        const double own = double{run.result.levels[cell][static_cast<Eigen::Index>(channel)]},
                     level = double{learnt.levels[cell][channel]};
        *row++ = {own - level, level, level * at.x(), level * at.y()};
      }
    }
  }
  const LevelRow& Of(int cell, int channel) const {
    return rows_[static_cast<std::size_t>(cell) * channels_ + static_cast<std::size_t>(channel)];
  }

 private:
  std::size_t channels_;
  FixedVector<LevelRow, 3 * kMaxCells> rows_;  // not allocated anew with every board
};

/// Scales what was learnt to this frame's illumination, channel by channel.
void ScaleToLight(const BoardRun& run, LearntBoard& learnt) {
  const std::vector<Eigen::Vector3f>& own = run.result.levels;
  for (int channel = 0; channel < run.view.channels; ++channel) {
    const std::size_t i = static_cast<std::size_t>(channel);
    double both = 0, square = 1e-12;
    for (std::size_t cell = 0; cell < own.size(); ++cell) {
      const double level = double{learnt.levels[cell][i]};
      both += level * double{own[cell][channel]};
      square += level * level;
    }
    for (std::size_t cell = 0; cell < own.size(); ++cell) learnt.levels[cell][i] *= static_cast<float>(both / square);
  }
}

/// The learnt levels, to the mean of both.
void MoveLevels(const BoardRun& run, const LearntStep& step, LearntBoard& learnt) {
  const std::vector<Eigen::Vector3f>& own = run.result.levels;
  for (std::size_t cell = 0; cell < own.size(); ++cell) {
    const Eigen::Vector2d at = PlaceOf(run.view.size, static_cast<int>(cell));
    for (int channel = 0; channel < run.view.channels; ++channel) {
      float& level = learnt.levels[cell][static_cast<std::size_t>(channel)];
      const auto lights = step.lights.segment<kLights>(kLights * channel);
      const double lit = double{level} * (1 + lights.dot(Eigen::Vector3d(1, at.x(), at.y())));
      level = static_cast<float>(std::lerp(double{own[cell][channel]}, lit, step.share));
    }
  }
}

/// Products of the plain model's columns at a corner in one channel: shifts and blur, the levels of its four cells (of
/// these the upper triangle).
struct CornerProducts {
  Eigen::Matrix<double, kShapes, kShapes> shapes = Eigen::Matrix<double, kShapes, kShapes>::Zero();
  Eigen::Matrix<double, kShapes, kLevels> mixed = Eigen::Matrix<double, kShapes, kLevels>::Zero();
  Eigen::Matrix<double, kLevels, kLevels> levels = Eigen::Matrix<double, kLevels, kLevels>::Zero();

  void Add(const LaneBlock& lanes, int lane) {
    const auto sum = [&](int a, int b) { return double{lanes.sum(ProductSum(a, b), lane)}; };
    for (int a = 0; a < kShapes; ++a) {
      for (int b = 0; b < kShapes; ++b) shapes(a, b) += sum(kShiftX + a, kShiftX + b);
      for (int b = 0; b < kLevels; ++b) mixed(a, b) += sum(kShiftX + a, kLevel00 + b);
    }
    for (int a = 0; a < kLevels; ++a)
      for (int b = a; b < kLevels; ++b) levels(a, b) += sum(kLevel00 + a, kLevel00 + b);
  }
};

/// Adds to `to` what rows by x shift, y shift and blur are by the shared unknowns.
template <class Rows, class To>
void AddByShared(const CornerDerivative& by, const Rows& rows, To&& to) {
  for (int column = 0; column < rows.cols(); ++column) {
    to.col(column).template head<kGeometry>() += by.x * rows(0, column) + by.y * rows(1, column);
    to(kGeometry, column) += rows(2, column);
  }
}

}  // namespace

bool BoardFit::ShowsLevels() const {
  // The sums must be those of its last step: another fit since then has collected its own pixels, and FindDotGain(),
  // which goes over the same ones, is asked of boards alone that are not flat.
  return run_->told.settled && run_->number == pixels_of_ &&
         !(run_->terms.look_farther ? ModelTerms::Of(run_->model).any() : !BoardModel::IsPlain(run_->model)) &&
         !run_->model.own_levels && !run_->bend.found && !run_->bend.taken_out && !MayBeOutOfRegister() &&
         !run_->view.overexposed && (run_->terms.look_farther || run_->plain_input.stride == 1) &&
         run_->result.flat() && run_->result.visibility.ShowsAllCorners();
}

LevelProducts BoardFit::SumPlainProducts(const LearntBoard& learnt) {
  if (run_->told.sums_gone) {
    SetLanes();
    SumPlain();
  }
  LevelProducts sums(run_->view.channels);
  const LevelRows rows(*run_, learnt);
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner)];
    const std::array<int, kLevels> cells = CellsAround(run_->view.size, corner);
    Eigen::Matrix<double, kShapes, kShapes> shapes = Eigen::Matrix<double, kShapes, kShapes>::Zero();
    for (int channel = 0; channel < run_->view.channels; ++channel) {
      CornerProducts products;
      for (int phase = 0; phase < 4; ++phase)
        if (run_->view.channel_of_phase[static_cast<std::size_t>(phase)] == channel)
          products.Add(pixels_.lanes(), pixels_.Lane(corner) + phase);
      Eigen::Matrix<double, kLevels, 1 + kLights> columns;
      for (int i = 0; i < kLevels; ++i) columns.row(i) = rows.Of(cells[static_cast<std::size_t>(i)], channel);
      products.levels.triangularView<Eigen::StrictlyLower>() = products.levels.transpose();
      const Eigen::Matrix<double, kShapes, 1 + kLights> mixed = products.mixed.lazyProduct(columns);
      ByShared by_shared = ByShared::Zero();
      AddByShared(by, mixed, by_shared);
      const Square square = columns.transpose().lazyProduct(products.levels.lazyProduct(columns).eval());
      sums.Add(channel, by_shared, square);
      shapes += products.shapes;
    }
    Eigen::Matrix<double, kShared, kShapes> once = Eigen::Matrix<double, kShared, kShapes>::Zero();
    AddByShared(by, shapes, once);
    AddByShared(by, once.transpose().eval(), sums.products.topLeftCorner<kShared, kShared>());
  }
  return sums;
}

LevelProducts BoardFit::SumModelProducts(const LearntBoard& learnt) const {
  LevelProducts sums(run_->view.channels);
  const LevelRows rows(*run_, learnt);
  const ModelColumns columns(run_->model_input.terms);
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const float* const of_corner = model_lanes_.sum_data(0, pixels_.Lane(corner));
    const ModelEquations::LevelsAround16& around = run_->around.levels[static_cast<std::size_t>(corner)];
    for (int phase = 0; phase < 4; ++phase) {
      const int channel = run_->view.channel_of_phase[static_cast<std::size_t>(phase)];
      const auto sum = [&](int a, int b) {
        return double{of_corner[ModelLanes::kNextProduct * columns.Product(std::min(a, b), std::max(a, b)) + phase]};
      };
      ByShared by_shared = ByShared::Zero();
      Square square = Square::Zero();
      for (int i = 0; i < ModelColumns::kLevels; ++i) {
        const int cell = around[static_cast<std::size_t>(i)];
        if (cell == ModelEquations::kNoLevel) continue;
        const LevelRow& row = rows.Of(cell, channel);
        for (int a = 0; a < kShared; ++a) by_shared.row(a) += sum(a, columns.levels + i) * row;
        for (int k = 0; k < i; ++k) {
          const int other = around[static_cast<std::size_t>(k)];
          if (other == ModelEquations::kNoLevel) continue;
          const Square both = row.transpose() * rows.Of(other, channel);
          square += sum(columns.levels + i, columns.levels + k) * (both + both.transpose());
        }
        square += sum(columns.levels + i, columns.levels + i) * row.transpose() * row;
      }
      sums.Add(channel, by_shared, square);
      for (int a = 0; a < kShared; ++a)
        for (int b = 0; b < kShared; ++b) sums.products(a, b) += sum(a, b);
    }
  }
  return sums;
}

bool BoardFit::UseLearntLevels(LearntBoard& learnt) {
  if (!ShowsLevels()) return false;
  const std::vector<Eigen::Vector3f>& levels = run_->result.levels;
  const bool first = learnt.levels.size() != levels.size(), all_terms = run_->terms.look_farther;
  if (first) {
    learnt.levels.Assign(levels.size(), {});
    for (std::size_t cell = 0; cell < levels.size(); ++cell)
      std::copy_n(levels[cell].data(), 3, learnt.levels[cell].begin());
  } else {
    ScaleToLight(*run_, learnt);
  }
  work_.Add(WorkStep::kFitStep, 2);  // as many instructions
  if (all_terms && run_->told.sums_gone) SolveModel(StrideFor(kMostPixels));
  LevelProducts products = all_terms ? SumModelProducts(learnt) : SumPlainProducts(learnt);
  products.Mirror();
  OwnEstimate own{.pixel_variance = run_->told.pixel_variance,
                  .levels = static_cast<int>(levels.size()) * run_->view.channels};
  own.covariance = all_terms ? LevelProducts::SharedSquare(model_equations_.Covariance())
                             : LevelProducts::SharedSquare(InverseOf(equations_.normal()));
  if (first) {
    learnt.light = StartLearning(products, own);
    return false;
  }
  LearntStep step;
  const bool used = UseLearnt(products, own, learnt.light, step);
  MoveLevels(*run_, step, learnt);
  if (!used) return false;
  run_->model.geometry.MoveCoordinates(step.moves.head<kGeometry>());
  run_->result.geometry = run_->model.geometry;
  TellInformation(InverseOf<kGeometry>(step.covariance.topLeftCorner<kGeometry, kGeometry>()), run_->told.variance);
  return true;
}

}  // namespace chequer
