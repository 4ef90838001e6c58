#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/corner_pixels.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

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
  /// Plane coordinates of the first, and how they change to the next.
  HWY_ALIGN float at[2][kRowsTogether];
  HWY_ALIGN float step[2][kRowsTogether];
};

/// @param left, right columns of the image's edges, from CornerPart::x.
void FindSpans(const CornerPart& part, int first_row, float left, float right, Spans& spans) {
  const hn::CappedTag<float, kRowsTogether> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto set = [&](float value) HWY_ATTR { return hn::Set(d, value); };
  const Band &a = part.bands[0], &b = part.bands[1];
  for (int row = 0; row < kRowsTogether; row += static_cast<int>(hn::Lanes(d))) {
    const auto dy = hn::Iota(d, static_cast<float>(first_row + row) - part.corner_y);
    const auto at_a = hn::MulAdd(dy, set(a.slope), set(part.corner_x));
    const auto at_b = hn::MulAdd(dy, set(b.slope), set(part.corner_x));
    const auto from = hn::Max(hn::Add(at_a, set(a.low)), hn::Add(at_b, set(b.low)));
    const auto to = hn::Min(hn::Add(at_a, set(a.high)), hn::Add(at_b, set(b.high)));
    const auto first = hn::Ceil(hn::Min(hn::Max(from, set(left)), set(right + 1)));
    const auto last = hn::Floor(hn::Max(hn::Min(to, set(right)), set(left - 1)));
    hn::Store(hn::ConvertTo(di, first), di, spans.first + row);
    hn::Store(hn::ConvertTo(di, hn::Add(hn::Sub(last, first), set(1))), di, spans.pixels + row);
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
}

/// The plane coordinates of the pixels of a row: parabolas, by differences.
struct PlaneWalk {
  float u, v, step_u, step_v, change_u, change_v;

  HWY_INLINE void Next() {
    u += step_u, v += step_v;
    step_u += change_u, step_v += change_v;
  }
  /// So many pixels on from here.
  HWY_INLINE PlaneWalk After(int pixels) const {
    const float n = static_cast<float>(pixels), pairs = n * (n - 1) / 2;
    return {u + n * step_u + pairs * change_u, v + n * step_v + pairs * change_v, 0, 0, 0, 0};
  }
};

/// The next places of the lanes of a row's first pixel and second pixel, in turn.
struct Lanes {
  float *first, *second;
};

HWY_INLINE void Put(const PlaneWalk& walk, float light, float*& lane) {
  lane[0] = walk.u;
  lane[LaneBlock::kGroup] = walk.v;
  lane[2 * LaneBlock::kGroup] = light;
  lane += LaneBlock::kNextPixel;
}

/// Pixels of a row that are put in one go: as many as it takes for the processor to guess right how often to go round.
constexpr int kTogether = 4;

HWY_INLINE int WholeGoes(int count) { return (count + kTogether - 1) / kTogether * kTogether; }

/// Puts the next `count` pixels of a row, a multiple of kTogether, into their lanes. @tparam kMixed is what
/// run.is_mixed() says.
template <bool kMixed>
HWY_INLINE void PutGoes(const LightReader::Run& run, int count, PlaneWalk walk, Lanes lanes) {
  const std::uint8_t *first = run.first, *second = run.second;
  const float* const table = run.table;
  for (; count > 0; count -= kTogether)
    for (int pair = 0; pair < kTogether / 2; ++pair, first += run.step, second += run.step) {
      Put(walk, kMixed ? RedAndGreen::Of(table[first[run.red]], table[*first]) : table[*first], lanes.first);
      walk.Next();
      Put(walk, kMixed ? RedAndGreen::Of(table[second[run.red]], table[*second]) : table[*second], lanes.second);
      walk.Next();
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
      : thinning_(thinning), x_(x), tile_of_row_(y / 2 * 3), across_x_(across_x), across_y_(across_y) {}

  /// The first that is kept from pixel i on, `count` if none is. To be asked for ever later ones.
  int Next(int i, int count) {
    while (i < count) {
      if (i >= alike_until_) LookAhead(i);
      const int past = ((x_ + i) / 2 + tile_of_row_) % every_;
      if (past == 0) return i;
      i = std::min(i + 2 * (every_ - past) - (x_ + i) % 2, alike_until_);
    }
    return count;
  }
  /// Along an edge.
  bool KeepsAll(int count) const {
    return thinning_.near_edges == 1 && std::abs(across_y_.At(0)) <= thinning_.band_y &&
           std::abs(across_y_.At(count - 1)) <= thinning_.band_y;
  }

 private:
  /// Finds out how many tiles are kept around pixel i, and how far that holds at least.
  void LookAhead(int i) {
    const float x = across_x_.At(i), y = across_y_.At(i);
    const bool near_x = std::abs(x) <= thinning_.band_x, near_y = std::abs(y) <= thinning_.band_y;
    const int x_until = i + Until(x, across_x_.by_pixel, thinning_.band_x, near_x),
              y_until = i + Until(y, across_y_.by_pixel, thinning_.band_y, near_y);
    every_ = near_x || near_y ? thinning_.near_edges : thinning_.inside;
    // Near both, pixels stay near until they have left both; near none, until they reach one.
    if (near_x == near_y) alike_until_ = near_x ? std::max(x_until, y_until) : std::min(x_until, y_until);
    else alike_until_ = near_x ? x_until : y_until;
  }
  /// Pixels from one at that distance on, at least one, until the next edge of the band may have been crossed.
  static int Until(float at, float by_pixel, float band, bool is_near) {
    const float edge = is_near == (by_pixel > 0) ? band : -band;
    const float steps = (edge - at) / by_pixel;
    if (steps > 0) return std::max(static_cast<int>(std::min(steps, static_cast<float>(kNever))), 1);
    return is_near ? 1 : kNever;  // at the band's edge, or going away
  }

  const Thinning& thinning_;
  int x_, tile_of_row_;
  Across across_x_, across_y_;
  int alike_until_ = 0;  ///< from the last pixel that was looked at on to this, as many tiles are kept
  int every_ = 1;        ///< one in so many
};

/// Puts those of the pixels of a row that next(index, count) leads to, and counts them.
template <class Next>
void PutSome(const LightReader::Run& run, int count, Next&& next, const PlaneWalk& walk, Lanes lanes, int& first_count,
             int& second_count) {
  for (int i = next(0, count); i < count; i = next(i + 1, count)) {
    const std::uint8_t* pixel = (i % 2 ? run.second : run.first) + i / 2 * run.step;
    Put(walk.After(i), run.is_mixed() ? run.Mixed(pixel) : run.table[*pixel], i % 2 ? lanes.second : lanes.first);
    ++(i % 2 ? second_count : first_count);
  }
}

/// A row of pixels.
struct Row {
  int x, y, pixels;
  PlaneWalk walk;

  HWY_INLINE int phase() const { return (x & 1) + 2 * (y & 1); }  ///< of the first pixel
};

/// What the rows of a part are put into.
struct Target {
  float* pixels;  ///< of the first lane
  int capacity;
  int count[4];  ///< by phase

  HWY_INLINE Lanes From(int phase) const {
    return {pixels + phase + count[phase] * LaneBlock::kNextPixel,
            pixels + (phase ^ 1) + count[phase ^ 1] * LaneBlock::kNextPixel};
  }
  /// For whole goes.
  HWY_INLINE bool HasRoom(const Row& row) const {
    const int fuller = count[row.phase()] > count[row.phase() ^ 1] ? count[row.phase()] : count[row.phase() ^ 1];
    return fuller + WholeGoes(row.pixels) / 2 <= capacity;
  }
};

/// Puts a row with no more pixels than there is room for. The pixels after it, up to whole goes, are put too, as they
/// need: they are not counted, and the next row overwrites them.
template <bool kMixed>
HWY_INLINE void PutRow(const LightReader::Rows& rows, const Row& row, Target& target) {
  const int phase = row.phase();
  PutGoes<kMixed>(rows.From(row.x, row.y), WholeGoes(row.pixels), row.walk, target.From(phase));
  target.count[phase] += (row.pixels + 1) / 2;
  target.count[phase ^ 1] += row.pixels / 2;
}

/// Puts as much of a row as there is room for. @param dx, dy of its first pixel from the corner.
void PutRowOfFew(const CornerPart& part, const LightReader::Rows& rows, const Row& row, float dx, float dy,
                 Target& target) {
  const int phase = row.phase();
  int &first_count = target.count[phase], &second_count = target.count[phase ^ 1];
  const int room = 2 * (target.capacity - (first_count > second_count ? first_count : second_count));
  const int pixels = row.pixels < room ? row.pixels : room;
  Keeper keeper(part.thinning, row.x, row.y,
                {part.board_by_x[0] * dx + part.board_by_y[0] * dy, part.board_by_x[0]},
                {part.board_by_x[1] * dx + part.board_by_y[1] * dy, part.board_by_x[1]});
  const LightReader::Run run = rows.From(row.x, row.y);
  if (part.thinning.all || keeper.KeepsAll(row.pixels))
    PutSome(
        run, pixels, [](int i, int) { return i; }, row.walk, target.From(phase), first_count, second_count);
  else
    PutSome(
        run, pixels, [&](int i, int count) { return keeper.Next(i, count); }, row.walk, target.From(phase), first_count,
        second_count);
}

void TakePart(const CornerPart& part, const LightReader::Rows& rows, int width, int lane, LaneBlock& block) {
  Target target{block.u_data() + block.Place(lane, 0), block.capacity(), {}};
  const float change_u = 2 * part.plane.by_xx[0], change_v = 2 * part.plane.by_xx[1];
  Spans spans;
  for (int together = 0; together < part.rows; together += kRowsTogether) {
    const int past = part.rows - together < kRowsTogether ? part.rows - together : kRowsTogether;
    FindSpans(part, part.first_row + together, static_cast<float>(-part.x), static_cast<float>(width - 1 - part.x),
              spans);
    for (int i = 0; i < past; ++i) {
      if (spans.pixels[i] <= 0) continue;
      const int from_y = part.first_row + together + i;
      const Row row{part.x + spans.first[i],
                    part.y + from_y,
                    spans.pixels[i],
                    {spans.at[0][i], spans.at[1][i], spans.step[0][i], spans.step[1][i], change_u, change_v}};
      if (part.thinning.all && row.x + WholeGoes(row.pixels) <= width && target.HasRoom(row)) {
        rows.are_mixed() ? PutRow<true>(rows, row, target) : PutRow<false>(rows, row, target);
        continue;
      }
      PutRowOfFew(part, rows, row, static_cast<float>(spans.first[i]) - part.corner_x,
                  static_cast<float>(from_y) - part.corner_y, target);
    }
  }
  for (int phase = 0; phase < 4; ++phase) block.SetCount(lane + phase, target.count[phase]);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(TakePart);

}  // namespace

void TakePixels(const CornerPart& part, const LightReader::Rows& rows, int width, int lane, LaneBlock& block) {
  HWY_DYNAMIC_DISPATCH(TakePart)(part, rows, width, lane, block);
}

}  // namespace chequer
#endif  // HWY_ONCE
