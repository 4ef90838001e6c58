#include "detect/grids.h"

#include <cmath>
#include <limits>

namespace chequer {
namespace {

/// Cosine of how far the neighbour may lie off the ray (25 degrees), at both ends.
constexpr float kLeastCosine = 0.906f;
/// How much more a candidate that lies off the ray has to be nearer.
constexpr float kOffAxisCost = 3;

/// Cells are empty but for noise: a neighbour is among the nearest corners, or there is none. In clutter, this bounds
/// the work.
constexpr int kMostConsidered = 40;

/// How much opposite sides of a square may differ: perspective of cells makes 1.2.
constexpr float kMostRatio = 1.6f;

/// Steps in the lattice along directions 0 … 3.
constexpr std::array<int, 4> kStepX{1, 0, -1, 0};
constexpr std::array<int, 4> kStepY{0, 1, 0, -1};

/// Whether the image shows an edge all along from a to b, light on the side that `lighter` (unit normal) points to.
bool EdgeIsThere(const DetectionPlane& plane, const Corner& a, const Corner& b, const Eigen::Vector2f& lighter) {
  const Eigen::Vector2f along = b.position - a.position;
  const float length = along.norm();
  const float reach = std::min(0.25f * length, 3.0f * std::max(a.scale, b.scale));
  const float least = 0.2f * std::min(a.contrast, b.contrast);
  const Eigen::Vector2f origin = a.position - Eigen::Vector2f::Constant(plane.offset_px);
  const Eigen::Vector2f limit(static_cast<float>(plane.plane.width() - 1),
                              static_cast<float>(plane.plane.height() - 1));
  for (const float part : {0.3f, 0.5f, 0.7f}) {
    const Eigen::Vector2f p = origin + part * along;
    const Eigen::Vector2f light = (p + reach * lighter).cwiseMax(0).cwiseMin(limit);
    const Eigen::Vector2f dark = (p - reach * lighter).cwiseMax(0).cwiseMin(limit);
    if (plane.plane.Bilinear(light.x(), light.y()) - plane.plane.Bilinear(dark.x(), dark.y()) < least) return false;
  }
  return true;
}

}  // namespace

void GridLinker::DropCoarserTwins(std::vector<Corner>& corners, int width, int height) {
  // Corners come level by level, so a twin of a finer level stands before.
  const int count = static_cast<int>(corners.size());
  buckets_.Build(width, height, count, [&](int i) { return corners[static_cast<std::size_t>(i)].position; });
  std::size_t kept = 0;
  state_.assign(corners.size(), 1);
  for (int i = 0; i < count; ++i) {
    const Corner& corner = corners[static_cast<std::size_t>(i)];
    if (corner.scale == 1) continue;
    const float radius = 2 * corner.scale;
    const int last_row = buckets_.Row(corner.position.y() + radius);
    const int first_col = buckets_.Col(corner.position.x() - radius),
              last_col = buckets_.Col(corner.position.x() + radius);
    for (int row = buckets_.Row(corner.position.y() - radius); row <= last_row && state_[static_cast<std::size_t>(i)];
         ++row)
      for (const int j : buckets_.InRow(row, first_col, last_col)) {
        const Corner& other = corners[static_cast<std::size_t>(j)];
        if (j >= i || !state_[static_cast<std::size_t>(j)] || other.scale == corner.scale) continue;
        if ((other.position - corner.position).squaredNorm() > radius * radius) continue;
        state_[static_cast<std::size_t>(i)] = 0;
        break;
      }
  }
  for (int i = 0; i < count; ++i)
    if (state_[static_cast<std::size_t>(i)]) corners[kept++] = corners[static_cast<std::size_t>(i)];
  corners.resize(kept);
}

void GridLinker::FindNearest(const std::vector<Corner>& corners, int index) {
  const Corner& from = corners[static_cast<std::size_t>(index)];
  Links& links = links_[static_cast<std::size_t>(index)];
  std::array<float, 4> best;
  best.fill(std::numeric_limits<float>::infinity());

  int considered = 0;
  const auto consider = [&](int j) {
    if (j == index) return;
    ++considered;
    const Corner& to = corners[static_cast<std::size_t>(j)];
    const Eigen::Vector2f step = to.position - from.position;
    const float distance = step.norm();
    if (distance < 2 || distance > kLongest) return;
    for (std::size_t k = 0; k < 4; ++k) {
      const float cosine = from.rays[k].dot(step);
      if (cosine < kLeastCosine * distance) continue;
      const float cost = distance + kOffAxisCost * (distance - cosine);
      if (cost >= best[k]) return;
      // Neighbouring corners swap light and dark: an edge that leaves one by a ray of one kind comes in by the other.
      for (std::size_t back = 1 - k % 2; back < 4; back += 2)
        if (-to.rays[back].dot(step) > kLeastCosine * distance) {
          best[k] = cost;
          links.corner[k] = j;
          links.ray[k] = static_cast<int>(back);
        }
      return;
    }
  };

  const int col = buckets_.Col(from.position.x()), row = buckets_.Row(from.position.y());
  const int reach = static_cast<int>(kLongest) >> Buckets::kShift;
  for (int ring = 0; ring <= reach; ++ring) {
    const int first_col = std::max(col - ring, 0), last_col = std::min(col + ring, buckets_.cols() - 1);
    for (int r = std::max(row - ring, 0); r <= std::min(row + ring, buckets_.rows() - 1); ++r) {
      if (r == row - ring || r == row + ring) {
        for (const int j : buckets_.InRow(r, first_col, last_col)) consider(j);
        continue;
      }
      if (col - ring >= 0)
        for (const int j : buckets_.InRow(r, col - ring, col - ring)) consider(j);
      if (col + ring < buckets_.cols())
        for (const int j : buckets_.InRow(r, col + ring, col + ring)) consider(j);
    }
    // Done when no ray can find anything nearer, or when a neighbourhood many times as large as the nearest link is
    // searched: a cell's sides do not differ that much.
    const float searched = static_cast<float>(ring << Buckets::kShift);
    const float nearest = *std::min_element(best.begin(), best.end());
    const float farthest = *std::max_element(best.begin(), best.end());
    if (searched >= farthest || searched >= 5 * nearest + 8 || considered >= kMostConsidered) break;
  }
}

void GridLinker::KeepMutual(const DetectionPlane& plane, const std::vector<Corner>& corners) {
  for (std::size_t i = 0; i < links_.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const int j = links_[i].corner[k];
      if (j < 0) continue;
      const std::size_t back = static_cast<std::size_t>(links_[i].ray[k]);
      Links& other = links_[static_cast<std::size_t>(j)];
      const bool mutual = other.corner[back] == static_cast<int>(i) && other.ray[back] == static_cast<int>(k);
      if (!mutual) {
        links_[i].corner[k] = -1;
        continue;
      }
      if (j < static_cast<int>(i)) continue;  // looked at from the other end
      const Eigen::Vector2f along = corners[static_cast<std::size_t>(j)].position - corners[i].position;
      Eigen::Vector2f lighter(-along.y(), along.x());  // by growing angle
      lighter.normalize();
      if (k % 2 == 1) lighter = -lighter;
      if (!EdgeIsThere(plane, corners[i], corners[static_cast<std::size_t>(j)], lighter)) {
        links_[i].corner[k] = -1;
        other.corner[back] = -1;
      }
    }
}

void GridLinker::KeepSquares(const std::vector<Corner>& corners) {
  // Chance corners link to a board's rim as often as not, but hardly ever close a square with it.
  const auto length = [&](int a, int b) {
    return (corners[static_cast<std::size_t>(a)].position - corners[static_cast<std::size_t>(b)].position).norm();
  };
  const auto similar = [](float a, float b) { return a < kMostRatio * b && b < kMostRatio * a; };
  for (int i = 0; i < static_cast<int>(links_.size()); ++i) {
    Links& at = links_[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t next = (k + 1) % 4;
      const int a = at.corner[k], b = at.corner[next];
      if (a < 0 || b < 0) continue;
      // The ray back from a lies opposite to direction k; the one that runs along direction k + 1 is three on from it.
      const std::size_t ray_a = static_cast<std::size_t>(at.ray[k] + 3) % 4,
                        ray_b = static_cast<std::size_t>(at.ray[next] + 1) % 4;
      Links& links_a = links_[static_cast<std::size_t>(a)];
      Links& links_b = links_[static_cast<std::size_t>(b)];
      const int c = links_a.corner[ray_a];
      if (c < 0 || c != links_b.corner[ray_b]) continue;
      if (!similar(length(i, a), length(b, c)) || !similar(length(i, b), length(a, c))) continue;
      at.squares = static_cast<std::uint8_t>(at.squares | 1u << k | 1u << next);
      links_a.squares = static_cast<std::uint8_t>(links_a.squares | 1u << at.ray[k] | 1u << ray_a);
      links_b.squares = static_cast<std::uint8_t>(links_b.squares | 1u << at.ray[next] | 1u << ray_b);
      Links& links_c = links_[static_cast<std::size_t>(c)];
      links_c.squares =
          static_cast<std::uint8_t>(links_c.squares | 1u << links_a.ray[ray_a] | 1u << links_b.ray[ray_b]);
    }
  }
}

void GridLinker::Walk(int seed, Grids& out) {
  queue_.clear();
  queue_.push_back({0, 0, seed});
  state_[static_cast<std::size_t>(seed)] = 1;
  turn_[static_cast<std::size_t>(seed)] = 0;
  Grid grid{.first = static_cast<int>(out.corners.size())};
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const LatticeCorner at = queue_[next];
    grid.min_x = std::min(grid.min_x, at.x);
    grid.max_x = std::max(grid.max_x, at.x);
    grid.min_y = std::min(grid.min_y, at.y);
    grid.max_y = std::max(grid.max_y, at.y);
    const Links& links = links_[static_cast<std::size_t>(at.corner)];
    for (int direction = 0; direction < 4; ++direction) {
      const std::size_t k = static_cast<std::size_t>((turn_[static_cast<std::size_t>(at.corner)] + direction) % 4);
      const int j = links.corner[k];
      if (j < 0 || !(links.squares >> k & 1) || state_[static_cast<std::size_t>(j)]) continue;
      state_[static_cast<std::size_t>(j)] = 1;
      // The ray that leads back is direction + 2 of the neighbour.
      turn_[static_cast<std::size_t>(j)] = (links.ray[k] - direction + 2) & 3;
      queue_.push_back(
          {at.x + kStepX[static_cast<std::size_t>(direction)], at.y + kStepY[static_cast<std::size_t>(direction)], j});
    }
  }
  if (static_cast<int>(queue_.size()) < kFewest) return;
  grid.count = static_cast<int>(queue_.size());
  out.corners.insert(out.corners.end(), queue_.begin(), queue_.end());
  out.grids.push_back(grid);
}

void GridLinker::Link(const DetectionPlane& plane, std::vector<Corner>& corners, Grids& out) {
  out.grids.clear();
  out.corners.clear();
  const int width = plane.plane.width() + 1, height = plane.plane.height() + 1;
  DropCoarserTwins(corners, width, height);
  const int count = static_cast<int>(corners.size());
  buckets_.Build(width, height, count, [&](int i) { return corners[static_cast<std::size_t>(i)].position; });
  links_.assign(corners.size(), Links{});
  for (int i = 0; i < count; ++i) FindNearest(corners, i);
  KeepMutual(plane, corners);
  KeepSquares(corners);
  state_.assign(corners.size(), 0);
  turn_.resize(corners.size());
  for (int i = 0; i < count; ++i)
    if (!state_[static_cast<std::size_t>(i)]) Walk(i, out);
}

}  // namespace chequer
