#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/fit/model_kernel.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include <algorithm>

#include "detect/common/reciprocal-inl.h"
#include "detect/fit/edge_pixels-inl.h"
#include "detect/fit/model_kernel.h"
#include "detect/fit/model_light-inl.h"
#include "detect/fit/weighed_pixel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Pixels whose rows of derivatives are kept before they are multiplied.
constexpr int kRowsKept = 8;
/// Rows hold whole blocks of columns.
constexpr int kBlock = ModelColumns::kBlock;
constexpr int kRowColumns = (ModelColumns::kMost + kBlock - 1) / kBlock * kBlock;

/// Sums beside the products.
struct FitSums {
  V weight, square, dark_square, dark_light, dark_count, light_square, light_light, light_count, saturated;
};

/// The derivatives by the board's moves, in the order of BoardGeometry::MoveByParameters().
template <class Put>
HWY_INLINE void PutMoves(const LaneModel& m, const Picture& p, const ByStretch& stretch, V x, V y, const Put& put) {
  put(0, p.by_x);
  put(1, hn::MulAdd(p.by_x, x, stretch.xx));
  put(2, hn::MulAdd(p.by_x, y, stretch.xy));
  put(3, p.by_y);
  put(4, hn::MulAdd(p.by_y, x, stretch.yx));
  put(5, hn::MulAdd(p.by_y, y, stretch.yy));
  // By x (x, y) and y (x, y). All pixels around a corner have its blur and way.
  const V along = hn::MulAdd(p.by_x, x, hn::Mul(p.by_y, y)), both = hn::Add(stretch.xx, stretch.yy);
  const V corner_x = m.of(ModelLanes::kCornerX), corner_y = m.of(ModelLanes::kCornerY);
  const V by_6 = hn::MulAdd(corner_x, hn::Add(both, stretch.xx), hn::Mul(corner_y, stretch.yx)),
          by_7 = hn::MulAdd(corner_y, hn::Add(both, stretch.yy), hn::Mul(corner_x, stretch.xy));
  put(6, hn::MulAdd(along, x, by_6));
  put(7, hn::MulAdd(along, y, by_7));
}

HWY_INLINE Weighed WeighAt(const ModelInput& input, const LaneModel& m, const Picture& p, V marked_light,
                           hn::Mask<D> inside) {
  const D d;
  const V variance =
      hn::MulAdd(m.of(ModelLanes::kNoiseSlope), hn::Max(p.light, hn::Zero(d)), m.of(ModelLanes::kNoiseFloor));
  return WeighLight(p.light, ReciprocalSqrt(d, variance), marked_light, inside, Splat(input.robust_limit));
}

/// Weighs a pixel by its noise and by how well it fits, and puts its row.
HWY_INLINE void PutRow(const ModelInput& input, const ModelColumns& columns, const LaneModel& m, const Picture& p,
                       ByTerms& by, V x, V y, V window, V marked_light, hn::Mask<D> inside, float* HWY_RESTRICT row,
                       FitSums& sums) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V zero = hn::Zero(d);
  const Weighed w = WeighAt(input, m, p, marked_light, inside);
  const V root = hn::Mul(w.root, window), weighted = hn::Mul(w.deviation, window);
  const V square = hn::Mul(w.fit_residual, w.fit_residual);
  const V middle =
      hn::Mul(Splat(0.25f), hn::Add(hn::Add(m.light[1][1], m.light[1][2]), hn::Add(m.light[2][1], m.light[2][2])));
  const V dark = hn::IfThenElseZero(hn::Lt(p.light, middle), w.fits), bright = hn::Sub(w.fits, dark);
  sums.weight = hn::MulAdd(w.robust, hn::Mul(window, window), sums.weight);
  sums.saturated = hn::Add(w.saturated, sums.saturated);
  sums.dark_square = hn::MulAdd(square, dark, sums.dark_square);
  sums.dark_light = hn::MulAdd(p.light, dark, sums.dark_light);
  sums.dark_count = hn::Add(dark, sums.dark_count);
  sums.light_square = hn::MulAdd(square, bright, sums.light_square);
  sums.light_light = hn::MulAdd(p.light, bright, sums.light_light);
  sums.light_count = hn::Add(bright, sums.light_count);
  sums.square = hn::MulAdd(weighted, weighted, sums.square);

  const auto put = [&](int column, V value) HWY_ATTR { hn::Store(value, d, row + column * lanes); };
  const auto put_rooted = [&](int column, V value) HWY_ATTR { put(column, hn::Mul(value, root)); };
  PutMoves(m, p, StretchOf(input, m, p), x, y, put_rooted);
  put_rooted(columns.blur, p.by_blur);
  ForEachTerm(Terms(), input.terms, [&]<class Term>() HWY_ATTR {
    for (int i = 0; i < Term::kColumns; ++i) put_rooted(columns.of<Term>() + i, by.of<Term>()[i]);
  });
  for (int i = 0; i < ModelColumns::kLevels; ++i) put_rooted(columns.levels + i, p.share[i / kSide][i % kSide]);
  put(columns.residual(), weighted);
  for (int i = columns.count; i % kBlock != 0; ++i) put(i, zero);
}

/// sums += Σ over the rows of row[a] row[b], a ≤ b; the sums begin with these where they are `fresh`.
HWY_INLINE void AddModelProducts(const ModelColumns& columns, const float* HWY_RESTRICT rows, int count, int first,
                                 bool fresh, ModelLanes& model) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d)), n = columns.count, row_size = kRowColumns * lanes;
  float* HWY_RESTRICT to = model.sum_data(0, first);
  for (int a = 0; a < n; a += ModelColumns::kPair)
    for (int b = a / kBlock * kBlock; b < n; b += kBlock) {
      V sum0 = hn::Zero(d), sum1 = sum0, sum2 = sum0, sum3 = sum0, sum4 = sum0, sum5 = sum0, sum6 = sum0, sum7 = sum0;
      const float* HWY_RESTRICT left = rows + a * lanes;
      const float* HWY_RESTRICT right = rows + b * lanes;
      for (int k = 0; k < count; ++k, left += row_size, right += row_size) {
        const V l0 = hn::Load(d, left), l1 = hn::Load(d, left + lanes);
        const V r0 = hn::Load(d, right), r1 = hn::Load(d, right + lanes), r2 = hn::Load(d, right + 2 * lanes),
                r3 = hn::Load(d, right + 3 * lanes);
        sum0 = hn::MulAdd(l0, r0, sum0);
        sum1 = hn::MulAdd(l0, r1, sum1);
        sum2 = hn::MulAdd(l0, r2, sum2);
        sum3 = hn::MulAdd(l0, r3, sum3);
        sum4 = hn::MulAdd(l1, r0, sum4);
        sum5 = hn::MulAdd(l1, r1, sum5);
        sum6 = hn::MulAdd(l1, r2, sum6);
        sum7 = hn::MulAdd(l1, r3, sum7);
      }
      const auto put = [&](V sum) HWY_ATTR {
        hn::StoreU(fresh ? sum : hn::Add(hn::LoadU(d, to), sum), d, to);
        to += ModelLanes::kNextProduct;
      };
      put(sum0), put(sum1), put(sum2), put(sum3), put(sum4), put(sum5), put(sum6), put(sum7);
    }
}

void WriteSums(const FitSums& sums, int first, LaneBlock& block) {
  const D d;
  const auto finish = [&](int which, V value) HWY_ATTR { hn::StoreU(value, d, block.sum_data(which) + first); };
  finish(kWeight, sums.weight);
  finish(kDarkSquare, sums.dark_square);
  finish(kDarkLight, sums.dark_light);
  finish(kDarkCount, sums.dark_count);
  finish(kLightSquare, sums.light_square);
  finish(kLightLight, sums.light_light);
  finish(kLightCount, sums.light_count);
  finish(kSaturatedWeight, sums.saturated);
  finish(ProductSum(kResidual, kResidual), sums.square);
}

/// The lanes from `first` on that fill a vector.
struct LanesThere {
  LaneModel m;
  EdgeProfile profiles[2];
  PowerTerms gaussian;
  int most = 0;  ///< pixels
  V count;

  LanesThere(const ModelInput& input, int first, const LaneBlock& block, const ModelLanes& model)
      : profiles{EdgeProfile(input.edge_x), EdgeProfile(input.edge_y)}, gaussian(PowerTermsOf({})) {
    const D d;
    const hn::RebindToSigned<D> di;
    Load(input, model, first, m);
    for (int lane = first; lane < first + static_cast<int>(hn::Lanes(d)); ++lane)
      most = std::max(most, block.counts()[lane]);
    count = hn::ConvertTo(d, hn::LoadU(di, block.counts() + first));
  }
};

/// The pixels of a vector as the model has them.
struct PixelsThere {
  V x, y;              ///< cells from their corners
  V board_x, board_y;  ///< board coordinates
  V light;             ///< in the image
  Picture p;
  V window;
  hn::Mask<D> in_window;

  /// @param k of each lane. @param at where the block has them. @param by what is set of terms that are on.
  HWY_INLINE PixelsThere(const ModelInput& input, const LanesThere& lanes, const LaneBlock& block, int k,
                         std::size_t at, ByTerms& by) {
    const D d;
    const LaneModel& m = lanes.m;
    const auto inside = hn::Lt(Splat(static_cast<float>(k)), lanes.count);
    // Beyond a lane's count an earlier board's pixels may stand, which this homography may send to infinity.
    const V u = hn::IfThenElseZero(inside, hn::LoadU(d, block.u_data() + at)),
            v = hn::IfThenElseZero(inside, hn::LoadU(d, block.v_data() + at));
    light = hn::IfThenElseZero(inside, hn::LoadU(d, block.light_data() + at));
    const auto row_of = [&](const V* to) HWY_ATTR { return hn::MulAdd(to[0], u, hn::MulAdd(to[1], v, to[2])); };
    const V w = Reciprocal(d, row_of(m.to_depth));
    x = hn::Mul(row_of(m.to_x), w), y = hn::Mul(row_of(m.to_y), w);
    board_x = hn::Add(x, m.of(ModelLanes::kCornerX)), board_y = hn::Add(y, m.of(ModelLanes::kCornerY));
    LookAt(input, m, x, y, lanes.profiles, p);
    Bend(input, m, board_x, board_y, lanes.gaussian, p, by);
    // As in the plain model, the window ends softly.
    const auto within =
        [&](V where, ModelLanes::Parameter fade, ModelLanes::Parameter middle, ModelLanes::Parameter peak)
            HWY_ATTR { return hn::NegMulAdd(hn::Abs(hn::Sub(where, m.of(middle))), m.of(fade), m.of(peak)); };
    const V zero = hn::Zero(d);
    const V ends = hn::Min(within(x, ModelLanes::kFadeX, ModelLanes::kMiddleX, ModelLanes::kPeakX),
                           within(y, ModelLanes::kFadeY, ModelLanes::kMiddleY, ModelLanes::kPeakY));
    in_window = hn::And(inside, hn::Gt(ends, zero));
    window = hn::Max(hn::Min(ends, Splat(1)), zero);
  }
};

/// Of the lanes from `first` on that fill a vector.
void AddLanes(const ModelInput& input, const ModelColumns& columns, int first, LaneBlock& block, ModelLanes& model) {
  const D d;
  constexpr int kMaxLanes = HWY_MAX_BYTES / sizeof(float);
  const int lanes = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float rows[kRowsKept * kRowColumns * kMaxLanes];
  const LanesThere there(input, first, block, model);
  const V zero = hn::Zero(d);
  FitSums sums{zero, zero, zero, zero, zero, zero, zero, zero, zero};
  ByTerms by;
  std::fill(std::begin(by.by), std::end(by.by), zero);
  int kept = 0;
  bool fresh = true;
  std::size_t at = block.Place(first, 0);
  const std::size_t next = static_cast<std::size_t>(input.stride * LaneBlock::kNextPixel);
  for (int k = 0; k < there.most; k += input.stride, at += next) {
    const PixelsThere pixels(input, there, block, k, at, by);
    PutRow(input, columns, there.m, pixels.p, by, pixels.board_x, pixels.board_y, pixels.window, pixels.light,
           pixels.in_window, rows + kept * kRowColumns * lanes, sums);
    if (++kept < kRowsKept) continue;
    AddModelProducts(columns, rows, kept, first, fresh, model);
    kept = 0;
    fresh = false;
  }
  if (kept > 0 || fresh) AddModelProducts(columns, rows, kept, first, fresh, model);
  WriteSums(sums, first, block);
}

/// The same, of what pixels say of edges.
void AddErrorsOfLanes(const ModelInput& input, int first, const LaneBlock& block, const ModelLanes& model,
                      float blur_px, AlikeEdges& x, AlikeEdges& y, AlikePlaces* places) {
  const D d;
  const LanesThere there(input, first, block, model);
  ByTerms by;
  std::fill(std::begin(by.by), std::end(by.by), hn::Zero(d));
  EdgesOfPixels edges;
  const auto& light = there.m.light;
  const V contrast = hn::Sub(hn::Add(light[1][1], light[2][2]), hn::Add(light[1][2], light[2][1]));
  std::size_t at = block.Place(first, 0);
  const int stride = AlikeEdges::kStride * input.stride;
  for (int k = 0; k < there.most; k += stride, at += static_cast<std::size_t>(stride * LaneBlock::kNextPixel)) {
    const PixelsThere pixels(input, there, block, k, at, by);
    const Weighed w = WeighAt(input, there.m, pixels.p, pixels.light, pixels.in_window);
    const V root = hn::Mul(w.root, pixels.window), deviation = hn::Mul(w.deviation, pixels.window);
    const auto px = [&](V cells, ModelLanes::Parameter scale)
                        HWY_ATTR { return hn::Mul(hn::Mul(cells, there.m.of(scale)), Splat(blur_px)); };
    edges.x.Set(px(pixels.x, ModelLanes::kScaleX), hn::Mul(pixels.p.by_x, root), deviation);
    edges.y.Set(px(pixels.y, ModelLanes::kScaleY), hn::Mul(pixels.p.by_y, root), deviation);
    edges.Set(deviation, contrast, w.robust);
    edges.AddTo(x, y, places, first, static_cast<int>(hn::Lanes(d)));
  }
}

void Accumulate(const ModelInput& input, const ModelColumns& columns, LaneBlock& block, ModelLanes& model) {
  const int lanes = static_cast<int>(hn::Lanes(D()));
  for (int first = 0; first < block.padded(); first += lanes) AddLanes(input, columns, first, block, model);
}

void AddModelErrors(const ModelInput& input, const LaneBlock& block, const ModelLanes& model, float blur_px,
                    AlikeEdges& x, AlikeEdges& y, AlikePlaces* places) {
  const int lanes = static_cast<int>(hn::Lanes(D()));
  for (int first = 0; first < block.padded(); first += lanes)
    AddErrorsOfLanes(input, first, block, model, blur_px, x, y, places);
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace chequer {
namespace {

HWY_EXPORT(Accumulate);
HWY_EXPORT(AddModelErrors);

}  // namespace

ModelColumns::ModelColumns(const ModelTerms& terms) {
  int next = blur + 1;
  Terms::ForEach([&]<class Term>() {
    if (terms.on<Term>()) first_[Terms::BeforeTerm<Term>().terms] = next, next += Term::kColumns;
  });
  shared = levels = next;
  count = levels + kLevels + 1;
}

void ModelLanes::Reset(int padded_lanes, int products) {
  padded_ = padded_lanes;
  products_ = products;
  // Lanes without pixels are given nothing, but what they hold has to be finite.
  parameters_.resize(static_cast<std::size_t>(padded_) * kParameters, 1.0f);
  // Windows that nobody says anything of end nowhere.
  std::fill_n(parameter_data(kFadeX), 2 * padded_, 0.0f);
  std::fill_n(parameter_data(kPeakX), 2 * padded_, 1.0f);
  // Never shrinks: what is grown again would be filled again.
  sums_.resize(std::max(sums_.size(), static_cast<std::size_t>(padded_) * static_cast<std::size_t>(products)));
}

void AccumulateModel(const ModelInput& input, LaneBlock& block, ModelLanes& model) {
  const ModelColumns columns(input.terms);
  if (block.is_folded())
    for (int which = 0; which < ModelLanes::kParameters; ++which) block.SpreadFolded(model.parameter_data(which));
  HWY_DYNAMIC_DISPATCH(Accumulate)(input, columns, block, model);
  if (!block.is_folded()) return;
  for (int product = 0; product < columns.products(); ++product)
    LaneBlock::GatherGroup(model.sum_data(product, block.folded()));
  for (int which = kWeight; which < kLaneSums; ++which) block.GatherFolded(block.sum_data(which));
  block.GatherFolded(block.sum_data(ProductSum(kResidual, kResidual)));
}

void AddEdgeErrors(const ModelInput& input, const LaneBlock& block, const ModelLanes& model, float blur_px,
                   AlikeEdges& x, AlikeEdges& y, AlikePlaces* places) {
  HWY_DYNAMIC_DISPATCH(AddModelErrors)(input, block, model, blur_px, x, y, places);
}

}  // namespace chequer
#endif  // HWY_ONCE
