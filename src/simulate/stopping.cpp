#include "simulate/stopping.h"

#include <algorithm>

namespace chequer {
namespace {

using Eigen::Vector2d;

/// The smallest distance from the origin of a straight way between two points.
double NearestOf(const Vector2d& from, const Vector2d& to) {
  const Vector2d way = to - from;
  const double length2 = way.squaredNorm();
  const double at = length2 > 0 ? std::clamp(-from.dot(way) / length2, 0.0, 1.0) : 0.0;
  return (from + at * way).norm();
}

}  // namespace

DiscState Braked(const DiscState& state, double braking_m_s2, double time_s) {
  const double speed = state.velocity.norm();
  DiscState braked = state;
  if (speed == 0) return braked;
  const double t = std::min(time_s, speed / braking_m_s2);
  const double left = std::max(0.0, speed - braking_m_s2 * t);
  braked.position += state.velocity * (t * 0.5 * (speed + left) / speed);
  braked.velocity *= left / speed;
  return braked;
}

Vector2d StopOf(const DiscState& state, double braking_m_s2) {
  return state.position + state.velocity * (0.5 * state.velocity.norm() / braking_m_s2);
}

bool StopApart(const DiscState& a, const DiscState& b, double braking_m_s2, double apart_m) {
  const double speed_a = a.velocity.norm(), speed_b = b.velocity.norm();
  const Vector2d between = b.position - a.position;
  const double ways = 0.5 * (speed_a * speed_a + speed_b * speed_b) / braking_m_s2;
  if (between.norm() > apart_m + ways) return true;
  // Pieces so short that a braking disc is within a millimetre of a straight way.
  constexpr int kPieces = 8;
  const double longest_s = std::max(speed_a, speed_b) / braking_m_s2;
  Vector2d from = between;
  if (longest_s == 0) return between.norm() > apart_m;
  for (int i = 1; i <= kPieces; ++i) {
    const double t = longest_s * i / kPieces;
    const Vector2d to = Braked(b, braking_m_s2, t).position - Braked(a, braking_m_s2, t).position;
    if (NearestOf(from, to) <= apart_m) return false;
    from = to;
  }
  return true;
}

}  // namespace chequer
