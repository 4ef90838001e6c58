#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/board_equations.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <cstddef>

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

/// How the four phases share channels: merged[k] = half[k] + beside · half[k ^ 1], half[k] = sum[k] + opposite[k] ·
/// sum[3 − k].
struct PhaseShares {
  float opposite[4];
  float beside;
};

/// A corner as it is added.
struct CornerTerms {
  const float* sums;          ///< of the corner's first lane
  std::ptrdiff_t stride;      ///< from one kind of sum to the next
  int cell_of[4];             ///< the four cells around it
  const double *by_x, *by_y;  ///< moves of its board coordinates by the geometry's parameters
};

}  // namespace chequer
#endif  // CHEQUER_DETECT_BOARD_SYSTEM

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D4 = hn::CappedTag<double, 4>;

/// Adds what a corner says of geometry and blur alone.
void AddShape(const CornerTerms& corner, BoardSystem& system) {
  constexpr int kParameters = BoardSystem::kColumns - 2, kBlurColumn = kParameters, kResidualColumn = kParameters + 1;
  const auto sum = [&](int a, int b) HWY_ATTR {
    const float* s = corner.sums + ProductSum(a, b) * corner.stride;
    return static_cast<double>((s[0] + s[1]) + (s[2] + s[3]));
  };
  const double xx = sum(kShiftX, kShiftX), xy = sum(kShiftX, kShiftY), yy = sum(kShiftY, kShiftY);
  const double x_blur = sum(kShiftX, kBlur), y_blur = sum(kShiftY, kBlur);
  const double x_residual = sum(kShiftX, kResidual), y_residual = sum(kShiftY, kResidual);
  const D4 d;
  const int step = static_cast<int>(hn::Lanes(d));
  for (int a = 0; a < kParameters; ++a) {
    const double ax = corner.by_x[a], ay = corner.by_y[a];
    const auto along_x = hn::Set(d, xx * ax + xy * ay), along_y = hn::Set(d, xy * ax + yy * ay);
    double* HWY_RESTRICT row = system.normal[a];
    for (int b = 0; b < kParameters; b += step)
      hn::StoreU(hn::MulAdd(along_x, hn::LoadU(d, corner.by_x + b),
                            hn::MulAdd(along_y, hn::LoadU(d, corner.by_y + b), hn::LoadU(d, row + b))),
                 d, row + b);
    row[kBlurColumn] += x_blur * ax + y_blur * ay;
    row[kResidualColumn] += x_residual * ax + y_residual * ay;
  }
  system.normal[kBlurColumn][kBlurColumn] += sum(kBlur, kBlur);
  system.normal[kBlurColumn][kResidualColumn] += sum(kBlur, kResidual);
  system.normal[kResidualColumn][kResidualColumn] += sum(kResidual, kResidual);
}

/// Each phase's sum becomes that of its channel.
HWY_INLINE void MergePhases(const CornerTerms& corner, int sum, const PhaseShares& shares, float* merged) {
  const float* s = corner.sums + sum * corner.stride;
#if HWY_TARGET == HWY_SCALAR
  float half[4];
  for (int k = 0; k < 4; ++k) half[k] = s[k] + shares.opposite[k] * s[3 - k];
  for (int k = 0; k < 4; ++k) merged[k] = half[k] + shares.beside * half[k ^ 1];
#else
  const hn::FixedTag<float, 4> d;
  const auto sums = hn::LoadU(d, s);
  const auto half = hn::MulAdd(hn::LoadU(d, shares.opposite), hn::Reverse(d, sums), sums);
  hn::StoreU(hn::MulAdd(hn::Set(d, shares.beside), hn::Shuffle2301(half), half), d, merged);
#endif
}

/// Adds a corner's levels.
void AddLevels(const CornerTerms& corner, const PhaseShares& shares, BoardSystem& system) {
  constexpr int kParameters = BoardSystem::kColumns - 2;
  const D4 d;
  const hn::Rebind<float, D4> df;
  const int step = static_cast<int>(hn::Lanes(d));
  float merged[4][kLaneColumns][4];
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < kLevel00; ++b) MergePhases(corner, ProductSum(kLevel00 + a, b), shares, merged[a][b]);
    for (int b = kLevel00 + a; b < kLaneColumns; ++b)
      MergePhases(corner, ProductSum(kLevel00 + a, b), shares, merged[a][b]);
  }
  for (int part = 0; part < 4; part += step)
    for (int a = 0; a < 4; ++a) {
      const auto product = [&](int b) HWY_ATTR { return hn::PromoteTo(d, hn::LoadU(df, merged[a][b] + part)); };
      const int cell = corner.cell_of[a];
      for (int b = a; b < 4; ++b) {
        double* to = system.matrix + (cell * (system.band + 1) + corner.cell_of[b] - cell) * 4 + part;
        hn::StoreU(hn::Add(hn::LoadU(d, to), product(kLevel00 + b)), d, to);
      }
      const auto shift_x = product(kShiftX), shift_y = product(kShiftY);
      double* HWY_RESTRICT to = system.right + cell * BoardSystem::kColumns * 4 + part;
      for (int column = 0; column < kParameters; ++column, to += 4)
        hn::StoreU(hn::MulAdd(shift_x, hn::Set(d, corner.by_x[column]),
                              hn::MulAdd(shift_y, hn::Set(d, corner.by_y[column]), hn::LoadU(d, to))),
                   d, to);
      hn::StoreU(hn::Add(hn::LoadU(d, to), product(kBlur)), d, to);
      to += 4;
      hn::StoreU(hn::Add(hn::LoadU(d, to), product(kResidual)), d, to);
    }
}

void AddCorner(const CornerTerms& corner, const PhaseShares& shares, BoardSystem& system) {
  AddShape(corner, system);
  AddLevels(corner, shares, system);
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

#include <algorithm>
#include <cstring>

#include "detect/board_equations.h"

namespace chequer {
namespace {

static_assert(BoardSystem::kColumns == BoardEquations::kUnknowns + 1);

HWY_EXPORT(AddCorner);
HWY_EXPORT(Solve);
HWY_EXPORT(SolveBack);

/// Added to the diagonal of the levels, whose entries count pixels over their variance: cells that nothing has seen
/// stay where they are.
constexpr double kLeastInformation = 1e-3;

/// Each phase's own channel of a mosaic, or one for all.
PhaseShares SharesOf(int red_phase, double* phase_weight) {
  PhaseShares shares{{1, 1, 1, 1}, 1};
  std::fill_n(phase_weight, 4, 0.0);
  if (red_phase < 0) {
    phase_weight[0] = 1;
    return shares;
  }
  // Green are the two phases beside the red one; they hold the same sums and count once.
  shares = {{0, 0, 0, 0}, 0};
  shares.opposite[red_phase ^ 1] = shares.opposite[red_phase ^ 2] = 1;
  phase_weight[red_phase] = phase_weight[3 - red_phase] = phase_weight[red_phase ^ 1] = 1;
  return shares;
}

}  // namespace

void BoardEquations::Assemble(const Input& input) {
  const BoardPixels& pixels = *input.pixels;
  const MarkerSize size = pixels.size();
  cells_ = size.rows * size.cols;
  band_ = size.cols + 1;
  matrix_.resize(static_cast<std::size_t>(cells_ * (band_ + 1) * 4));
  right_.resize(static_cast<std::size_t>(cells_ * BoardSystem::kColumns * 4));
  std::memset(matrix_.data(), 0, matrix_.size() * sizeof(double));
  std::memset(right_.data(), 0, right_.size() * sizeof(double));
  BoardSystem system;
  system.cells = cells_;
  system.band = band_;
  system.matrix = matrix_.data();
  system.right = right_.data();
  const PhaseShares shares = SharesOf(input.red_phase, system.phase_weight);
  const LaneBlock& lanes = pixels.lanes();
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (!input.used[static_cast<std::size_t>(corner)]) continue;
    const CornerDerivative& by = input.derivatives[static_cast<std::size_t>(corner)];
    const int cell = pixels.Cell(corner);
    HWY_DYNAMIC_DISPATCH(AddCorner)
    ({.sums = lanes.sum_data(0) + pixels.Lane(corner),
      .stride = lanes.padded(),
      .cell_of = {cell, cell + 1, cell + size.cols, cell + size.cols + 1},
      .by_x = by.x.data(),
      .by_y = by.y.data()},
     shares, system);
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
