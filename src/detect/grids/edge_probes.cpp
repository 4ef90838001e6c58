#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/grids/edge_probes.cpp"
#include <hwy/foreach_target.h>
// The loop above includes this file once a target; what follows the guard at the end is compiled once.
#include <hwy/highway.h>

#include "detect/grids/edge_probes.h"

#ifndef CHEQUER_DETECT_EDGE_PROBES
#define CHEQUER_DETECT_EDGE_PROBES
namespace chequer {
namespace edge_probes {

/// Where along the line it is crossed (a guess).
constexpr float kParts[] = {0.3f, 0.5f, 0.7f};
/// How far from the line both ends of a crossing lie, as a share of its length (a guess).
constexpr float kReach = 0.25f;
constexpr int kPoints = 6;

/// What the loops below read of a plane.
struct Input {
  const std::uint8_t* pixels;
  int width, height;
  std::ptrdiff_t row;
};

}  // namespace edge_probes
}  // namespace chequer
#endif  // CHEQUER_DETECT_EDGE_PROBES

HWY_BEFORE_NAMESPACE();
namespace chequer {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
constexpr int kMaxLanes = static_cast<int>(hn::MaxLanes(D()));

/// The points of a vector of lines: where the four pixels around each begin in memory, and what shares they have.
struct Points {
  HWY_ALIGN std::int32_t at[edge_probes::kPoints][kMaxLanes];
  HWY_ALIGN std::uint32_t pixels[edge_probes::kPoints][kMaxLanes];  ///< the four, first row first, from the low bits on
  V right[edge_probes::kPoints], down[edge_probes::kPoints];
};

void PlacePoint(const edge_probes::Input& in, V x, V y, int point, Points& points) {
  const D d;
  const hn::RebindToSigned<D> di;
  const V zero = hn::Zero(d);
  x = hn::Min(hn::Max(x, zero), hn::Set(d, static_cast<float>(in.width - 1)));
  y = hn::Min(hn::Max(y, zero), hn::Set(d, static_cast<float>(in.height - 1)));
  const auto col = hn::ConvertTo(di, x), row = hn::ConvertTo(di, y);
  points.right[point] = hn::Sub(x, hn::ConvertTo(d, col));
  points.down[point] = hn::Sub(y, hn::ConvertTo(d, row));
  hn::Store(hn::Add(hn::Mul(row, hn::Set(di, static_cast<std::int32_t>(in.row))), col), di, points.at[point]);
}

/// All pixels of a vector's lines one after the other: memory is waited for once. In a plane's last row and column, the
/// pixels beyond have no share; there is memory for them.
void FetchPixels(const edge_probes::Input& in, int lanes, Points& points) {
  for (int point = 0; point < edge_probes::kPoints; ++point)
    for (int lane = 0; lane < lanes; ++lane) {
      const std::uint8_t* p = in.pixels + points.at[point][lane];
      const std::uint8_t* below = p + in.row;
      const std::uint32_t first = p[0] | static_cast<std::uint32_t>(p[1]) << 8,
                          second = below[0] | static_cast<std::uint32_t>(below[1]) << 8;
      points.pixels[point][lane] = first | second << 16;
    }
}

V LevelAt(const Points& points, int point) {
  const D d;
  const hn::RebindToUnsigned<D> du;
  const hn::RebindToSigned<D> di;
  const auto pixels = hn::Load(du, points.pixels[point]);
  const auto byte = hn::Set(du, 255);
  const auto level = [&](auto bits) HWY_ATTR { return hn::ConvertTo(d, hn::BitCast(di, hn::And(bits, byte))); };
  const V a = level(pixels), b = level(hn::ShiftRight<8>(pixels)), c = level(hn::ShiftRight<16>(pixels)),
          e = level(hn::ShiftRight<24>(pixels));
  const V top = hn::MulAdd(points.right[point], hn::Sub(b, a), a);
  const V bottom = hn::MulAdd(points.right[point], hn::Sub(e, c), c);
  return hn::MulAdd(points.down[point], hn::Sub(bottom, top), top);
}

void LookAlong(const FloatColumns& columns, std::size_t count, const edge_probes::Input& in, std::uint8_t* found) {
  using P = EdgeProbes;
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  Points points;
  for (std::size_t first = 0; first < count; first += static_cast<std::size_t>(lanes)) {
    const auto column = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, columns.column(k) + first); };
    const V x = column(P::kX), y = column(P::kY), along_x = column(P::kAlongX), along_y = column(P::kAlongY);
    const V square = hn::MulAdd(along_x, along_x, hn::Mul(along_y, along_y));
    const V length = hn::Sqrt(hn::Max(square, hn::Set(d, 1e-6f)));
    const V reach = hn::Min(hn::Mul(length, hn::Set(d, edge_probes::kReach)), column(P::kMostReach));
    const V turn = hn::Div(hn::Mul(column(P::kSide), reach), length);
    const V out_x = hn::Neg(hn::Mul(along_y, turn)), out_y = hn::Mul(along_x, turn);
    for (int k = 0; k < edge_probes::kPoints / 2; ++k) {
      const V part = hn::Set(d, edge_probes::kParts[k]);
      const V on_x = hn::MulAdd(part, along_x, x), on_y = hn::MulAdd(part, along_y, y);
      PlacePoint(in, hn::Add(on_x, out_x), hn::Add(on_y, out_y), 2 * k, points);
      PlacePoint(in, hn::Sub(on_x, out_x), hn::Sub(on_y, out_y), 2 * k + 1, points);
    }
    FetchPixels(in, lanes, points);
    V least = hn::Set(d, 256.0f);
    for (int k = 0; k < edge_probes::kPoints; k += 2)
      least = hn::Min(least, hn::Sub(LevelAt(points, k), LevelAt(points, k + 1)));
    HWY_ALIGN float shown[kMaxLanes];
    hn::Store(hn::Sub(least, column(P::kLeastStep)), d, shown);
    for (int lane = 0; lane < lanes; ++lane) found[first + static_cast<std::size_t>(lane)] = shown[lane] >= 0;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace chequer
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>

namespace chequer {
namespace {

HWY_EXPORT(LookAlong);

}  // namespace

void EdgeProbes::Start(std::size_t most) {
  count_ = 0;
  columns_.Resize(kColumns, most);
  found_.Resize(most + FloatColumns::kBeyond);
}

std::span<const std::uint8_t> EdgeProbes::Look(const BytePlane& plane) {
  // What vectors read beyond the last line are places too.
  for (std::size_t k = 0; k < kColumns; ++k) std::fill_n(columns_.column(k) + count_, FloatColumns::kBeyond, 0.0f);
  const edge_probes::Input input{plane.row(0), plane.width(), plane.height(), plane.stride()};
  HWY_DYNAMIC_DISPATCH(LookAlong)(columns_, count_, input, found_.data());
  return std::span(found_).first(count_);
}

}  // namespace chequer
#endif  // HWY_ONCE
