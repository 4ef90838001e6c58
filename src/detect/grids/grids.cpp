#include "detect/grids/grids.h"

#include <bit>

namespace chequer {
namespace {

/// Largest ratio of opposite sides of a square: perspective gives 1.2 (a guess above it).
constexpr float kMostRatio = 1.6f;

/// How much a step of the lattice may differ from the one before it, as a share of it (a guess).
constexpr float kMostChange = 0.2f;

/// Least contrast all along an edge, as a share of that of its weaker end (a guess).
constexpr float kLeastStep = 0.2f;
/// How far from an edge its sides are looked at, at most: pixels of the plane that shows the corners (a guess).
constexpr float kMostReach = 3;

/// Steps in the lattice along directions 0 … 3.
constexpr std::array<int, 4> kStepX{1, 0, -1, 0};
constexpr std::array<int, 4> kStepY{0, 1, 0, -1};

}  // namespace

void GridLinker::KeepMutual() {
  for (std::size_t i = 0; i < links_.size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const int j = links_[i].corner[k];
      // Without branches, which would be guessed wrong in clutter: that there is none, its own ray tells as well.
      const std::size_t end = static_cast<std::size_t>(std::max(j, 0)), back = links_[i].ray[k];
      // A link that was taken away already from the other end is no longer mutual either.
      const unsigned differs = static_cast<unsigned>(links_[end].corner[back] ^ static_cast<int>(i)) |
                               (links_[end].ray[back] ^ static_cast<unsigned>(k));
      links_[i].corner[k] = j | -static_cast<int>(differs != 0);
    }
}

void GridLinker::KeepEdges(const DetectionPlane& detection, const std::vector<Corner>& corners) {
  probes_.Start(2 * links_.size());
  probed_.clear();
  const Eigen::Vector2f offset = detection.Origin();
  for (std::size_t i = 0; i < links_.size(); ++i) {
    // Each link once.
    unsigned rays = 0;
    for (unsigned k = 0; k < 4; ++k) rays |= static_cast<unsigned>(links_[i].corner[k] > static_cast<int>(i)) << k;
    for (rays &= links_[i].squares; rays != 0; rays &= rays - 1) {
      const int k = std::countr_zero(rays);
      const Corner &a = corners[i],
                   &b = corners[static_cast<std::size_t>(links_[i].corner[static_cast<std::size_t>(k)])];
      // Rays are numbered by growing angle, and light lies on from the even ones.
      probes_.Add({.from = a.position - offset,
                   .along = b.position - a.position,
                   .light_on_left = k % 2 == 0,
                   .most_reach = kMostReach * std::max(a.scale, b.scale),
                   .least_step = kLeastStep * std::min(a.contrast, b.contrast)});
      probed_.push_back({static_cast<int>(i), k});
    }
  }
  const std::span<const std::uint8_t> found = probes_.Look(detection.plane);
  for (std::size_t probe = 0; probe < probed_.size(); ++probe) {
    if (found[probe]) continue;
    const std::size_t k = static_cast<std::size_t>(probed_[probe].ray);
    Links& links = links_[static_cast<std::size_t>(probed_[probe].corner)];
    links_[static_cast<std::size_t>(links.corner[k])].corner[static_cast<std::size_t>(links.ray[k])] = -1;
    links.corner[k] = -1;
  }
}

void GridLinker::KeepSquares(const std::vector<Corner>& corners) {
  // Chance corners link to a board's rim as often as not, but hardly ever close a square with it.
  const auto square_of_length = [&](int a, int b) {
    return (corners[static_cast<std::size_t>(a)].position - corners[static_cast<std::size_t>(b)].position)
        .squaredNorm();
  };
  const auto similar = [&](int a, int b, int c, int d) {
    const float one = square_of_length(a, b), other = square_of_length(c, d);
    constexpr float kMost = kMostRatio * kMostRatio;
    return int{one < kMost * other} & int{other < kMost * one};
  };
  for (int i = 0; i < static_cast<int>(links_.size()); ++i) {
    Links& at = links_[static_cast<std::size_t>(i)];
    unsigned linked = 0;
    for (unsigned k = 0; k < 4; ++k) linked |= (~static_cast<unsigned>(at.corner[k]) >> 31) << k;
    // Rays that are linked, and so is the next; in clutter, there are few.
    for (unsigned rays = linked & (linked >> 1 | linked << 3); rays != 0; rays &= rays - 1) {
      const std::size_t k = static_cast<std::size_t>(std::countr_zero(rays)), next = (k + 1) % 4;
      const int a = at.corner[k], b = at.corner[next];
      // Each square once, as links are mutual: from its first corner.
      if (std::min(a, b) < i) continue;
      // The ray back from a lies opposite to direction k; the one that runs along direction k + 1 is three on from it.
      const std::size_t ray_a = static_cast<std::size_t>(at.ray[k] + 3) % 4,
                        ray_b = static_cast<std::size_t>(at.ray[next] + 1) % 4;
      Links& links_a = links_[static_cast<std::size_t>(a)];
      Links& links_b = links_[static_cast<std::size_t>(b)];
      const int c = links_a.corner[ray_a];
      if (int{c < i} | int{c != links_b.corner[ray_b]}) continue;
      if (!(similar(i, a, b, c) & similar(i, b, a, c))) continue;
      at.squares = static_cast<std::uint8_t>(at.squares | 1u << k | 1u << next);
      links_a.squares = static_cast<std::uint8_t>(links_a.squares | 1u << at.ray[k] | 1u << ray_a);
      links_b.squares = static_cast<std::uint8_t>(links_b.squares | 1u << at.ray[next] | 1u << ray_b);
      Links& links_c = links_[static_cast<std::size_t>(c)];
      links_c.squares =
          static_cast<std::uint8_t>(links_c.squares | 1u << links_a.ray[ray_a] | 1u << links_b.ray[ray_b]);
    }
  }
}

bool GridLinker::StartAt(int seed, const std::vector<Corner>& corners) {
  const Links& links = links_[static_cast<std::size_t>(seed)];
  const Eigen::Vector2f& at = corners[static_cast<std::size_t>(seed)].position;
  std::array<Eigen::Vector2f, 4> step;
  std::array<bool, 4> has{};
  for (std::size_t k = 0; k < 4; ++k) {
    has[k] = links.corner[k] >= 0 && (links.squares >> k & 1);
    if (has[k]) step[k] = corners[static_cast<std::size_t>(links.corner[k])].position - at;
  }
  if (!(has[0] || has[2]) || !(has[1] || has[3])) return false;
  queue_.assign(1, {0, 0, seed});
  basis_.assign(1, {has[0] ? step[0] : -step[2], has[1] ? step[1] : -step[3]});
  state_[static_cast<std::size_t>(seed)] = 1;
  turn_[static_cast<std::size_t>(seed)] = 0;
  return true;
}

void GridLinker::Walk(int seed, const std::vector<Corner>& corners, Grids& out) {
  if (!StartAt(seed, corners)) return;
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
      // Without a link, it leads to where it comes from.
      const int j = links.corner[k] >= 0 && (links.squares >> k & 1) ? links.corner[k] : at.corner;
      if (state_[static_cast<std::size_t>(j)]) continue;
      // The lattice goes on as it came: what hangs on it by chance does not.
      Basis basis = basis_[next];
      Eigen::Vector2f& along = direction % 2 == 0 ? basis.x : basis.y;
      const Eigen::Vector2f step =
          (direction < 2 ? 1.0f : -1.0f) *
          (corners[static_cast<std::size_t>(j)].position - corners[static_cast<std::size_t>(at.corner)].position);
      if ((step - along).squaredNorm() > kMostChange * kMostChange * along.squaredNorm() + 1) continue;
      along = step;
      state_[static_cast<std::size_t>(j)] = 1;
      // The ray that leads back is direction + 2 of the neighbour.
      turn_[static_cast<std::size_t>(j)] = (links.ray[k] - direction + 2) & 3;
      queue_.push_back(
          {at.x + kStepX[static_cast<std::size_t>(direction)], at.y + kStepY[static_cast<std::size_t>(direction)], j});
      basis_.push_back(basis);
    }
  }
  if (static_cast<int>(queue_.size()) < kFewest) return;
  grid.count = static_cast<int>(queue_.size());
  out.corners.insert(out.corners.end(), queue_.begin(), queue_.end());
  out.grids.push_back(grid);
}

WorkMeter GridLinker::work() const {
  WorkMeter work;
  work.Add(WorkStep::kCorner, links_.size());
  work.Add(WorkStep::kNeighbourGroup, search_.groups_looked_at());
  work.Add(WorkStep::kLink, probed_.size());
  return work;
}

void GridLinker::Link(const DetectionPlane& plane, std::vector<Corner>& corners, Grids& out) {
  out.grids.clear();
  out.corners.clear();
  const int right = static_cast<int>(plane.region_px.x()) + plane.plane.width(),
            bottom = static_cast<int>(plane.region_px.y()) + plane.plane.height();
  search_.Build(right + 1, bottom + 1, corners);
  const int count = static_cast<int>(corners.size());
  links_.resize(corners.size());
  search_.ForEach([&](int i) -> NearestCorners& {
    Links& links = links_[static_cast<std::size_t>(i)];
    links.squares = 0;
    return links;
  });
  KeepMutual();
  KeepSquares(corners);
  KeepEdges(plane, corners);
  state_.assign(corners.size(), 0);
  turn_.resize(corners.size());
  for (int i = 0; i < count; ++i)
    if (links_[static_cast<std::size_t>(i)].squares && !state_[static_cast<std::size_t>(i)]) Walk(i, corners, out);
}

}  // namespace chequer
