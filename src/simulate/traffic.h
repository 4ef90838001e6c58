#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

namespace chequer {

/// Discs that drive on a floor.
struct TrafficOptions {
  std::vector<double> radii_m;    ///< one a disc; no two discs ever overlap
  Eigen::AlignedBox2d arena;      ///< of the discs' middles, metres
  Eigen::AlignedBox2d outskirts;  ///< where discs that leave the arena drive; contains it
  double acceleration_m_s2 = 5;   ///< the largest, also of braking
  double turn_rate_rad_s = 5;     ///< the largest, of headings
  /// The largest change of that. A robot's wheels could do more, but the pose at the middle of an exposure is to be the
  /// mean of all the exposure.
  double turn_acceleration_rad_s2 = 20;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// What holds for a time.
struct TrafficRule {
  double seconds = 0;
  double speed_m_s = 0;    ///< the largest
  double leave_share = 0;  ///< of the discs, that leave the arena and come back
};

struct DiscState {
  Eigen::Vector2d position{0, 0};  ///< metres
  Eigen::Vector2d velocity{0, 0};  ///< m/s
  double heading_rad = 0;          ///< turns towards the velocity; not wrapped
  double turn_rate_rad_s = 0;
};

/// Discs that drive to places of their own one after another and never touch. At every step each disc chooses the
/// velocity nearest to the one it wants after which it can still stop without touching where any other disc can stop.
/// Stopping is then always possible, so no two ever overlap.
class Traffic {
 public:
  /// Works out all the time of the rules. Throws std::runtime_error with Check's message, or saying how many discs find
  /// room where not all do.
  Traffic(TrafficOptions options, const std::vector<TrafficRule>& rules, std::uint64_t seed);

  /// At a time since the start. Before it and after the end, what held then.
  DiscState At(std::size_t disc, double time_s) const;

  std::size_t size() const { return options_.radii_m.size(); }

 private:
  TrafficOptions options_;
  std::vector<DiscState> states_;  ///< step by step, all discs of a step together
};

}  // namespace chequer
