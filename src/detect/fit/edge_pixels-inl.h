// What the pixels of a vector of lanes say of the edges that they lie beside, for the kernels of both models.
//
// Who includes this is compiled once for each target of the processor, so this file is included once a target, too: the
// guard turns with Highway's own.
#if defined(CHEQUER_DETECT_EDGE_PIXELS) == defined(HWY_TARGET_TOGGLE)
#ifdef CHEQUER_DETECT_EDGE_PIXELS
#undef CHEQUER_DETECT_EDGE_PIXELS
#else
#define CHEQUER_DETECT_EDGE_PIXELS
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "detect/fit/blurred_edge-inl.h"
#include "detect/fit/edge_noise.h"

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What a vector of pixels says of the edges across one axis.
struct EdgePixels {
  static constexpr std::size_t kMaxLanes = HWY_MAX_BYTES / sizeof(float);

  HWY_INLINE void Set(V off_px, V derivative, V deviation) {
    const D d;
    const hn::RebindToSigned<D> di;
    constexpr float kHalf = AlikeEdges::kDistances / 2;
    // Numbers below zero are rounded upwards.
    const V from_first = hn::Max(hn::Add(off_px, hn::Set(d, kHalf)), hn::Zero(d));
    hn::Store(hn::Min(hn::ConvertTo(di, from_first), hn::Set(di, AlikeEdges::kDistances - 1)), di, distance);
    hn::Store(hn::Mul(derivative, deviation), d, score);
    hn::Store(hn::Mul(derivative, derivative), d, information);
  }
  HWY_INLINE void AddTo(AlikeEdges& edges, int first, int count) const {
    for (int i = 0; i < count; ++i) {
      const int group = edges.group_of_lane[static_cast<std::size_t>(first + i)];
      if (group < 0) continue;
      EdgeErrors& sum = edges.errors[static_cast<std::size_t>(group)][static_cast<std::size_t>(distance[i])];
      sum.score += score[i];
      sum.information += information[i];
    }
  }

  HWY_ALIGN std::int32_t distance[kMaxLanes];
  HWY_ALIGN float score[kMaxLanes], information[kMaxLanes];
};

/// What a vector of pixels says of both kinds of edges, and of where they meet.
struct EdgesOfPixels {
  EdgePixels x, y;

  /// @param contrast of the corner: light where both coordinates are positive or negative, less that of the other two.
  HWY_INLINE void Set(V deviation, V contrast, V counts) {
    const D d;
    hn::Store(hn::IfThenElse(hn::Lt(contrast, hn::Zero(d)), hn::Neg(deviation), deviation), d, deviations);
    hn::Store(counts, d, there);
  }
  HWY_INLINE void AddTo(AlikeEdges& of_x, AlikeEdges& of_y, AlikePlaces* places, int first, int count) const {
    x.AddTo(of_x, first, count);
    y.AddTo(of_y, first, count);
    if (!places) return;
    for (int i = 0; i < count; ++i) {
      const std::size_t lane = static_cast<std::size_t>(first + i);
      if (of_x.group_of_lane[lane] < 0 && of_y.group_of_lane[lane] < 0) continue;
      AlikePlaces::Errors& sum =
          places->errors[static_cast<std::size_t>(y.distance[i] * AlikeEdges::kDistances + x.distance[i])];
      sum.sum += deviations[i];
      sum.square += deviations[i] * deviations[i];
      sum.count += there[i];
    }
  }

  HWY_ALIGN float deviations[EdgePixels::kMaxLanes], there[EdgePixels::kMaxLanes];
};

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#endif  // the guard
