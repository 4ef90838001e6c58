#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/level_elimination.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <algorithm>

#include "detect/fit/level_elimination.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// One entry of all channels, in as many vectors as the target needs.
constexpr int kEntry = LevelElimination::kSide;
using EntryTag = hn::CappedTag<double, kEntry>;
using Entries = hn::Vec<EntryTag>;

HWY_INLINE int EntryLanes() { return static_cast<int>(hn::Lanes(EntryTag())); }

/// to += times · from.
HWY_INLINE void AddSums(const float* HWY_RESTRICT from, double times, double* HWY_RESTRICT to) {
  const EntryTag d;
  const hn::Rebind<float, EntryTag> single;
  for (int at = 0; at < kEntry; at += EntryLanes()) {
    const Entries sums = hn::PromoteTo(d, hn::LoadU(single, from + at));
    hn::StoreU(hn::MulAdd(hn::Set(d, times), sums, hn::LoadU(d, to + at)), d, to + at);
  }
}

/// to −= factor · from, so many entries.
HWY_INLINE void Subtract(const double* HWY_RESTRICT factor, const double* HWY_RESTRICT from, int entries,
                         double* HWY_RESTRICT to) {
  const EntryTag d;
  for (int at = 0; at < kEntry; at += EntryLanes()) {
    const Entries by = hn::LoadU(d, factor + at);
    for (int i = at; i < entries * kEntry; i += kEntry)
      hn::StoreU(hn::NegMulAdd(by, hn::LoadU(d, from + i), hn::LoadU(d, to + i)), d, to + i);
  }
}

void AddCornerSums(const LevelElimination::Matrices& m, const ModelLanes& lanes, const ModelColumns& columns, int lane,
                   const int* levels) {
  // Of the levels' columns and, last, of the residual's: where their products with a column lie after those in its row.
  constexpr int kResidual = ModelColumns::kLevels;
  std::ptrdiff_t along[kResidual + 1];
  for (int i = 0; i <= kResidual; ++i)
    along[i] = ModelLanes::kNextProduct * ModelColumns::Along(i < kResidual ? columns.levels + i : columns.residual());
  const float* const sums = lanes.sum_data(0, lane);
  const auto row_of = [&](int column) { return sums + ModelLanes::kNextProduct * columns.Row(column); };
  for (int a = 0; a < columns.shared; ++a) {
    const float* const row = row_of(a);
    for (int i = 0; i < ModelColumns::kLevels; ++i)
      if (levels[i] != LevelElimination::kNoLevel) AddSums(row + along[i], 1, m.Common(levels[i], a));
  }
  for (int i = 0; i < ModelColumns::kLevels; ++i) {
    const int level = levels[i];
    if (level == LevelElimination::kNoLevel) continue;
    const float* const row = row_of(columns.levels + i);
    for (int j = i; j < ModelColumns::kLevels; ++j) {
      const int other = levels[j];
      if (other == LevelElimination::kNoLevel) continue;
      // Places that share a level count with each other, both ways.
      const double times = level == other && i != j ? 2 : 1;
      AddSums(row + along[j], times, level < other ? m.Band(level, other - level) : m.Band(other, level - other));
    }
    AddSums(row + along[kResidual], 1, m.Common(level, columns.shared));
  }
}

bool Factorise(const LevelElimination::Matrices& m) {
  for (int level = 0; level < m.levels; ++level) {
    double* const diagonal = m.Band(level, 0);
    double inverse[kEntry];
    for (int i = 0; i < kEntry; ++i) {
      if (!(diagonal[i] > 0)) return false;
      inverse[i] = 1 / diagonal[i];
    }
    const int last = std::min(m.width, m.levels - 1 - level);
    for (int below = 1; below <= last; ++below) {
      const double* const entry = m.Band(level, below);
      double factor[kEntry];
      bool nothing = true;
      for (int i = 0; i < kEntry; ++i) {
        factor[i] = entry[i] * inverse[i];
        nothing = nothing && factor[i] == 0;
      }
      if (nothing) continue;
      Subtract(factor, entry, m.width + 1 - below, m.Band(level + below, 0));
      Subtract(factor, m.Common(level, 0), m.shared + 1, m.Common(level + below, 0));
    }
    for (int below = 1; below <= m.width; ++below)
      for (int i = 0; i < kEntry; ++i) m.Band(level, below)[i] *= inverse[i];
  }
  return true;
}

/// taken += common_a common_b / D, a ≤ b, over all levels: the channels' own at entry a (shared + 1) + b.
void Take(const LevelElimination::Matrices& m, double* HWY_RESTRICT taken) {
  const EntryTag d;
  for (int level = 0; level < m.levels; ++level)
    for (int at = 0; at < kEntry; at += EntryLanes()) {
      const Entries inverse = hn::Div(hn::Set(d, 1.0), hn::LoadU(d, m.Band(level, 0) + at));
      for (int a = 0; a <= m.shared; ++a) {
        const Entries scaled = hn::Mul(hn::LoadU(d, m.Common(level, a) + at), inverse);
        for (int b = a; b <= m.shared; ++b) {
          double* const to = taken + (a * (m.shared + 1) + b) * kEntry + at;
          hn::StoreU(hn::MulAdd(scaled, hn::LoadU(d, m.Common(level, b) + at), hn::LoadU(d, to)), d, to);
        }
      }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(AddCornerSums);
HWY_EXPORT(Factorise);
HWY_EXPORT(Take);

}  // namespace

void LevelElimination::Begin(int levels, int width, int shared) {
  at_.levels = levels;
  at_.width = width;
  at_.shared = shared;
  const auto begin = [](std::vector<double>& values, int rows, int columns) {
    values.assign(static_cast<std::size_t>(rows * columns * kSide), 0);
    return values.data();
  };
  at_.band = begin(band_, levels, width + 1);
  at_.common = begin(common_, levels, shared + 1);
  begin(taken_, shared + 1, shared + 1);
  begin(step_, levels, 1);
}

void LevelElimination::AddCorner(const ModelLanes& lanes, const ModelColumns& columns, int lane,
                                 const LevelsAround& levels) {
  HWY_DYNAMIC_DISPATCH(AddCornerSums)(at_, lanes, columns, lane, levels.data());
}

void LevelElimination::MergePhases(const std::array<int, kSide>& channel_of_phase) {
  for (std::vector<double>* values : {&band_, &common_})
    for (std::size_t entry = 0; entry < values->size(); entry += kSide) {
      std::array<double, kSide> merged{};
      for (std::size_t phase = 0; phase < kSide; ++phase)
        merged[static_cast<std::size_t>(channel_of_phase[phase])] += (*values)[entry + phase];
      std::copy(merged.begin(), merged.end(), values->begin() + static_cast<std::ptrdiff_t>(entry));
    }
}

bool LevelElimination::Eliminate(const std::array<int, kSide>& channel_of_phase, double ridge) {
  MergePhases(channel_of_phase);
  for (int channel = 0; channel < kSide; ++channel) {
    double mean = 0;
    for (int level = 0; level < at_.levels; ++level) mean += at_.Band(level, 0)[channel] / at_.levels;
    const bool used = std::find(channel_of_phase.begin(), channel_of_phase.end(), channel) != channel_of_phase.end();
    if (used && !(mean > 0)) return false;
    // Channels that the image has not got stand for themselves.
    for (int level = 0; level < at_.levels; ++level) at_.Band(level, 0)[channel] += used ? ridge * mean : 1;
  }
  if (!HWY_DYNAMIC_DISPATCH(Factorise)(at_)) return false;
  HWY_DYNAMIC_DISPATCH(Take)(at_, taken_.data());
  return true;
}

double LevelElimination::Taken(int a, int b) const {
  const double* const of = taken_.data() + (a * (at_.shared + 1) + b) * kSide;
  return of[0] + of[1] + of[2] + of[3];
}

void LevelElimination::Solve(const double* shared_step) {
  for (int level = at_.levels - 1; level >= 0; --level) {
    std::array<double, kSide> value{};
    for (std::size_t i = 0; i < kSide; ++i) value[i] = at_.Common(level, at_.shared)[i];
    for (int a = 0; a < at_.shared; ++a)
      for (std::size_t i = 0; i < kSide; ++i) value[i] -= at_.Common(level, a)[i] * shared_step[a];
    for (std::size_t i = 0; i < kSide; ++i) value[i] /= at_.Band(level, 0)[i];
    for (int below = 1; below <= at_.width && level + below < at_.levels; ++below)
      for (std::size_t i = 0; i < kSide; ++i)
        value[i] -= at_.Band(level, below)[i] * step_[static_cast<std::size_t>((level + below) * kSide) + i];
    std::copy(value.begin(), value.end(), step_.begin() + static_cast<std::ptrdiff_t>(level * kSide));
  }
}

}  // namespace chequer
#endif  // HWY_ONCE
