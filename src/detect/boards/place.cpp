#include "detect/boards/place.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace chequer {
namespace {

/// Corners of an even lattice lie within so many standard deviations of their middle (2.83 for 5 × 5), with a margin
/// for what is linked to it by chance.
constexpr float kReach = 3.0f;
/// A filled square lies within so many standard deviations of its middle: more lets it grow where it goes on (the first
/// is √6, the others guesses).
constexpr float kAreaReach = 2.45f, kReachOfArea = 3.0f, kLastReachOfArea = 2.6f;
/// From kReachOfArea up to this one, there is at most such a share of the change, by area: 0.1 at most around boards
/// among photographs, 0.1 to 0.4 where ground has its colours.
constexpr float kAroundReach = 4.5f, kMostAround = 0.1f;
/// Standard deviations of a filled square and of its corners, cells: 6 / √12 of a board of six.
constexpr float kAreaCells = 1.73f;
/// Pixels count whose change exceeds this share of the usual change there. Paper, grain and the feet of edges stay
/// below it (a guess).
constexpr float kLeastChange = 0.3f;
/// Of more, no pixel counts: sums of a row are within an int.
constexpr int kMostCounted = 127;
/// What spreads wider, longer, or so many times longer than wide, px, is not followed: it is ground, or a line (1.73
/// times cells of 5.5 px and of 35 px; the slant is a guess).
constexpr float kMostWide = 9.5f, kMostLong = 60, kMostSlant = 14;
/// A place whose spread changes by less of its width has settled (guesses).
constexpr float kSettledPlace = 0.02f;
constexpr int kMostFollowed = 12;

void SetSpread(const Eigen::Matrix2f& covariance, Place& place) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2f> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector2f along = solver.eigenvectors().col(1);
  place.axes << along, Eigen::Vector2f(-along.y(), along.x());
  place.spread = solver.eigenvalues().reverse().cwiseMax(1).cwiseSqrt();
}

/// Sums of pixels' weights, and of their products with the pixels' coordinates from some point.
struct Moments {
  double weight = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
};

/// How much a pixel and those to its right and below differ.
int ChangeAt(const std::uint8_t* pixel, std::ptrdiff_t stride) {
  return (std::abs(pixel[0] - pixel[stride + 1]) + std::abs(pixel[1] - pixel[stride])) / 2;
}

/// Calls visit(row, first, past) for the part of every other row of a plane that lies within `reach` spreads of a
/// place.
template <class Visit>
void ForRows(const BytePlane& plane, const Place& place, float reach, const Visit& visit) {
  const Eigen::Matrix2f scaled = place.axes * (reach * place.spread).cwiseInverse().asDiagonal();
  const Eigen::Matrix2f metric = scaled * scaled.transpose();
  const float half_height = std::sqrt(metric(0, 0) / metric.determinant());
  // Even ones: what is left of a mosaic has a period of two.
  const auto inside = [](float at, int most) { return std::clamp(static_cast<int>(at), 0, most) & ~1; };
  const int most_x = plane.width() - 2, most_y = plane.height() - 2;
  const int past = inside(place.middle.y() + half_height, most_y);
  for (int y = inside(place.middle.y() - half_height, most_y); y < past; y += 2) {
    const float dy = static_cast<float>(y) - place.middle.y(), slope = metric(0, 1) * dy / metric(0, 0);
    const float square = slope * slope - (metric(1, 1) * dy * dy - 1) / metric(0, 0);
    if (square < 0) continue;
    const float half = std::sqrt(square), middle = place.middle.x() - slope;
    visit(y, inside(middle - half, most_x), inside(middle + half, most_x));
  }
}

/// Of what changes by more than `least`, by no more than `most` each; from the place's middle, in whole pixels.
Moments MomentsOfChange(const BytePlane& plane, const Place& place, float reach, int least, int most) {
  Moments moments;
  const int x0 = static_cast<int>(place.middle.x()), y0 = static_cast<int>(place.middle.y());
  ForRows(plane, place, reach, [&](int y, int first, int past) {
    const std::uint8_t* row = plane.row(y);
    int weight = 0, x1 = 0, xx = 0;
    for (int x = first; x < past; x += 2) {
      const int w = std::clamp(ChangeAt(row + x, plane.stride()) - least, 0, most), dx = x - x0;
      weight += w, x1 += w * dx, xx += w * dx * dx;
    }
    const double dy = y - y0;
    moments.weight += weight, moments.x += x1, moments.xx += xx;
    moments.y += dy * weight, moments.xy += dy * x1, moments.yy += dy * dy * weight;
  });
  return moments;
}

/// The place becomes that of moments from its middle, in whole pixels.
void Follow(const Moments& moments, Place& place) {
  const Eigen::Vector2d mean(moments.x / moments.weight, moments.y / moments.weight);
  const Eigen::Matrix2d squares =
      (Eigen::Matrix2d() << moments.xx, moments.xy, moments.xy, moments.yy).finished() / moments.weight;
  place.middle = place.middle.cast<int>().cast<float>() + mean.cast<float>();
  SetSpread((squares - mean * mean.transpose()).cast<float>(), place);
}

/// Whether there is much less change around a place than in it.
bool StandsOut(const BytePlane& plane, const Place& place, int least, int most) {
  const auto weight = [&](float reach) { return MomentsOfChange(plane, place, reach, least, most).weight; };
  const double inside = weight(kAreaReach) / (kAreaReach * kAreaReach),
               around = (weight(kAroundReach) - weight(kReachOfArea)) /
                        (kAroundReach * kAroundReach - kReachOfArea * kReachOfArea);
  return around < kMostAround * inside;
}

/// What pixels that change at all change by around a point, weighted by itself.
int CommonChange(const BytePlane& plane, const Place& place) {
  double sum = 0, squares = 0;
  ForRows(plane, place, kReachOfArea, [&](int y, int first, int past) {
    for (int x = first; x < past; x += 2) {
      const int change = ChangeAt(plane.row(y) + x, plane.stride());
      sum += change, squares += change * change;
    }
  });
  return sum > 0 ? static_cast<int>(squares / sum) : 0;
}

}  // namespace

std::array<Eigen::Vector2f, 4> OutlineAround(const Eigen::Vector2f& middle, const Eigen::Matrix2f& axes,
                                             const Eigen::Vector2f& reach) {
  const Eigen::Vector2f along = axes.col(0) * reach[0], across = axes.col(1) * reach[1];
  return {middle - along - across, middle + along - across, middle + along + across, middle - along + across};
}

Place GatherPoints(std::span<const StrongPoint> points, const Place& place) {
  Eigen::Vector2f sum = Eigen::Vector2f::Zero();
  Eigen::Matrix2f squares = Eigen::Matrix2f::Zero();
  Place found;
  for (const StrongPoint& point : points) {
    if (!IsWithinReach(place, point.position)) continue;
    const Eigen::Vector2f away = point.position - place.middle;
    ++found.count;
    sum += away;
    squares += away * away.transpose();
  }
  if (found.count == 0) return found;
  const float n = static_cast<float>(found.count);
  const Eigen::Vector2f mean = sum / n;
  found.middle = place.middle + mean;
  SetSpread(squares / n - mean * mean.transpose(), found);
  return found;
}

bool IsWithinReach(const Place& place, const Eigen::Vector2f& point) {
  return (place.axes.transpose() * (point - place.middle)).cwiseQuotient(place.spread).squaredNorm() <= kReach * kReach;
}

std::optional<Place> PlaceOfChange(const BytePlane& plane, const Eigen::Vector2f& middle, float radius) {
  Place place;
  place.middle = middle;
  place.spread.setConstant(radius / kReachOfArea);
  const int common = CommonChange(plane, place), least = static_cast<int>(kLeastChange * static_cast<float>(common)),
            most = std::min(common, kMostCounted);
  for (int left = kMostFollowed; left > 0;) {
    const Eigen::Vector2f before = place.spread;
    const Moments moments = MomentsOfChange(plane, place, left > 1 ? kReachOfArea : kLastReachOfArea, least, most);
    if (!(moments.weight > 0)) return std::nullopt;
    Follow(moments, place);
    if (place.spread[1] > kMostWide || place.spread[0] > std::min(kMostLong, kMostSlant * place.spread[1]))
      return std::nullopt;
    // Once it has settled, a last step leaves out more of what lies around.
    const bool settled = (place.spread - before).cwiseAbs().maxCoeff() < kSettledPlace * place.spread[1];
    left = settled && left > 2 ? 1 : left - 1;
  }
  if (!StandsOut(plane, place, least, most)) return std::nullopt;
  // A change between pixels lies in the middle of four.
  place.middle.array() += 0.5f;
  place.spread *= kSpreadCells / kAreaCells;
  return place;
}

}  // namespace chequer
