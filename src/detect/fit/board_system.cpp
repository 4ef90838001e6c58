#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/board_system.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <cstddef>

#include "detect/common/reciprocal-inl.h"
#include "detect/fit/board_system.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DParameters = hn::CappedTag<double, BoardSystem::kColumns - 2>;
/// Of one phase each, and of as many groups of four phases as vectors hold.
using DPhases = hn::CappedTag<float, 4>;
using DGroups = hn::CappedTag<float, 16>;
constexpr int kGroupLanes = static_cast<int>(hn::MaxLanes(DGroups()));

/// The values of the four phases for lanes at → … of an array of such groups.
HWY_INLINE hn::Vec<DGroups> Repeat(DGroups d, const float* phases, int at) {
  return kGroupLanes < 4 ? hn::LoadU(d, phases + at % 4) : hn::LoadDup128(d, phases);
}

/// `to` becomes the sums of the channels: each phase's sum becomes that of all phases that share its channel.
void MergeKind(const float* HWY_RESTRICT from, const PhaseShares& shares, std::ptrdiff_t lanes,
               float* HWY_RESTRICT to) {
#if HWY_TARGET == HWY_SCALAR
  for (std::ptrdiff_t lane = 0; lane < lanes; lane += 4) {
    const float* s = from + lane;
    float half[4];
    for (int k = 0; k < 4; ++k) half[k] = s[k] + shares.opposite[k] * s[3 - k];
    for (int k = 0; k < 4; ++k) to[lane + k] = half[k] + shares.beside * half[k ^ 1];
  }
#else
  const DGroups d;
  const auto opposite = hn::LoadDup128(d, shares.opposite), beside = hn::Set(d, shares.beside);
  const bool any_beside = shares.beside != 0;
  HWY_UNROLL(2)
  for (std::ptrdiff_t lane = 0; lane < lanes; lane += kGroupLanes) {
    const auto sums = hn::LoadU(d, from + lane);
    const auto half = hn::MulAdd(opposite, hn::Reverse4(d, sums), sums);
    hn::StoreU(any_beside ? hn::MulAdd(beside, hn::Shuffle2301(half), half) : half, d, to + lane);
  }
#endif
}

/// Of the products: those with a level by channel, the others over all phases.
/// @param lanes the first so many.
void MergePhases(const SumsOfLanes& sums, int lanes, const PhaseShares& shares, bool with_levels, float* merged) {
  constexpr PhaseShares kAll{{1, 1, 1, 1}, 1};
  const auto is_level = [](int column) { return column >= kLevel00 && column <= kLevel11; };
  for (int a = 0; a < kLaneColumns; ++a)
    for (int b = a; b < kLaneColumns; ++b) {
      const bool of_level = is_level(a) || is_level(b);
      if (of_level && !with_levels) continue;
      MergeKind(sums.Of(a, b, 0), of_level ? shares : kAll, lanes, merged + ProductSum(a, b) * sums.stride);
    }
}

/// Adds what the corners say of geometry and blur alone.
void AddShapes(const CornerTerms* corners, int count, const SumsOfLanes& merged, BoardSystem& system) {
  constexpr int kParameters = BoardSystem::kColumns - 2, kBlurColumn = kParameters, kResidualColumn = kParameters + 1;
  const DParameters d;
  constexpr int kLanes = static_cast<int>(hn::MaxLanes(DParameters())), kVectors = kParameters / kLanes;
  // The vectors of a row's upper triangle.
  hn::Vec<DParameters> rows[static_cast<std::size_t>(kParameters * kVectors)];
  hn::Vec<DParameters> by_blur[static_cast<std::size_t>(kVectors)], by_residual[static_cast<std::size_t>(kVectors)];
  for (auto& row : rows) row = hn::Zero(d);
  for (int k = 0; k < kVectors; ++k) by_blur[k] = by_residual[k] = hn::Zero(d);
  double blur = 0, blur_residual = 0, residual = 0;
  double along[2][kParameters];  // information on x and on y by each parameter's move
  for (const CornerTerms* corner = corners; corner < corners + count; ++corner) {
    const auto sum = [&](int a, int b) { return static_cast<double>(*merged.Of(a, b, corner->lane)); };
    const double xx = sum(kShiftX, kShiftX), xy = sum(kShiftX, kShiftY), yy = sum(kShiftY, kShiftY);
    hn::Vec<DParameters> x[static_cast<std::size_t>(kVectors)], y[static_cast<std::size_t>(kVectors)];
    for (int k = 0; k < kVectors; ++k) {
      x[k] = hn::LoadU(d, corner->by_x + k * kLanes);
      y[k] = hn::LoadU(d, corner->by_y + k * kLanes);
      const auto mixed = hn::Set(d, xy);
      hn::StoreU(hn::MulAdd(hn::Set(d, xx), x[k], hn::Mul(mixed, y[k])), d, along[0] + k * kLanes);
      hn::StoreU(hn::MulAdd(hn::Set(d, yy), y[k], hn::Mul(mixed, x[k])), d, along[1] + k * kLanes);
      by_blur[k] = hn::MulAdd(hn::Set(d, sum(kShiftX, kBlur)), x[k],
                              hn::MulAdd(hn::Set(d, sum(kShiftY, kBlur)), y[k], by_blur[k]));
      by_residual[k] = hn::MulAdd(hn::Set(d, sum(kShiftX, kResidual)), x[k],
                                  hn::MulAdd(hn::Set(d, sum(kShiftY, kResidual)), y[k], by_residual[k]));
    }
    for (int a = 0; a < kParameters; ++a) {
      const auto along_x = hn::Set(d, along[0][a]), along_y = hn::Set(d, along[1][a]);
      for (int k = a / kLanes; k < kVectors; ++k) {
        auto& row = rows[a * kVectors + k];
        row = hn::MulAdd(along_x, x[k], hn::MulAdd(along_y, y[k], row));
      }
    }
    blur += sum(kBlur, kBlur);
    blur_residual += sum(kBlur, kResidual);
    residual += sum(kResidual, kResidual);
  }
  double by[2][kParameters];
  for (int k = 0; k < kVectors; ++k) {
    for (int a = 0; a < kParameters; ++a) hn::StoreU(rows[a * kVectors + k], d, system.normal[a] + k * kLanes);
    hn::StoreU(by_blur[k], d, by[0] + k * kLanes);
    hn::StoreU(by_residual[k], d, by[1] + k * kLanes);
  }
  for (int a = 0; a < kParameters; ++a)
    system.normal[a][kBlurColumn] = by[0][a], system.normal[a][kResidualColumn] = by[1][a];
  system.normal[kBlurColumn][kBlurColumn] = blur;
  system.normal[kBlurColumn][kResidualColumn] = blur_residual;
  system.normal[kResidualColumn][kResidualColumn] = residual;
}

/// Vectors that hold a cell's right-hand sides.
constexpr int kRightVectors = (4 * BoardSystem::kColumns + kGroupLanes - 1) / kGroupLanes;

/// The levels' matrix and right-hand sides, as far as they are read.
void Clear(BoardSystem& system) {
  const DGroups d;
  const auto zero = hn::Zero(d);
  for (int cell = 0; cell < system.cells; ++cell) {
    float* const column = system.matrix + cell * system.matrix_row;
    float* const right = system.right + cell * BoardSystem::kRightRow;
    for (int at = 0; at < system.matrix_row; at += kGroupLanes) hn::StoreU(zero, d, column + at);
    for (int k = 0; k < kRightVectors; ++k) hn::StoreU(zero, d, right + k * kGroupLanes);
  }
}

/// Adds a corner's levels.
void AddLevels(const CornerTerms& corner, const SumsOfLanes& merged, BoardSystem& system) {
  constexpr int kParameters = BoardSystem::kColumns - 2, kBlurAt = 4 * kParameters, kResidualAt = kBlurAt + 4;
  const DPhases d;
  const DGroups groups;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(DPhases()));
  // Copies, which no store can change.
  const SumsOfLanes sums{merged.data + corner.lane, merged.stride};
  const float *by_x = corner.repeated_x, *by_y = corner.repeated_y;
  float *const matrix = system.matrix, *const right = system.right;
  const int matrix_row = system.matrix_row;
  const int cell_of[4] = {corner.cell_of[0], corner.cell_of[1], corner.cell_of[2], corner.cell_of[3]};
  const auto add = [&](const float* HWY_RESTRICT values, float* HWY_RESTRICT to) HWY_ATTR {
    for (int part = 0; part < 4; part += kStep)
      hn::StoreU(hn::Add(hn::LoadU(d, to + part), hn::LoadU(d, values + part)), d, to + part);
  };
  HWY_UNROLL(4)
  for (int a = 0; a < 4; ++a) {
    const int cell = cell_of[a], level = kLevel00 + a;
    HWY_UNROLL(4)
    for (int b = a; b < 4; ++b)
      add(sums.Of(level, kLevel00 + b, 0), matrix + cell * matrix_row + 4 * (cell_of[b] - cell));
    float* HWY_RESTRICT to = right + cell * BoardSystem::kRightRow;
    const float *x = sums.Of(level, kShiftX, 0), *y = sums.Of(level, kShiftY, 0);
    for (int at = 0; at < 4 * kParameters; at += kGroupLanes) {
      const auto along_x = hn::MulAdd(Repeat(groups, x, at), hn::LoadU(groups, by_x + at), hn::LoadU(groups, to + at));
      hn::StoreU(hn::MulAdd(Repeat(groups, y, at), hn::LoadU(groups, by_y + at), along_x), groups, to + at);
    }
    add(sums.Of(level, kBlur, 0), to + kBlurAt);
    add(sums.Of(level, kResidual, 0), to + kResidualAt);
  }
}

/// Of a level's own information, what its neighbours leave of it at least: single precision tells no less.
constexpr float kLeastShareLeft = 1e-5f;

/// Vectors of a column of the matrix that are solved together: with the right-hand sides they fill most of the
/// registers of AVX2.
constexpr int kColumnVectors = kGroupLanes < 16 ? 4 : 2, kColumnFloats = kColumnVectors * kGroupLanes;
static_assert(kColumnFloats <= BoardSystem::kColumnTail);

/// Takes off a column of the matrix, from `at` on, what the columns before leave of it: each reaches as many entries
/// less far as it stands before it. Beyond the band stand zeros. @param factors of the first of these columns, that at
/// this column's row; the next one's is `to_next` on. @tparam kRight the vectors of right-hand sides, which lose as
/// much.
template <int kRight>
HWY_INLINE void TakeOffColumns(const float* HWY_RESTRICT factors, std::ptrdiff_t to_next, int count, int at,
                               float* HWY_RESTRICT column, float* HWY_RESTRICT right) {
  const DGroups d;
  hn::Vec<DGroups> sums[static_cast<std::size_t>(kColumnVectors + kRight)];
  for (int k = 0; k < kColumnVectors; ++k) sums[k] = hn::LoadU(d, column + at + k * kGroupLanes);
  for (int k = 0; k < kRight; ++k) sums[kColumnVectors + k] = hn::LoadU(d, right + k * kGroupLanes);
  const float* before = right - count * BoardSystem::kRightRow;
  for (int i = 0; i < count; ++i, factors += to_next, before += BoardSystem::kRightRow) {
    const auto take_off = [&](int k, const float* from, int of_group) HWY_ATTR {
      sums[k] = hn::NegMulAdd(Repeat(d, factors, of_group), hn::LoadU(d, from + of_group), sums[k]);
    };
    for (int k = 0; k < kColumnVectors; ++k) take_off(k, factors + at, k * kGroupLanes);
    for (int k = 0; k < kRight; ++k) take_off(kColumnVectors + k, before, k * kGroupLanes);
  }
  for (int k = 0; k < kColumnVectors; ++k) hn::StoreU(sums[k], d, column + at + k * kGroupLanes);
  for (int k = 0; k < kRight; ++k) hn::StoreU(sums[kColumnVectors + k], d, right + k * kGroupLanes);
}

/// matrix becomes its Cholesky factor L with the inverses of the diagonal in the diagonal's place, right becomes
/// L⁻¹ right.
void Factor(float least, BoardSystem& system) {
  const DPhases d;
  const DGroups groups;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(DPhases()));
  const int band = system.band, cells = system.cells, matrix_row = system.matrix_row;
  const int column_floats = (4 * (band + 1) + kGroupLanes - 1) / kGroupLanes * kGroupLanes;
  float* HWY_RESTRICT column = system.matrix;
  float* HWY_RESTRICT right = system.right;
  for (int j = 0; j < cells; ++j, column += matrix_row, right += BoardSystem::kRightRow) {
    const int above = j < band ? j : band;
    const std::ptrdiff_t to_next = matrix_row - 4;
    const float* factors = column - above * to_next;
    // A level that few pixels tell apart from its neighbours' leaves next to nothing, or less by rounding.
    HWY_ALIGN float least_pivot[4];
    for (int part = 0; part < 4; part += kStep)
      hn::StoreU(hn::MulAdd(hn::LoadU(d, column + part), hn::Set(d, kLeastShareLeft), hn::Set(d, least)), d,
                 least_pivot + part);
    TakeOffColumns<kRightVectors>(factors, to_next, above, 0, column, right);
    for (int at = kColumnFloats; at < column_floats; at += kColumnFloats) {
      const int reach = band - at / 4, skipped = above > reach ? above - reach : 0;
      TakeOffColumns<0>(factors + skipped * to_next, to_next, above - skipped, at, column, right);
    }
    HWY_ALIGN float inverse[4];
    for (int part = 0; part < 4; part += kStep) {
      const auto pivot =
          hn::Max(hn::Add(hn::LoadU(d, column + part), hn::Set(d, least)), hn::LoadU(d, least_pivot + part));
      hn::StoreU(ReciprocalSqrt(d, pivot), d, inverse + part);
    }
    for (int at = 0; at < column_floats; at += kGroupLanes)
      hn::StoreU(hn::Mul(hn::LoadU(groups, column + at), Repeat(groups, inverse, at)), groups, column + at);
    for (int part = 0; part < 4; ++part) column[part] = inverse[part];
    for (int at = 0; at < kRightVectors * kGroupLanes; at += kGroupLanes)
      hn::StoreU(hn::Mul(hn::LoadU(groups, right + at), Repeat(groups, inverse, at)), groups, right + at);
  }
}

/// Takes the products of the half-solved right-hand sides' columns kColumn and kColumn + 1 with those that follow off
/// normal: two at a time, as the sums of one wait for each other.
template <int kColumn>
void EliminateColumns(BoardSystem& system) {
  const DGroups d;
  using V = hn::Vec<DGroups>;
  // Of vectors that hold these columns and what follows.
  constexpr int kFirst = 4 * kColumn / kGroupLanes, kVectors = kRightVectors - kFirst;
  V sums[2 * static_cast<std::size_t>(kVectors)];
  for (V& sum : sums) sum = hn::Zero(d);
  const float* right = system.right;
  for (int left = system.cells; left > 0; --left, right += BoardSystem::kRightRow)
    for (int k = 0; k < kVectors; ++k) {
      const int at = (kFirst + k) * kGroupLanes;
      const V values = hn::LoadU(d, right + at);
      for (int i = 0; i < 2; ++i)
        sums[2 * k + i] = hn::MulAdd(Repeat(d, right + 4 * (kColumn + i), at), values, sums[2 * k + i]);
    }
  HWY_ALIGN float products[BoardSystem::kRightRow];
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < kVectors; ++k) {
      const int at = (kFirst + k) * kGroupLanes;
      hn::StoreU(hn::Mul(sums[2 * k + i], Repeat(d, system.phase_weight, at)), d, products + at);
    }
    for (int b = kColumn + i; b < BoardSystem::kColumns; ++b) {
      const float* p = products + 4 * b;
      system.normal[kColumn + i][b] -= static_cast<double>((p[0] + p[1]) + (p[2] + p[3]));
    }
  }
}

void Eliminate(BoardSystem& system) {
  static_assert(BoardSystem::kColumns == 10);
  EliminateColumns<0>(system);
  EliminateColumns<2>(system);
  EliminateColumns<4>(system);
  EliminateColumns<6>(system);
  EliminateColumns<8>(system);
}

void Solve(const CornerTerms* corners, int count, const SumsOfLanes& sums, int lanes, const PhaseShares& shares,
           float least, float* merged, BoardSystem& system) {
  const bool with_levels = !system.fixed_levels;
  MergePhases(sums, lanes, shares, with_levels, merged);
  const SumsOfLanes of_channels{merged, sums.stride};
  AddShapes(corners, count, of_channels, system);
  if (!with_levels) return;
  Clear(system);
  for (int i = 0; i < count; ++i) AddLevels(corners[i], of_channels, system);
  Factor(least, system);
  Eliminate(system);
}

/// L⁻ᵀ (last column − the others times the step).
void SolveBack(const float* unknowns, BoardSystem& system) {
  const DPhases d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  constexpr int kColumns = BoardSystem::kColumns;
  // Copies, which no store can change.
  const int band = system.band, cells = system.cells, matrix_row = system.matrix_row;
  hn::Vec<DPhases> unknown[static_cast<std::size_t>(kColumns - 1)];
  for (int c = 0; c < kColumns - 1; ++c) unknown[c] = hn::Set(d, unknowns[c]);
  for (int part = 0; part < 4; part += lanes) {
    float* right = system.right + cells * BoardSystem::kRightRow + part;
    const float* column = system.matrix + cells * matrix_row + part;
    for (int below = 0; below < cells; ++below) {
      right -= BoardSystem::kRightRow, column -= matrix_row;
      auto sum = hn::LoadU(d, right + 4 * (kColumns - 1));
      HWY_UNROLL(9)
      for (int c = 0; c < kColumns - 1; ++c) sum = hn::NegMulAdd(hn::LoadU(d, right + 4 * c), unknown[c], sum);
      // The cell just below last, as it has only just been found.
      const int entries = below < band ? below : band;
      const float *entry = column + 4 * entries, *solved = right + entries * BoardSystem::kRightRow;
      for (; entry > column; entry -= 4, solved -= BoardSystem::kRightRow)
        sum = hn::NegMulAdd(hn::LoadU(d, entry), hn::LoadU(d, solved), sum);
      hn::StoreU(hn::Mul(sum, hn::LoadU(d, column)), d, right);
    }
  }
}

void FindShifts(const CornerTerms* corners, int count, const SumsOfLanes& merged, const float* right,
                const float* weight, const double* step, double* shifts) {
  const DPhases d;
  const DParameters of_moves;
  constexpr int kStep = static_cast<int>(hn::MaxLanes(DPhases())),
                kLanes = static_cast<int>(hn::MaxLanes(DParameters())), kParameters = BoardSystem::kColumns - 2;
  for (const CornerTerms* corner = corners; corner < corners + count; ++corner) {
    const float* const sums = merged.data + corner->lane;
    const auto sum = [&](int a, int b) { return static_cast<double>(sums[ProductSum(a, b) * merged.stride]); };
    float by_levels[2] = {0, 0};
    HWY_UNROLL(2)
    for (int axis = kShiftX; axis <= kShiftY; ++axis)
      for (int part = 0; part < 4; part += kStep) {
        auto taken = hn::Zero(d);
        HWY_UNROLL(4)
        for (int i = 0; i < 4; ++i)
          taken = hn::MulAdd(hn::LoadU(d, sums + ProductSum(axis, kLevel00 + i) * merged.stride + part),
                             hn::LoadU(d, right + corner->cell_of[i] * BoardSystem::kRightRow + part), taken);
        by_levels[axis] += hn::GetLane(hn::SumOfLanes(d, hn::Mul(taken, hn::LoadU(d, weight + part))));
      }
    auto x = hn::Zero(of_moves), y = hn::Zero(of_moves);
    for (int k = 0; k < kParameters; k += kLanes) {
      const auto moves = hn::LoadU(of_moves, step + k);
      x = hn::MulAdd(hn::LoadU(of_moves, corner->by_x + k), moves, x);
      y = hn::MulAdd(hn::LoadU(of_moves, corner->by_y + k), moves, y);
    }
    const double move_x = hn::GetLane(hn::SumOfLanes(of_moves, x)), move_y = hn::GetLane(hn::SumOfLanes(of_moves, y));
    const double xx = sum(kShiftX, kShiftX), xy = sum(kShiftX, kShiftY), yy = sum(kShiftY, kShiftY);
    double* const shift = shifts + 5 * corner->corner;
    shift[0] = xx, shift[1] = xy, shift[2] = yy;
    shift[3] = sum(kShiftX, kResidual) - static_cast<double>(by_levels[0]) - (xx * move_x + xy * move_y);
    shift[4] = sum(kShiftY, kResidual) - static_cast<double>(by_levels[1]) - (xy * move_x + yy * move_y);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Solve);
HWY_EXPORT(SolveBack);
HWY_EXPORT(FindShifts);

}  // namespace

void SolveBoard(const CornerTerms* corners, int count, const SumsOfLanes& sums, int lanes, const PhaseShares& shares,
                float least, float* merged, BoardSystem& system) {
  HWY_DYNAMIC_DISPATCH(Solve)(corners, count, sums, lanes, shares, least, merged, system);
}

void SolveLevels(const float* unknowns, BoardSystem& system) { HWY_DYNAMIC_DISPATCH(SolveBack)(unknowns, system); }

void FindCornerShifts(const CornerTerms* corners, int count, const SumsOfLanes& merged, const float* right,
                      const float* weight, const double* step, double* shifts) {
  HWY_DYNAMIC_DISPATCH(FindShifts)(corners, count, merged, right, weight, step, shifts);
}

}  // namespace chequer
#endif  // HWY_ONCE
