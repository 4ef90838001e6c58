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
  /// Floats of a cell's right-hand sides: whole vectors, whatever their length.
  static constexpr int kRightRow = 48;

  int cells = 0, band = 0;
  /// Floats of a column of the matrix: entries up to the band, then zeros, which vectors run into.
  int matrix_row = 0;
  // Both at whole vectors in memory.
  float* matrix = nullptr;  ///< [cell][entry from the diagonal down][4], rows of matrix_row
  float* right = nullptr;   ///< [cell][column][4], rows of kRightRow
  float phase_weight[4] = {};
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
/// Of one phase each, and of as many groups of four phases as vectors hold.
using DPhases = hn::CappedTag<float, 4>;
using DGroups = hn::CappedTag<float, 16>;
constexpr int kGroupLanes = static_cast<int>(hn::MaxLanes(DGroups()));

/// The values of the four phases for lanes at → … of an array of such groups.
HWY_INLINE hn::Vec<DGroups> Repeat(DGroups d, const float* phases, int at) {
  return kGroupLanes < 4 ? hn::LoadU(d, phases + at % 4) : hn::LoadDup128(d, phases);
}

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
  constexpr int kParameters = BoardSystem::kColumns - 2, kBlurAt = 4 * kParameters, kResidualAt = kBlurAt + 4;
  const DPhases d;
  const DGroups groups;
  const int step = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float merged[4][kLaneColumns][4];
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < kLevel00; ++b) MergePhases(corner, ProductSum(kLevel00 + a, b), shares, merged[a][b]);
    for (int b = kLevel00 + a; b < kLaneColumns; ++b)
      MergePhases(corner, ProductSum(kLevel00 + a, b), shares, merged[a][b]);
  }
  HWY_ALIGN float by_x[4 * kParameters], by_y[4 * kParameters];
  for (int column = 0; column < kParameters; ++column)
    for (int part = 0; part < 4; part += step) {
      hn::StoreU(hn::Set(d, static_cast<float>(corner.by_x[column])), d, by_x + 4 * column + part);
      hn::StoreU(hn::Set(d, static_cast<float>(corner.by_y[column])), d, by_y + 4 * column + part);
    }
  const auto add = [&](const float* values, float* to) HWY_ATTR {
    for (int part = 0; part < 4; part += step)
      hn::StoreU(hn::Add(hn::LoadU(d, to + part), hn::LoadU(d, values + part)), d, to + part);
  };
  for (int a = 0; a < 4; ++a) {
    const int cell = corner.cell_of[a];
    for (int b = a; b < 4; ++b)
      add(merged[a][kLevel00 + b], system.matrix + cell * system.matrix_row + 4 * (corner.cell_of[b] - cell));
    float* HWY_RESTRICT to = system.right + cell * BoardSystem::kRightRow;
    for (int at = 0; at < 4 * kParameters; at += kGroupLanes) {
      const auto along_x =
          hn::MulAdd(Repeat(groups, merged[a][kShiftX], at), hn::LoadU(groups, by_x + at), hn::LoadU(groups, to + at));
      hn::StoreU(hn::MulAdd(Repeat(groups, merged[a][kShiftY], at), hn::LoadU(groups, by_y + at), along_x), groups,
                 to + at);
    }
    add(merged[a][kBlur], to + kBlurAt);
    add(merged[a][kResidual], to + kResidualAt);
  }
}

void AddCorner(const CornerTerms& corner, const PhaseShares& shares, BoardSystem& system) {
  AddShape(corner, system);
  AddLevels(corner, shares, system);
}

/// matrix becomes its Cholesky factor L with the inverses of the diagonal in the diagonal's place, right becomes
/// L⁻¹ right.
void Factor(float least, BoardSystem& system) {
  const DPhases d;
  const DGroups groups;
  const int step = static_cast<int>(hn::Lanes(d)), band = system.band;
  const int column_floats = (4 * (band + 1) + kGroupLanes - 1) / kGroupLanes * kGroupLanes;
  for (int j = 0; j < system.cells; ++j) {
    float* HWY_RESTRICT column = system.matrix + j * system.matrix_row;
    float* HWY_RESTRICT right = system.right + j * BoardSystem::kRightRow;
    const int above = j < band ? j : band;
    // What the columns before leave of this one. Below the matrix and its band stand zeros.
    for (int at = 0; at < column_floats; at += kGroupLanes) {
      auto sum = hn::LoadU(groups, column + at);
      const float* before = column - system.matrix_row + 4;
      for (int i = 1; i <= above; ++i, before += 4 - system.matrix_row)
        sum = hn::NegMulAdd(Repeat(groups, before, at), hn::LoadU(groups, before + at), sum);
      hn::StoreU(sum, groups, column + at);
    }
    HWY_ALIGN float inverse[4];
    for (int part = 0; part < 4; part += step) {
      const auto floor = hn::Set(d, least);
      const auto pivot = hn::Max(hn::Add(hn::LoadU(d, column + part), floor), floor);
      hn::StoreU(hn::Div(hn::Set(d, 1.0f), hn::Sqrt(pivot)), d, inverse + part);
    }
    for (int at = 0; at < column_floats; at += kGroupLanes)
      hn::StoreU(hn::Mul(hn::LoadU(groups, column + at), Repeat(groups, inverse, at)), groups, column + at);
    for (int part = 0; part < 4; ++part) column[part] = inverse[part];
    for (int at = 0; at < BoardSystem::kRightRow; at += kGroupLanes) {
      auto sum = hn::LoadU(groups, right + at);
      const float *factor = column - system.matrix_row + 4, *before = right - BoardSystem::kRightRow;
      for (int i = 1; i <= above; ++i, factor += 4 - system.matrix_row, before -= BoardSystem::kRightRow)
        sum = hn::NegMulAdd(Repeat(groups, factor, at), hn::LoadU(groups, before + at), sum);
      hn::StoreU(hn::Mul(sum, Repeat(groups, inverse, at)), groups, right + at);
    }
  }
}

/// normal −= Σ over cells and channels of the half-solved right-hand sides' products.
void Eliminate(BoardSystem& system) {
  const DGroups d;
  using V = hn::Vec<DGroups>;
  constexpr int kColumns = BoardSystem::kColumns, kVectors = BoardSystem::kRightRow / kGroupLanes;
  for (int a = 0; a < kColumns; ++a) {
    // Those that hold column a and what follows.
    const int first = 4 * a / kGroupLanes;
    V sum[static_cast<std::size_t>(kVectors)];
    for (int k = 0; k < kVectors; ++k) sum[k] = hn::Zero(d);
    const float* HWY_RESTRICT right = system.right;
    for (int cell = 0; cell < system.cells; ++cell, right += BoardSystem::kRightRow)
      for (int k = first; k < kVectors; ++k)
        sum[k] = hn::MulAdd(Repeat(d, right + 4 * a, k * kGroupLanes), hn::LoadU(d, right + k * kGroupLanes), sum[k]);
    HWY_ALIGN float products[BoardSystem::kRightRow];
    for (int k = first; k < kVectors; ++k)
      hn::StoreU(hn::Mul(sum[k], Repeat(d, system.phase_weight, k * kGroupLanes)), d, products + k * kGroupLanes);
    for (int b = a; b < kColumns; ++b) {
      const float* p = products + 4 * b;
      system.normal[a][b] -= static_cast<double>((p[0] + p[1]) + (p[2] + p[3]));
    }
  }
}

void Solve(float least, BoardSystem& system) {
  Factor(least, system);
  Eliminate(system);
}

/// The levels' moves, into the first right-hand side: L⁻ᵀ (last column − the others times the step).
void SolveBack(const float* unknowns, BoardSystem& system) {
  const DPhases d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kColumns = BoardSystem::kColumns;
  for (int part = 0; part < 4; part += lanes)
    for (int j = system.cells - 1; j >= 0; --j) {
      float* right = system.right + j * BoardSystem::kRightRow + part;
      auto sum = hn::LoadU(d, right + 4 * (kColumns - 1));
      for (int c = 0; c < kColumns - 1; ++c)
        sum = hn::NegMulAdd(hn::LoadU(d, right + 4 * c), hn::Set(d, unknowns[c]), sum);
      const float* column = system.matrix + j * system.matrix_row + part;
      for (int e = 1; e <= system.band && j + e < system.cells; ++e)
        sum = hn::NegMulAdd(hn::LoadU(d, column + 4 * e), hn::LoadU(d, right + e * BoardSystem::kRightRow), sum);
      hn::StoreU(hn::Mul(sum, hn::LoadU(d, column)), d, right);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <memory>

#include "detect/board_equations.h"

namespace chequer {
namespace {

static_assert(BoardSystem::kColumns == BoardEquations::kUnknowns + 1);

HWY_EXPORT(AddCorner);
HWY_EXPORT(Solve);
HWY_EXPORT(SolveBack);

/// Added to the diagonal of the levels, whose entries count pixels over their variance: cells that nothing has seen
/// stay where they are.
constexpr float kLeastInformation = 1e-3f;

/// Each phase's own channel of a mosaic, or one for all.
PhaseShares SharesOf(int red_phase, float* phase_weight) {
  PhaseShares shares{{1, 1, 1, 1}, 1};
  std::fill_n(phase_weight, 4, 0.0f);
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

void BoardEquations::Prepare(MarkerSize size) {
  cells_ = size.rows * size.cols;
  band_ = size.cols + 1;
  // A vector's floats at most run over the entries of the band, from any of them on.
  constexpr int kVector = 16;
  matrix_row_ = (8 * (band_ + 1) + kVector + kVector - 1) / kVector * kVector;
  const std::size_t matrix = static_cast<std::size_t>(cells_ * matrix_row_),
                    right = static_cast<std::size_t>(cells_ * BoardSystem::kRightRow);
  floats_.assign(matrix + right + kVector, 0.0f);
  void* start = floats_.data();
  std::size_t room = floats_.size() * sizeof(float);
  matrix_ = static_cast<float*>(std::align(kVector * sizeof(float), (matrix + right) * sizeof(float), start, room));
  right_ = matrix_ + matrix;
}

BoardSystem BoardEquations::System() const {
  BoardSystem system;
  system.cells = cells_;
  system.band = band_;
  system.matrix_row = matrix_row_;
  system.matrix = matrix_;
  system.right = right_;
  return system;
}

void BoardEquations::Assemble(const Input& input) {
  const BoardPixels& pixels = *input.pixels;
  const MarkerSize size = pixels.size();
  Prepare(size);
  BoardSystem system = System();
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
  BoardSystem system = System();
  std::array<float, kUnknowns> unknowns;
  for (int i = 0; i < kUnknowns; ++i) unknowns[static_cast<std::size_t>(i)] = static_cast<float>(step[i]);
  HWY_DYNAMIC_DISPATCH(SolveBack)(unknowns.data(), system);
  for (int cell = 0; cell < cells_; ++cell)
    for (std::size_t phase = 0; phase < 4; ++phase)
      levels[static_cast<std::size_t>(cell)][phase] += right_[cell * BoardSystem::kRightRow + static_cast<int>(phase)];
}

}  // namespace chequer
#endif  // HWY_ONCE
