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

/// @param count a multiple of the entries' size.
void Fill(double value, std::size_t count, double* HWY_RESTRICT values) {
  const EntryTag d;
  const Entries all = hn::Set(d, value);
  for (std::size_t i = 0; i < count; i += static_cast<std::size_t>(EntryLanes())) hn::StoreU(all, d, values + i);
}

/// to += times · from.
HWY_INLINE void AddSums(const float* HWY_RESTRICT from, double times, double* HWY_RESTRICT to) {
  const EntryTag d;
  const hn::Rebind<float, EntryTag> single;
  for (int at = 0; at < kEntry; at += EntryLanes()) {
    const Entries sums = hn::PromoteTo(d, hn::LoadU(single, from + at));
    hn::StoreU(hn::MulAdd(hn::Set(d, times), sums, hn::LoadU(d, to + at)), d, to + at);
  }
}

/// to += from.
HWY_INLINE void AddSums(const float* HWY_RESTRICT from, double* HWY_RESTRICT to) {
  const EntryTag d;
  const hn::Rebind<float, EntryTag> single;
  for (int at = 0; at < kEntry; at += EntryLanes())
    hn::StoreU(hn::Add(hn::PromoteTo(d, hn::LoadU(single, from + at)), hn::LoadU(d, to + at)), d, to + at);
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
  // Where the products of two columns stand: those of the first, and by the second along them.
  std::ptrdiff_t row[ModelColumns::kMost], along[ModelColumns::kMost];
  for (int column = 0; column < columns.count; ++column) {
    row[column] = ModelLanes::kNextProduct * columns.Row(column);
    along[column] = ModelLanes::kNextProduct * ModelColumns::Along(column);
  }
  struct Place {
    std::ptrdiff_t along;
    int level;
  } places[ModelColumns::kLevels];
  const float* const sums = lanes.sum_data(0, lane);
  // From the last place on: those after it are known then.
  Place* const past = places + ModelColumns::kLevels;
  Place* later = past;
  for (int i = ModelColumns::kLevels - 1; i >= 0; --i) {
    const int level = levels[i], column = columns.levels + i;
    if (level == LevelElimination::kNoLevel) continue;
    double* common = m.Common(level, 0);
    for (int a = 0; a < columns.shared; ++a, common += kEntry) AddSums(sums + row[a] + along[column], common);
    const float* const of_level = sums + row[column];
    AddSums(of_level + along[columns.residual()], common);
    double* const diagonal = m.Band(level, 0);
    AddSums(of_level + along[column], diagonal);
    for (const Place* other = later; other != past; ++other) {
      const float* const from = of_level + other->along;
      const int below = other->level - level;
      // Places that share a level count with each other, both ways.
      if (below > 0) AddSums(from, diagonal + below * kEntry);
      else if (below < 0) AddSums(from, m.Band(other->level, -below));
      else AddSums(from, 2, diagonal);
    }
    *--later = {along[column], level};
  }
}

/// Entries of the phases become those of their channels. @param channel_of_phase one for each phase.
void Merge(double* entries, std::size_t count, const int* channel_of_phase) {
  const EntryTag d;
  double into[kEntry][kEntry] = {};  // by phase and channel
  for (int phase = 0; phase < kEntry; ++phase) into[phase][channel_of_phase[phase]] = 1;
  for (double* const end = entries + count; entries != end; entries += kEntry) {
    double merged[kEntry];
    for (int at = 0; at < kEntry; at += EntryLanes()) {
      Entries sum = hn::Zero(d);
      for (int phase = 0; phase < kEntry; ++phase)
        sum = hn::MulAdd(hn::Set(d, entries[phase]), hn::LoadU(d, into[phase] + at), sum);
      hn::StoreU(sum, d, merged + at);
    }
    for (int at = 0; at < kEntry; at += EntryLanes()) hn::StoreU(hn::LoadU(d, merged + at), d, entries + at);
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
      Subtract(factor, entry, last + 1 - below, m.Band(level + below, 0));
      Subtract(factor, m.Common(level, 0), m.shared + 1, m.Common(level + below, 0));
    }
    for (int below = 1; below <= last; ++below)
      for (int i = 0; i < kEntry; ++i) m.Band(level, below)[i] *= inverse[i];
  }
  return true;
}

/// The channels' common_a common_b / D, a ≤ b, summed over all levels, at entry a (shared + 1) + b.
/// @param by_diagonal workspace: an entry a level.
void Take(const LevelElimination::Matrices& m, double* HWY_RESTRICT by_diagonal, double* HWY_RESTRICT taken) {
  const EntryTag d;
  constexpr int kTogether = 4;
  const int columns = m.shared + 1, next_level = columns * kEntry;
  for (int at = 0; at < kEntry; at += EntryLanes())
    for (int a = 0; a < columns; ++a) {
      const double* HWY_RESTRICT common = m.common + a * kEntry + at;
      for (int level = 0; level < m.levels; ++level, common += next_level)
        hn::StoreU(hn::Div(hn::LoadU(d, common), hn::LoadU(d, m.Band(level, 0) + at)), d, by_diagonal + level * kEntry);
      for (int b = a; b < columns; b += kTogether) {
        // Past the last column lies the next level's first, or what the caller has added to the last level's.
        const double* HWY_RESTRICT other = m.common + b * kEntry + at;
        const double* HWY_RESTRICT scaled = by_diagonal;
        Entries sum0 = hn::Zero(d), sum1 = sum0, sum2 = sum0, sum3 = sum0;
        for (int level = 0; level < m.levels; ++level, other += next_level, scaled += kEntry) {
          const Entries of_a = hn::LoadU(d, scaled);
          sum0 = hn::MulAdd(of_a, hn::LoadU(d, other), sum0);
          sum1 = hn::MulAdd(of_a, hn::LoadU(d, other + kEntry), sum1);
          sum2 = hn::MulAdd(of_a, hn::LoadU(d, other + 2 * kEntry), sum2);
          sum3 = hn::MulAdd(of_a, hn::LoadU(d, other + 3 * kEntry), sum3);
        }
        const Entries sums[kTogether] = {sum0, sum1, sum2, sum3};
        for (int i = 0; i < kTogether && b + i < columns; ++i)
          hn::StoreU(sums[i], d, taken + (a * columns + b + i) * kEntry + at);
      }
    }
}

/// The levels' step by that of the shared unknowns.
void Substitute(const LevelElimination::Matrices& m, const double* HWY_RESTRICT shared_step, double* HWY_RESTRICT step) {
  const EntryTag d;
  for (int level = m.levels - 1; level >= 0; --level) {
    const int last = std::min(m.width, m.levels - 1 - level);
    for (int at = 0; at < kEntry; at += EntryLanes()) {
      const double *common = m.Common(level, 0) + at, *band = m.Band(level, 0) + at, *below = step + level * kEntry + at;
      Entries value = hn::LoadU(d, common + m.shared * kEntry);
      for (int a = 0; a < m.shared; ++a)
        value = hn::NegMulAdd(hn::LoadU(d, common + a * kEntry), hn::Set(d, shared_step[a]), value);
      value = hn::Div(value, hn::LoadU(d, band));
      for (int i = 1; i <= last; ++i)
        value = hn::NegMulAdd(hn::LoadU(d, band + i * kEntry), hn::LoadU(d, below + i * kEntry), value);
      hn::StoreU(value, d, step + level * kEntry + at);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Fill);
HWY_EXPORT(AddCornerSums);
HWY_EXPORT(Merge);
HWY_EXPORT(Factorise);
HWY_EXPORT(Take);
HWY_EXPORT(Substitute);

}  // namespace

void LevelElimination::Begin(int levels, int width, int shared) {
  at_.levels = levels;
  at_.width = width;
  at_.shared = shared;
  const auto begin = [](std::vector<double>& values, int entries) {
    const std::size_t count = static_cast<std::size_t>(entries * kSide);
    if (values.size() < count) values.resize(count);  // never shrinks: what is grown again would be filled twice
    HWY_DYNAMIC_DISPATCH(Fill)(0, count, values.data());
    return values.data();
  };
  at_.band = begin(band_, levels * (width + 1));
  at_.common = begin(common_, levels * (shared + 1) + kBeyond);
  taken_.resize(static_cast<std::size_t>((shared + 1) * (shared + 1) * kSide));
  by_diagonal_.resize(static_cast<std::size_t>(levels * kSide));
  step_.resize(static_cast<std::size_t>(levels * kSide));
}

void LevelElimination::AddCorner(const ModelLanes& lanes, const ModelColumns& columns, int lane,
                                 const LevelsAround& levels) {
  HWY_DYNAMIC_DISPATCH(AddCornerSums)(at_, lanes, columns, lane, levels.data());
}

bool LevelElimination::Eliminate(const std::array<int, kSide>& channel_of_phase, double ridge) {
  const auto merge = [&](double* entries, int count) {
    HWY_DYNAMIC_DISPATCH(Merge)(entries, static_cast<std::size_t>(count * kSide), channel_of_phase.data());
  };
  merge(at_.band, at_.levels * (at_.width + 1));
  merge(at_.common, at_.levels * (at_.shared + 1));
  for (int channel = 0; channel < kSide; ++channel) {
    double mean = 0;
    for (int level = 0; level < at_.levels; ++level) mean += at_.Band(level, 0)[channel] / at_.levels;
    const bool used = std::find(channel_of_phase.begin(), channel_of_phase.end(), channel) != channel_of_phase.end();
    if (used && !(mean > 0)) return false;
    // Channels that the image has not got stand for themselves.
    for (int level = 0; level < at_.levels; ++level) at_.Band(level, 0)[channel] += used ? ridge * mean : 1;
  }
  if (!HWY_DYNAMIC_DISPATCH(Factorise)(at_)) return false;
  HWY_DYNAMIC_DISPATCH(Take)(at_, by_diagonal_.data(), taken_.data());
  return true;
}

double LevelElimination::Taken(int a, int b) const {
  const double* const of = taken_.data() + (a * (at_.shared + 1) + b) * kSide;
  return of[0] + of[1] + of[2] + of[3];
}

void LevelElimination::Solve(const double* shared_step) {
  HWY_DYNAMIC_DISPATCH(Substitute)(at_, shared_step, step_.data());
}

}  // namespace chequer
#endif  // HWY_ONCE
