#include "world/contradiction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace chequer {
namespace {

/// Triples that are tried: all of up to 23 references; so many of more find the majority as surely.
constexpr std::size_t kMostTriples = 2000;
/// Factors nearer to 1 are no explanation worth telling.
constexpr double kLeastScale = 0.002;

using Indices = std::vector<std::size_t>;

std::vector<Tie> Pick(std::span<const Tie> ties, const Indices& which) {
  std::vector<Tie> picked;
  for (const std::size_t i : which) picked.push_back(ties[i]);
  return picked;
}

std::vector<Indices> Triples(std::size_t count) {
  std::vector<Indices> triples;
  if (count * (count - 1) * (count - 2) / 6 <= kMostTriples) {
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = a + 1; b < count; ++b)
        for (std::size_t c = b + 1; c < count; ++c) triples.push_back({a, b, c});
    return triples;
  }
  std::mt19937 random(1);  // the same triples each time: the same answer each time
  std::uniform_int_distribution<std::size_t> any(0, count - 1);
  while (triples.size() < kMostTriples) {
    const Indices triple{any(random), any(random), any(random)};
    if (triple[0] != triple[1] && triple[1] != triple[2] && triple[0] != triple[2]) triples.push_back(triple);
  }
  return triples;
}

Indices Agreeing(std::span<const Tie> ties, const RigidTransform& world_from_camera, double sigma_m) {
  Indices agreeing;
  for (std::size_t i = 0; i < ties.size(); ++i)
    if (Offset(ties[i], world_from_camera).norm() <= OffsetLimit(ties[i], sigma_m)) agreeing.push_back(i);
  return agreeing;
}

/// The most references that agree; empty where another set of as many does too, or no three do.
Indices Majority(std::span<const Tie> ties, double sigma_m) {
  Indices best;
  bool unique = false;
  for (const Indices& triple : Triples(ties.size())) {
    const std::vector<Tie> three = Pick(ties, triple);
    const RigidTransform fit = FitTies(three, sigma_m).world_from_camera;
    if (!AllAgree(three, fit, sigma_m) || IsUpsideDown(three, fit)) continue;
    // Once more from all that agree: three alone see the far ones badly.
    const Indices first = Agreeing(ties, fit, sigma_m);
    const Indices agreeing = Agreeing(ties, FitTies(Pick(ties, first), sigma_m).world_from_camera, sigma_m);
    if (agreeing.size() < best.size() || agreeing == best || agreeing.size() < 3) continue;
    unique = agreeing.size() > best.size();
    best = agreeing;
  }
  return unique ? best : Indices();
}

std::string Place(const Eigen::Vector3d& p) { return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x(), p.y(), p.z()); }

std::string NameOffenders(std::span<const Tie> ties, const Indices& majority, double sigma_m) {
  const RigidTransform fit = FitTies(Pick(ties, majority), sigma_m).world_from_camera;
  std::string text;
  for (std::size_t i = 0; i < ties.size(); ++i) {
    if (std::find(majority.begin(), majority.end(), i) != majority.end()) continue;
    const Eigen::Vector3d offset = Offset(ties[i], fit);
    text += fmt::format(
        "{}reference {} does not fit the other {}: it is said to be at {}, they put it at {}, {:.0f} mm away",
        text.empty() ? "" : "; ", ties[i].said.id, majority.size(), Place(ties[i].said.position_in_world),
        Place(ties[i].said.position_in_world + offset), offset.norm() * 1000);
  }
  return text + "; correct it or leave it out";
}

/// A pair of references, with how far apart they are said to be and are seen.
struct Pair {
  std::size_t a = 0, b = 0;
  double said_m = 0, seen_m = 0, limit_m = 0;
  bool Agrees() const { return std::abs(said_m - seen_m) <= limit_m; }
};

std::vector<Pair> PairsOf(std::span<const Tie> ties, double sigma_m) {
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < ties.size(); ++a)
    for (std::size_t b = a + 1; b < ties.size(); ++b)
      pairs.push_back(
          {a, b, (ties[a].said.position_in_world - ties[b].said.position_in_world).norm(),
           (ties[a].marker.camera_from_marker.translation - ties[b].marker.camera_from_marker.translation).norm(),
           OffsetLimit(ties[a], sigma_m) + OffsetLimit(ties[b], sigma_m)});
  return pairs;
}

std::string Describe(std::span<const Tie> ties, const Pair& pair) {
  return fmt::format("{} and {} are said to be {:.3f} m apart and are seen {:.3f} m apart", ties[pair.a].said.id,
                     ties[pair.b].said.id, pair.said_m, pair.seen_m);
}

/// Where no majority decides: what the distances say.
std::string NamePairs(std::span<const Tie> ties, double sigma_m) {
  const std::vector<Pair> pairs = PairsOf(ties, sigma_m);
  const auto agreeing = std::count_if(pairs.begin(), pairs.end(), [](const Pair& pair) { return pair.Agrees(); });
  if (ties.size() == 3 && agreeing == 1) {
    const Pair& good = *std::find_if(pairs.begin(), pairs.end(), [](const Pair& pair) { return pair.Agrees(); });
    std::string text = fmt::format("reference {} does not fit the other 2", ties[3 - good.a - good.b].said.id);
    for (const Pair& pair : pairs)
      if (!pair.Agrees()) text += "; " + Describe(ties, pair);
    return text + "; correct it or leave it out";
  }
  const auto worst = std::max_element(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
    return std::abs(x.said_m - x.seen_m) < std::abs(y.said_m - y.seen_m);
  });
  return "the references contradict each other, and too few agree to say which is wrong: " + Describe(ties, *worst) +
         (ties.size() < 4 ? "; more references would tell" : "");
}

}  // namespace

bool IsUpsideDown(std::span<const Tie> ties, const RigidTransform& world_from_camera) {
  double up = 0;
  for (const Tie& tie : ties)
    if (tie.said.lies_flat)
      up += (world_from_camera.rotation * (tie.marker.camera_from_marker.rotation * Eigen::Vector3d::UnitZ())).z();
  return up < 0;
}

bool IsMirrored(std::span<const Tie> ties, double sigma_m) {
  if (ties.size() < 3) return false;
  std::vector<Tie> mirrored(ties.begin(), ties.end());
  for (Tie& tie : mirrored) {
    tie.said.position_in_world.y() *= -1;
    if (tie.said.heading_rad) tie.said.heading_rad = -*tie.said.heading_rad;
  }
  const RigidTransform fit = FitTies(mirrored, sigma_m).world_from_camera;
  return AllAgree(mirrored, fit, sigma_m) && !IsUpsideDown(mirrored, fit);
}

std::string ExplainContradiction(std::span<const Tie> ties, double sigma_m) {
  if (IsMirrored(ties, sigma_m))
    return "the list of references is a mirror image of what is seen: seen from above, y must point a quarter turn "
           "counter-clockwise from x; change the sign of every y";
  const double scale = ScaleOf(ties);
  if (ties.size() > 2 && std::abs(scale - 1) > kLeastScale) {
    std::vector<Tie> scaled(ties.begin(), ties.end());
    for (Tie& tie : scaled) tie.marker.camera_from_marker.translation /= scale;
    if (AllAgree(scaled, FitTies(scaled, sigma_m).world_from_camera, sigma_m))
      return fmt::format(
          "all distances as seen are {:.4f} times those in the list: the side of the markers is {:.4f} times what was "
          "said, or the places are in another unit than metres",
          scale, 1 / scale);
  }
  const Indices majority = ties.size() > 3 ? Majority(ties, sigma_m) : Indices();
  return majority.empty() ? NamePairs(ties, sigma_m) : NameOffenders(ties, majority, sigma_m);
}

}  // namespace chequer
