#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/board_equations.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/photometric_kernel.h"

#ifndef CHEQUER_DETECT_BOARD_SYSTEM
#define CHEQUER_DETECT_BOARD_SYSTEM
namespace chequer {

/// What the loops below work on: plain arrays, so that nothing that other files use too is compiled for one target.
struct BoardSystem {
  /// Eight parameters of the geometry, the blur, the residual.
  static constexpr int kColumns = 10;

  int cells = 0, band = 0;
  double* matrix = nullptr;  ///< [cell][band + 1][4]
  double* right = nullptr;   ///< [cell][kColumns][4]
  double phase_weight[4] = {};
  double normal[kColumns][kColumns] = {};  ///< upper triangle
};

/// A corner's sums, made ready.
struct CornerSums {
  /// Products of the four level columns with each other and with the other columns; by phase, merged by channel.
  double levels[4][4][4];  ///< [level][level][phase]
  double shift_x[4][4];    ///< [level][phase]
  double shift_y[4][4];
  double blur[4][4];
  double residual[4][4];
};

}  // namespace chequer
#endif  // CHEQUER_DETECT_BOARD_SYSTEM

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D4 = hn::CappedTag<double, 4>;

/// Adds a corner's levels to the system: `cell_of` its four cells, by_x and by_y the columns that its shifts move.
void AddLevels(const CornerSums& sums, const int* cell_of, const double* by_x, const double* by_y,
               BoardSystem& system) {
  const D4 d;
  const int step = static_cast<int>(hn::Lanes(d));
  constexpr int kParameters = BoardSystem::kColumns - 2;
  for (int part = 0; part < 4; part += step)
    for (int a = 0; a < 4; ++a) {
      for (int b = a; b < 4; ++b) {
        double* to = system.matrix + (cell_of[a] * (system.band + 1) + cell_of[b] - cell_of[a]) * 4 + part;
        hn::StoreU(hn::Add(hn::LoadU(d, to), hn::LoadU(d, sums.levels[a][b] + part)), d, to);
      }
      const auto shift_x = hn::LoadU(d, sums.shift_x[a] + part), shift_y = hn::LoadU(d, sums.shift_y[a] + part);
      double* HWY_RESTRICT to = system.right + cell_of[a] * BoardSystem::kColumns * 4 + part;
      for (int column = 0; column < kParameters; ++column, to += 4)
        hn::StoreU(hn::MulAdd(shift_x, hn::Set(d, by_x[column]),
                              hn::MulAdd(shift_y, hn::Set(d, by_y[column]), hn::LoadU(d, to))),
                   d, to);
      hn::StoreU(hn::Add(hn::LoadU(d, to), hn::LoadU(d, sums.blur[a] + part)), d, to);
      to += 4;
      hn::StoreU(hn::Add(hn::LoadU(d, to), hn::LoadU(d, sums.residual[a] + part)), d, to);
    }
}

/// matrix becomes its Cholesky factor L with the inverses of the diagonal in the diagonal's place, right becomes
/// L⁻¹ right.
void Factor(double least, BoardSystem& system) {
  const D4 d;
  const int step = static_cast<int>(hn::Lanes(d));
  using V = hn::Vec<D4>;
  constexpr int kColumns = BoardSystem::kColumns;
  const int band = system.band, stride = 4 * (band + 1);
  for (int part = 0; part < 4; part += step)
    for (int j = 0; j < system.cells; ++j) {
      double* HWY_RESTRICT column = system.matrix + j * stride + part;
      const int above = j < band ? j : band, below = system.cells - 1 - j < band ? system.cells - 1 - j : band;
      // What the columns before leave of this one.
      for (int i = 1; i <= above; ++i) {
        const double* HWY_RESTRICT before = system.matrix + (j - i) * stride + i * 4 + part;
        const V factor = hn::LoadU(d, before);
        for (int e = 0; e <= band - i && e <= below; ++e)
          hn::StoreU(hn::NegMulAdd(factor, hn::LoadU(d, before + 4 * e), hn::LoadU(d, column + 4 * e)), d,
                     column + 4 * e);
      }
      const V floor = hn::Set(d, least);
      const V inverse = hn::Div(hn::Set(d, 1.0), hn::Sqrt(hn::Max(hn::Add(hn::LoadU(d, column), floor), floor)));
      hn::StoreU(inverse, d, column);
      for (int e = 1; e <= below; ++e) hn::StoreU(hn::Mul(hn::LoadU(d, column + 4 * e), inverse), d, column + 4 * e);
      double* HWY_RESTRICT right = system.right + j * kColumns * 4 + part;
      V sum[static_cast<std::size_t>(kColumns)];
      for (int c = 0; c < kColumns; ++c) sum[c] = hn::LoadU(d, right + 4 * c);
      for (int i = 1; i <= above; ++i) {
        const V factor = hn::LoadU(d, system.matrix + (j - i) * stride + i * 4 + part);
        const double* HWY_RESTRICT before = right - i * kColumns * 4;
        for (int c = 0; c < kColumns; ++c) sum[c] = hn::NegMulAdd(factor, hn::LoadU(d, before + 4 * c), sum[c]);
      }
      for (int c = 0; c < kColumns; ++c) hn::StoreU(hn::Mul(sum[c], inverse), d, right + 4 * c);
    }
}

/// normal −= Σ over cells and channels of the half-solved right-hand sides' products.
void Eliminate(BoardSystem& system) {
  const D4 d;
  const int step = static_cast<int>(hn::Lanes(d));
  using V = hn::Vec<D4>;
  constexpr int kColumns = BoardSystem::kColumns;
  for (int part = 0; part < 4; part += step) {
    const V weight = hn::LoadU(d, system.phase_weight + part);
    for (int a = 0; a < kColumns; ++a) {
      V sum[static_cast<std::size_t>(kColumns)];
      for (int b = a; b < kColumns; ++b) sum[b] = hn::Zero(d);
      const double* HWY_RESTRICT right = system.right + part;
      for (int cell = 0; cell < system.cells; ++cell, right += kColumns * 4) {
        const V factor = hn::LoadU(d, right + 4 * a);
        for (int b = a; b < kColumns; ++b) sum[b] = hn::MulAdd(factor, hn::LoadU(d, right + 4 * b), sum[b]);
      }
      for (int b = a; b < kColumns; ++b) system.normal[a][b] -= hn::GetLane(hn::SumOfLanes(d, hn::Mul(sum[b], weight)));
    }
  }
}

void Solve(double least, BoardSystem& system) {
  Factor(least, system);
  Eliminate(system);
}

/// The levels' moves, into the first right-hand side: L⁻ᵀ (last column − the others times the step).
void SolveBack(const double* unknowns, BoardSystem& system) {
  const D4 d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kColumns = BoardSystem::kColumns;
  const int band = system.band;
  for (int part = 0; part < 4; part += lanes)
    for (int j = system.cells - 1; j >= 0; --j) {
      double* right = system.right + j * kColumns * 4 + part;
      auto sum = hn::LoadU(d, right + 4 * (kColumns - 1));
      for (int c = 0; c < kColumns - 1; ++c)
        sum = hn::NegMulAdd(hn::LoadU(d, right + 4 * c), hn::Set(d, unknowns[c]), sum);
      const double* column = system.matrix + j * 4 * (band + 1) + part;
      for (int e = 1; e <= band && j + e < system.cells; ++e)
        sum = hn::NegMulAdd(hn::LoadU(d, column + 4 * e), hn::LoadU(d, right + e * kColumns * 4), sum);
      hn::StoreU(hn::Mul(sum, hn::LoadU(d, column)), d, right);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include "detect/board_equations.h"

namespace chequer {
namespace {

static_assert(BoardSystem::kColumns == BoardEquations::kUnknowns + 1);

HWY_EXPORT(AddLevels);
HWY_EXPORT(Solve);
HWY_EXPORT(SolveBack);

/// Added to the diagonal of the levels, whose entries count pixels over their variance: cells that nothing has seen
/// stay where they are.
constexpr double kLeastInformation = 1e-3;

/// How the four phases share channels.
struct PhaseMerge {
  explicit PhaseMerge(int red_phase) {
    if (red_phase < 0) {
      opposite = {1, 1, 1, 1};
      beside = 1;
      weight = {1, 0, 0, 0};
      return;
    }
    // Green are the two phases beside the red one.
    const std::size_t red = static_cast<std::size_t>(red_phase);
    opposite[red ^ 1] = opposite[red ^ 2] = 1;
    weight[red] = weight[3 - red] = weight[red ^ 1] = 1;
  }

  /// Each phase's sum becomes that of its channel.
  void operator()(const float* sums, double* merged) const {
    double half[4];
    for (std::size_t k = 0; k < 4; ++k) half[k] = double{sums[k]} + opposite[k] * double{sums[3 - k]};
    for (std::size_t k = 0; k < 4; ++k) merged[k] = half[k] + beside * half[k ^ 1];
  }

  std::array<double, 4> opposite{}, weight{};
  double beside = 0;
};

void MergeSums(const LaneBlock& lanes, int lane, const PhaseMerge& merge, CornerSums& sums) {
  for (int a = 0; a < 4; ++a) {
    const int level = kLevel00 + a;
    for (int b = a; b < 4; ++b) merge(lanes.sum_data(ProductSum(level, kLevel00 + b)) + lane, sums.levels[a][b]);
    merge(lanes.sum_data(ProductSum(kShiftX, level)) + lane, sums.shift_x[a]);
    merge(lanes.sum_data(ProductSum(kShiftY, level)) + lane, sums.shift_y[a]);
    merge(lanes.sum_data(ProductSum(kBlur, level)) + lane, sums.blur[a]);
    merge(lanes.sum_data(ProductSum(level, kResidual)) + lane, sums.residual[a]);
  }
}

/// Adds what a corner says of geometry and blur alone.
void AddShape(const LaneBlock& lanes, int lane, const CornerDerivative& by, BoardSystem& system) {
  const auto sum = [&](int a, int b) {
    const float* s = lanes.sum_data(ProductSum(a, b)) + lane;
    return double{s[0]} + double{s[1]} + double{s[2]} + double{s[3]};
  };
  const double xx = sum(kShiftX, kShiftX), xy = sum(kShiftX, kShiftY), yy = sum(kShiftY, kShiftY);
  const double x_blur = sum(kShiftX, kBlur), y_blur = sum(kShiftY, kBlur);
  const double x_residual = sum(kShiftX, kResidual), y_residual = sum(kShiftY, kResidual);
  constexpr int blur = BoardSystem::kColumns - 2, residual = BoardSystem::kColumns - 1;
  for (int a = 0; a < blur; ++a) {
    const double ax = by.x[static_cast<std::size_t>(a)], ay = by.y[static_cast<std::size_t>(a)];
    const double along_x = xx * ax + xy * ay, along_y = xy * ax + yy * ay;
    double* row = system.normal[a];
    for (int b = a; b < blur; ++b)
      row[b] += along_x * by.x[static_cast<std::size_t>(b)] + along_y * by.y[static_cast<std::size_t>(b)];
    row[blur] += x_blur * ax + y_blur * ay;
    row[residual] += x_residual * ax + y_residual * ay;
  }
  system.normal[blur][blur] += sum(kBlur, kBlur);
  system.normal[blur][residual] += sum(kBlur, kResidual);
  system.normal[residual][residual] += sum(kResidual, kResidual);
}

}  // namespace

void BoardEquations::Assemble(const Input& input) {
  const BoardPixels& pixels = *input.pixels;
  const MarkerSize size = pixels.size();
  cells_ = size.rows * size.cols;
  band_ = size.cols + 1;
  matrix_.assign(static_cast<std::size_t>(cells_ * (band_ + 1) * 4), 0.0);
  right_.assign(static_cast<std::size_t>(cells_ * BoardSystem::kColumns * 4), 0.0);
  BoardSystem system;
  system.cells = cells_;
  system.band = band_;
  system.matrix = matrix_.data();
  system.right = right_.data();
  const PhaseMerge merge(input.red_phase);
  std::copy(merge.weight.begin(), merge.weight.end(), system.phase_weight);
  CornerSums sums;
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (!input.used[static_cast<std::size_t>(corner)]) continue;
    const CornerDerivative& by = input.derivatives[static_cast<std::size_t>(corner)];
    const int lane = pixels.Lane(corner), cell = pixels.Cell(corner);
    const int cell_of[4] = {cell, cell + 1, cell + size.cols, cell + size.cols + 1};
    AddShape(pixels.lanes(), lane, by, system);
    MergeSums(pixels.lanes(), lane, merge, sums);
    HWY_DYNAMIC_DISPATCH(AddLevels)(sums, cell_of, by.x.data(), by.y.data(), system);
  }
  HWY_DYNAMIC_DISPATCH(Solve)(kLeastInformation, system);
  for (int a = 0; a < kUnknowns; ++a) {
    for (int b = a; b < kUnknowns; ++b) normal_(a, b) = normal_(b, a) = system.normal[a][b];
    gradient_[a] = system.normal[a][kUnknowns];
  }
  chi_square_ = system.normal[kUnknowns][kUnknowns];
}

void BoardEquations::MoveLevels(const Vector& step, std::span<PhaseValues> levels) {
  BoardSystem system;
  system.cells = cells_;
  system.band = band_;
  system.matrix = matrix_.data();
  system.right = right_.data();
  HWY_DYNAMIC_DISPATCH(SolveBack)(step.data(), system);
  for (int cell = 0; cell < cells_; ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase)
      levels[static_cast<std::size_t>(cell)][phase] +=
          static_cast<float>(right_[static_cast<std::size_t>(cell * BoardSystem::kColumns * 4) + phase]);
}

}  // namespace chequer
#endif  // HWY_ONCE
