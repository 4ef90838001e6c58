#include "detect/identity/cover_mix.h"

#include <algorithm>
#include <cstddef>

#include "detect/common/board_geometry.h"
#include "detect/common/visibility.h"

namespace chequer {
namespace {

/// A cell of which more is covered does not stand out from its neighbours (a guess; measured with .8: 23 of 10,956 ids
/// fewer, and as many wrong ones).
constexpr float kMostCovered = 0.5f;

/// Squared distance of a light to the nearest mix of an ink's with a cover's.
float OffMix(const Eigen::Vector3f& light, const Eigen::Vector3f& ink, const Eigen::Vector3f& cover) {
  const Eigen::Vector3f way = cover - ink, off = light - ink;
  const float length = way.squaredNorm(), share = length > 0 ? off.dot(way) / length : 0;
  return (off - std::clamp(share, 0.0f, kMostCovered) * way).squaredNorm();
}

}  // namespace

CoverMix::CoverMix(const ShownCells& cells, const Eigen::Vector3f& white) : cells_(cells), white_(white) {
  std::array<std::array<int, 2>, 2> counts{};
  ForCells(cells.size, [&](std::size_t cell, int row, int col) {
    if (!IsBorder(cells.size, row, col) || !cells.visibility.Shows(cell) || !cells.visibility.ShowsAround(row, col))
      return;
    inks_[IsDark(row, col)].light[cells.border[cell]] += LightOf(cell);
    ++counts[IsDark(row, col)][cells.border[cell]];
  });
  for (const std::size_t dark : {0u, 1u}) {
    const auto& [plain, saturated] = counts[dark];
    if (plain == 0 || saturated == 0) continue;
    Inks& inks = inks_[dark];
    inks.light[0] /= static_cast<float>(plain);
    inks.light[1] /= static_cast<float>(saturated);
    inks.apart = double{(inks.light[1] - inks.light[0]).squaredNorm()};
  }
}

double CoverMix::LeastLead(int row, int col, double lead) const {
  const Inks& inks = inks_[IsDark(row, col)];
  if (inks.apart == 0) return lead;
  const Eigen::Vector3f light = LightOf(static_cast<std::size_t>(row * cells_.size.cols + col));
  double least = lead;
  ForCells(cells_.size, [&](std::size_t hidden, int at_row, int at_col) {
    if ((at_row != row && at_col != col) || cells_.visibility.Shows(hidden)) return;
    if (cells_.visibility.cells()[hidden] == Hidden::kOutside) return;
    const Eigen::Vector3f cover = LightOf(hidden);
    // Without a cover, this is the lead by the way from one ink to the other.
    const double off = double{OffMix(light, inks.light[0], cover)} - double{OffMix(light, inks.light[1], cover)};
    least = WeakerLead(least, off / (2 * inks.apart));
  });
  return least;
}

}  // namespace chequer
