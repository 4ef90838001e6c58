#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/corner_pixels.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "detect/fit/corner_pixels.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Rows whose ends are found in one go: none waits for the pixels of another.
constexpr int kRowsTogether = 16;

/// The pixels of some rows.
struct Spans {
  HWY_ALIGN int first[kRowsTogether];   ///< from CornerPart::x
  HWY_ALIGN int pixels[kRowsTogether];  ///< none, if not positive
  /// How far the lanes of the first pixel and of the second one go on by the row, floats.
  HWY_ALIGN int to_first[kRowsTogether];
  HWY_ALIGN int to_second[kRowsTogether];
  /// Plane coordinates of the first, and how they change to the next.
  HWY_ALIGN float at[2][kRowsTogether];
  HWY_ALIGN float step[2][kRowsTogether];
  int widest, past;  ///< most pixels of a row, and the column beyond the last one, from CornerPart::x
};

/// @param left, right columns of the image's edges, from CornerPart::x.
void FindSpans(const CornerPart& part, int first_row, float left, float right, Spans& spans) {
  const hn::CappedTag<float, kRowsTogether> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
  const Band &a = part.bands[0], &b = part.bands[1];
  auto widest = hn::Zero(di), past = hn::Set(di, std::numeric_limits<int>::min());
  for (int row = 0; row < kRowsTogether; row += static_cast<int>(hn::Lanes(d))) {
    const auto dy = hn::Iota(d, static_cast<float>(first_row + row) - part.corner_y);
    const auto at_a = hn::MulAdd(dy, set(a.slope), set(part.corner_x));
    const auto at_b = hn::MulAdd(dy, set(b.slope), set(part.corner_x));
    const auto from = hn::Max(hn::Add(at_a, set(a.low)), hn::Add(at_b, set(b.low)));
    const auto to = hn::Min(hn::Add(at_a, set(a.high)), hn::Add(at_b, set(b.high)));
    const auto first = hn::Ceil(hn::Min(hn::Max(from, set(left)), set(right + 1)));
    const auto last = hn::Floor(hn::Max(hn::Min(to, set(right)), set(left - 1)));
    const auto from_x = hn::ConvertTo(di, first), to_x = hn::Add(hn::ConvertTo(di, last), hn::Set(di, 1));
    const auto pixels = hn::Sub(to_x, from_x);
    hn::Store(from_x, di, spans.first + row);
    hn::Store(pixels, di, spans.pixels + row);
    const auto put = hn::Max(pixels, hn::Zero(di)), second = hn::ShiftRight<1>(put);
    const auto next = hn::Set(di, static_cast<int>(LaneBlock::kNextPixel));
    hn::Store(hn::Mul(hn::Sub(put, second), next), di, spans.to_first + row);
    hn::Store(hn::Mul(second, next), di, spans.to_second + row);
    widest = hn::Max(widest, pixels);
    past = hn::Max(past, to_x);
    const auto dx = hn::Sub(first, set(part.corner_x));
    const LocalPlane& plane = part.plane;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto bend = set(plane.by_xx[i]);
      const auto slope = hn::MulAdd(dy, set(plane.by_xy[i]), set(plane.by_x[i]));
      const auto beside = hn::MulAdd(dy, hn::MulAdd(dy, set(plane.by_yy[i]), set(plane.by_y[i])), set(plane.at[i]));
      hn::Store(hn::MulAdd(dx, hn::MulAdd(dx, bend, slope), beside), d, spans.at[i] + row);
      hn::Store(hn::MulAdd(hn::Add(hn::Add(dx, dx), set(1)), bend, slope), d, spans.step[i] + row);
    }
  }
  spans.widest = hn::GetLane(hn::MaxOfLanes(di, widest));
  spans.past = hn::GetLane(hn::MaxOfLanes(di, past));
}

/// The plane coordinates of the pixels of a row: parabolas.
struct PlaneWalk {
  float u, v, step_u, step_v, change_u, change_v;

  /// So many pixels on from here.
  HWY_INLINE float UAfter(float n) const { return u + n * (step_u + (n - 1) / 2 * change_u); }
  HWY_INLINE float VAfter(float n) const { return v + n * (step_v + (n - 1) / 2 * change_v); }
};

/// The next places of the lanes of a row's first pixel and second pixel, in turn.
struct Lanes {
  float *first, *second;
};

/// Pixels of a row that are put in one go: as many as it takes for the processor to guess right how often to go round.
constexpr int kTogether = 4;

HWY_INLINE int WholeGoes(int count) { return (count + kTogether - 1) / kTogether * kTogether; }

using DGo = hn::CappedTag<float, kTogether>;
using VGo = hn::Vec<DGo>;
/// Vectors that hold a go.
constexpr int kGoLanes = static_cast<int>(hn::MaxLanes(DGo())), kGoVectors = kTogether / kGoLanes;

/// One coordinate of the pixels of a row, a go at a time, by differences.
class GoWalk {
 public:
  /// What all rows of a part share. @param change of the step from one pixel to the next.
  struct Changes {
    VGo of_first[static_cast<std::size_t>(kGoVectors)], of_step[static_cast<std::size_t>(kGoVectors)], of_go;

    explicit HWY_INLINE Changes(float change) {
      const DGo d;
      const VGo by = hn::Set(d, change), half = hn::Set(d, 0.5f * change);
      for (int i = 0; i < kGoVectors; ++i) {
        const VGo n = hn::Iota(d, static_cast<float>(i * kGoLanes));
        of_first[i] = hn::Mul(half, hn::Mul(n, hn::Sub(n, hn::Set(d, 1.0f))));
        of_step[i] =
            hn::Mul(by, hn::MulAdd(n, hn::Set(d, 1.0f * kTogether), hn::Set(d, kTogether * (kTogether - 1) / 2.0f)));
      }
      of_go = hn::Set(d, kTogether * kTogether * change);
    }
  };
  HWY_INLINE GoWalk(float at, float step, const Changes& changes) : change_(changes.of_go) {
    const DGo d;
    const VGo by = hn::Set(d, step);
    for (int i = 0; i < kGoVectors; ++i) {
      at_[i] =
          hn::MulAdd(by, hn::Iota(d, static_cast<float>(i * kGoLanes)), hn::Add(hn::Set(d, at), changes.of_first[i]));
      step_[i] = hn::MulAdd(by, hn::Set(d, 1.0f * kTogether), changes.of_step[i]);
    }
  }
  HWY_INLINE float operator[](std::size_t pixel) const {
    return hn::ExtractLane(at_[pixel / kGoLanes], pixel % kGoLanes);
  }
  HWY_INLINE void Next() {
    for (int i = 0; i < kGoVectors; ++i) {
      at_[i] = hn::Add(at_[i], step_[i]);
      step_[i] = hn::Add(step_[i], change_);
    }
  }

 private:
  VGo at_[static_cast<std::size_t>(kGoVectors)], step_[static_cast<std::size_t>(kGoVectors)], change_;
};

/// Puts the pixels of a row into their lanes, as whole goes, until the first pixel's lane reaches `end`. @tparam kMixed
/// is what run.is_mixed() says.
template <bool kMixed>
HWY_INLINE void PutGoes(const LightReader::Run& run, GoWalk u, GoWalk v, Lanes lanes, const float* end) {
  static_assert(kTogether == 4);
  const std::uint8_t* first = run.first;
  const std::ptrdiff_t to_second = run.second - run.first, step = run.step;
  const float* HWY_RESTRICT const table = run.table;
  const auto light = [&](const std::uint8_t* pixel) HWY_ATTR {
    return kMixed ? RedAndGreen::Of(table[pixel[run.red]], table[*pixel]) : table[*pixel];
  };
  const auto put = [&](float at_u, float at_v, float of_pixel, float* HWY_RESTRICT lane) HWY_ATTR {
    lane[0] = at_u;
    lane[LaneBlock::kGroup] = at_v;
    lane[2 * LaneBlock::kGroup] = of_pixel;
  };
  for (;;) {
    put(u[0], v[0], light(first), lanes.first);
    put(u[1], v[1], light(first + to_second), lanes.second);
    put(u[2], v[2], light(first + step), lanes.first + LaneBlock::kNextPixel);
    put(u[3], v[3], light(first + to_second + step), lanes.second + LaneBlock::kNextPixel);
    lanes.first += 2 * LaneBlock::kNextPixel, lanes.second += 2 * LaneBlock::kNextPixel;
    if (lanes.first >= end) return;
    first += 2 * step;
    u.Next(), v.Next();
  }
}

/// Beyond any row's end.
constexpr int kNever = 1 << 20;

/// Which pixels of a row are kept. @pre part.thinning leaves some out.
class Keeper {
 public:
  /// How far from an edge the pixels of a row lie, cells.
  struct Across {
    float first, by_pixel;
    HWY_INLINE float At(int i) const { return first + static_cast<float>(i) * by_pixel; }
  };
  /// @param x, y the row's first pixel.
  HWY_INLINE Keeper(const Thinning& thinning, int x, int y, Across across_x, Across across_y)
      : thinning_(thinning),
        x_(x),
        rank_of_row_(static_cast<std::uint32_t>(y / 2) * kByRow),
        across_x_(across_x),
        across_y_(across_y) {}

  /// The first that is kept from pixel i on, `count` if none is. To be asked for ever later ones.
  int Next(int i, int count) {
    while (i < count) {
      if (i >= alike_until_) LookAhead(i);
      if (IsKept(x_ + i)) return i;
      i = std::min(i + 2 - (x_ + i) % 2, alike_until_);
    }
    return count;
  }
  /// Along an edge.
  bool KeepsAll(int count) const {
    return thinning_.near_edges == Thinning::kAll && std::abs(across_y_.At(0)) <= thinning_.band_y &&
           std::abs(across_y_.At(count - 1)) <= thinning_.band_y;
  }

 private:
  /// Tiles in the order in which they are kept, as the share grows, over 2³²: points of an additive recurrence, which
  /// each prefix spreads evenly (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
  static constexpr std::uint32_t kByColumn = 0xC13FA9A9, kByRow = 0x91E10DA6;

  bool IsKept(int x) const { return static_cast<std::uint32_t>(x / 2) * kByColumn + rank_of_row_ <= share_; }
  /// Finds out how many tiles are kept around pixel i, and how far that holds at least.
  void LookAhead(int i) {
    const float x = across_x_.At(i), y = across_y_.At(i);
    const bool near_x = std::abs(x) <= thinning_.band_x, near_y = std::abs(y) <= thinning_.band_y;
    const int x_until = i + Until(x, across_x_.by_pixel, thinning_.band_x, near_x),
              y_until = i + Until(y, across_y_.by_pixel, thinning_.band_y, near_y);
    share_ = near_x || near_y ? thinning_.near_edges : thinning_.inside;
    // Near both, pixels stay near until they have left both; near none, until they reach one.
    if (near_x == near_y)
      alike_until_ = near_x ? std::max(x_until, y_until) : std::min(x_until, y_until);
    else
      alike_until_ = near_x ? x_until : y_until;
  }
  /// Pixels from one at that distance on, at least one, until the next edge of the band may have been crossed.
  static int Until(float at, float by_pixel, float band, bool is_near) {
    const float edge = is_near == (by_pixel > 0) ? band : -band;
    const float steps = (edge - at) / by_pixel;
    if (steps > 0) return std::max(static_cast<int>(std::min(steps, static_cast<float>(kNever))), 1);
    return is_near ? 1 : kNever;  // at the band's edge, or going away
  }

  const Thinning& thinning_;
  int x_;
  std::uint32_t rank_of_row_;
  Across across_x_, across_y_;
  int alike_until_ = 0;  ///< from the last pixel that was looked at on to this, as many tiles are kept
  Thinning::Share share_ = Thinning::kAll;
};

/// Puts those of the pixels of a row that next(index, count) leads to. Returns where the next ones go.
template <class Next>
Lanes PutSome(const LightReader::Run& run, int count, Next&& next, const PlaneWalk& walk, Lanes lanes) {
  for (int i = next(0, count); i < count; i = next(i + 1, count)) {
    const std::uint8_t* pixel = (i % 2 ? run.second : run.first) + i / 2 * run.step;
    float*& lane = i % 2 ? lanes.second : lanes.first;
    lane[0] = walk.UAfter(static_cast<float>(i));
    lane[LaneBlock::kGroup] = walk.VAfter(static_cast<float>(i));
    lane[2 * LaneBlock::kGroup] = run.is_mixed() ? run.Mixed(pixel) : run.table[*pixel];
    lane += LaneBlock::kNextPixel;
  }
  return lanes;
}

/// The rows of a part, as they are put.
struct PartRows {
  const CornerPart& part;
  const LightReader::Rows& rows;
  const Spans& spans;
  int from_y;     ///< of the spans' first row, from CornerPart::y
  int right_end;  ///< columns from CornerPart::x to the image's end
  GoWalk::Changes changes_u, changes_v;
};

/// Where the rows of even or of odd y go.
struct RowLanes {
  float *even, *odd;  ///< next places of the lanes of even x and of odd x
  const float* start;
  int capacity;

  int Count(const float* next) const {
    return static_cast<int>(static_cast<std::size_t>(next - start) / static_cast<std::size_t>(LaneBlock::kNextPixel));
  }
  /// Of the lane that has least.
  int Room() const { return capacity - Count(even > odd ? even : odd); }
  HWY_INLINE Lanes From(int x) const { return x & 1 ? Lanes{odd, even} : Lanes{even, odd}; }
  HWY_INLINE void Continue(int x, Lanes lanes) {
    even = x & 1 ? lanes.second : lanes.first;
    odd = x & 1 ? lanes.first : lanes.second;
  }
};

/// Puts a row with no more pixels than there is room for. The pixels after it, up to whole goes, are put too, as they
/// need: they are not counted, and the next row overwrites them.
template <bool kMixed>
HWY_INLINE void PutRow(const PartRows& of, int i, const LightReader::RunsOfRow& row, RowLanes& to) {
  const int x = of.part.x + of.spans.first[i];
  const auto put = [&](float*& first, float*& second) HWY_ATTR {
    const float* const end = first + of.spans.to_first[i];
    PutGoes<kMixed>(row.From(x), {of.spans.at[0][i], of.spans.step[0][i], of.changes_u},
                    {of.spans.at[1][i], of.spans.step[1][i], of.changes_v}, {first, second}, end);
    first += of.spans.to_first[i];
    second += of.spans.to_second[i];
  };
  if (x & 1)
    put(to.odd, to.even);
  else
    put(to.even, to.odd);
}

/// Puts as much of a row as there is room for.
void PutRowOfFew(const PartRows& of, int i, RowLanes& to) {
  const CornerPart& part = of.part;
  const int x = part.x + of.spans.first[i], y = part.y + of.from_y + i, all = of.spans.pixels[i];
  const PlaneWalk walk{of.spans.at[0][i],   of.spans.at[1][i],       of.spans.step[0][i],
                       of.spans.step[1][i], 2 * part.plane.by_xx[0], 2 * part.plane.by_xx[1]};
  // Of its first pixel from the corner.
  const float dx = static_cast<float>(of.spans.first[i]) - part.corner_x,
              dy = static_cast<float>(of.from_y + i) - part.corner_y;
  const int room = 2 * to.Room(), pixels = all < room ? all : room;
  Keeper keeper(part.thinning, x, y, {part.board_by_x[0] * dx + part.board_by_y[0] * dy, part.board_by_x[0]},
                {part.board_by_x[1] * dx + part.board_by_y[1] * dy, part.board_by_x[1]});
  const LightReader::Run run = of.rows.From(x, y);
  const Lanes lanes = to.From(x);
  if (part.thinning.all || keeper.KeepsAll(all))
    to.Continue(x, PutSome(
                       run, pixels, [](int at, int) { return at; }, walk, lanes));
  else
    to.Continue(x, PutSome(
                       run, pixels, [&](int at, int count) { return keeper.Next(at, count); }, walk, lanes));
}

/// Puts the spans' rows of even or of odd y. @param i the first of them. @param past of the spans' rows.
/// @param roomy whether all of them surely have room.
template <bool kMixed>
HWY_INLINE void PutRows(const PartRows& of, int i, int past, bool roomy, RowLanes& lanes) {
  RowLanes to = lanes;  // a copy, which no store can change
  const Spans& spans = of.spans;
  const bool all = of.part.thinning.all;
  const LightReader::Rows& rows = of.rows;
  LightReader::RunsOfRow row = rows.At(of.part.y + of.from_y + i);
  if (all && roomy) {
    for (; i < past; i += 2, rows.NextButOne(row))
      if (spans.pixels[i] > 0) PutRow<kMixed>(of, i, row, to);
    lanes = to;
    return;
  }
  for (; i < past; i += 2, rows.NextButOne(row)) {
    const int pixels = spans.pixels[i];
    if (pixels <= 0) continue;
    if (all && spans.first[i] + WholeGoes(pixels) <= of.right_end && WholeGoes(pixels) / 2 <= to.Room())
      PutRow<kMixed>(of, i, row, to);
    else
      PutRowOfFew(of, i, to);
  }
  lanes = to;
}

template <bool kMixed>
int PutPart(PartRows& of, Spans& spans, int width, LaneBlock& block, int lane) {
  const CornerPart& part = of.part;
  float* const start = block.u_data() + block.Place(lane, 0);
  const int capacity = block.capacity();
  RowLanes of_row[2] = {{start, start + 1, start, capacity}, {start + 2, start + 3, start, capacity}};
  int most = 0;  // in any lane so far
  for (int together = 0; together < part.rows; together += kRowsTogether) {
    const int past = part.rows - together < kRowsTogether ? part.rows - together : kRowsTogether;
    of.from_y = part.first_row + together;
    FindSpans(part, of.from_y, static_cast<float>(-part.x), static_cast<float>(width - 1 - part.x), spans);
    most += kRowsTogether / 2 * WholeGoes(spans.widest) / 2;
    const bool roomy = most <= capacity && spans.past + kTogether <= of.right_end;
    const int odd_y = (part.y + of.from_y) & 1;
    PutRows<kMixed>(of, odd_y, past, roomy, of_row[0]);
    PutRows<kMixed>(of, 1 - odd_y, past, roomy, of_row[1]);
  }
  int all = 0;
  for (int phase = 0; phase < 4; ++phase) {
    const RowLanes& of_phase = of_row[phase / 2];
    const int count = of_phase.Count(phase % 2 ? of_phase.odd : of_phase.even);
    block.SetCount(lane + phase, count);
    all += count;
  }
  return all;
}

int TakePart(const CornerPart& part, const LightReader::Rows& rows, int width, int lane, LaneBlock& block) {
  Spans spans;
  PartRows of{part,
              rows,
              spans,
              0,
              width - part.x,
              GoWalk::Changes(2 * part.plane.by_xx[0]),
              GoWalk::Changes(2 * part.plane.by_xx[1])};
  return rows.are_mixed() ? PutPart<true>(of, spans, width, block, lane)
                          : PutPart<false>(of, spans, width, block, lane);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(TakePart);

}  // namespace

int TakePixels(const CornerPart& part, const LightReader::Rows& rows, int width, int lane, LaneBlock& block) {
  return HWY_DYNAMIC_DISPATCH(TakePart)(part, rows, width, lane, block);
}

}  // namespace chequer
#endif  // HWY_ONCE
