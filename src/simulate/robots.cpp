#include "simulate/robots.h"

#include <algorithm>
#include <cmath>

#include "simulate/random.h"

namespace chequer {
namespace {

/// What of the floor a level camera sees for sure, with so many pixels left on all sides.
Eigen::AlignedBox2d SeenFloor(const CameraModel& camera, double distance_m, double rim_px) {
  Eigen::AlignedBox2d seen(Eigen::Vector2d(-1e9, -1e9), Eigen::Vector2d(1e9, 1e9));
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = rim_px + (camera.width - 1 - 2 * rim_px) * i / kSteps;
    const double y = rim_px + (camera.height - 1 - 2 * rim_px) * i / kSteps;
    // Where a lens model ends before the image does, the floor ends there too.
    if (const auto left = camera.Undistort({rim_px, y})) seen.min().x() = std::max(seen.min().x(), left->x());
    if (const auto top = camera.Undistort({x, rim_px})) seen.min().y() = std::max(seen.min().y(), top->y());
    if (const auto right = camera.Undistort({camera.width - 1 - rim_px, y}))
      seen.max().x() = std::min(seen.max().x(), right->x());
    if (const auto bottom = camera.Undistort({x, camera.height - 1 - rim_px}))
      seen.max().y() = std::min(seen.max().y(), bottom->y());
  }
  return {seen.min() * distance_m, seen.max() * distance_m};
}

Eigen::AlignedBox2d Grown(const Eigen::AlignedBox2d& box, double by_m) {
  return {box.min().array() - by_m, box.max().array() + by_m};
}

/// The circle about a board, with its share of the gap.
double RadiusOf(const SceneMarker& marker, double gap_m) {
  const double rim = 2 * std::max(marker.margin_cells, marker.ink_spread_cells);
  return 0.5 * std::hypot(marker.board.rows + rim, marker.board.cols + rim) * marker.CellSize() + 0.5 * gap_m;
}

/// Pixels that a board may be moved by when the camera is shaken, and a few more.
double RimPx(const Scenario& scenario) {
  double rim = 2;
  for (const Phase& phase : scenario.phases)
    // Near the rim a turn of the camera moves more than in the middle: of a wide lens by half as much again.
    if (phase.kind == PhaseKind::kKnock) rim = std::max(rim, 2 + 1.5 * phase.knock_px);
  return rim;
}

std::vector<TrafficRule> RulesOf(const Scenario& scenario) {
  std::vector<TrafficRule> rules;
  for (const Phase& phase : scenario.phases)
    rules.push_back({.seconds = phase.frames / scenario.camera.fps,
                     .speed_m_s = phase.speed_m_s,
                     .leave_share = phase.kind == PhaseKind::kTraffic ? phase.leave_share : 0});
  return rules;
}

TrafficOptions OptionsOf(const Scenario& scenario, const std::vector<double>& radii_m) {
  const double largest = *std::max_element(radii_m.begin(), radii_m.end());
  const CameraModel& camera = scenario.camera.render.camera;
  const Eigen::AlignedBox2d seen = SeenFloor(camera, scenario.camera.distance_m, RimPx(scenario));
  TrafficOptions options;
  options.radii_m = radii_m;
  options.acceleration_m_s2 = scenario.swarm.acceleration_m_s2;
  options.arena = Grown(seen, -largest);
  if (const auto& arena = scenario.swarm.arena_m) options.arena = Grown({-0.5 * *arena, 0.5 * *arena}, -largest);
  options.outskirts = Grown(seen, 1.5 * largest).merged(options.arena);
  return options;
}

}  // namespace

std::vector<Robots::Body> Robots::MakeBodies(const Scenario& scenario) {
  const ScenarioSwarm& swarm = scenario.swarm;
  const MarkerCode code(swarm.size, swarm.variant);
  Random random(DeriveSeed(scenario.seed, 2));
  std::vector<Body> bodies;
  for (int i = 0; i < swarm.robots; ++i) {
    Body body;
    body.marker.board = MakeBoard(code, swarm.first_id + static_cast<std::uint64_t>(i));
    body.marker.side_m = swarm.side_m;
    body.marker.inks = swarm.inks;
    body.marker.margin_cells = swarm.margin_cells;
    body.marker.ink_spread_cells = swarm.ink_spread_cells;
    Print(swarm.print, DeriveSeed(DeriveSeed(scenario.seed, 4), static_cast<std::uint64_t>(i)), body.marker);
    body.depth_m = scenario.camera.distance_m - random.Uniform(0, swarm.height_spread_m);
    body.tilt_rad = random.Uniform(0, swarm.max_tilt_rad);
    body.tilt_axis_rad = random.Uniform(-M_PI, M_PI);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

Robots::Robots(const Scenario& scenario)
    : distance_m_(scenario.camera.distance_m), bodies_(MakeBodies(scenario)), traffic_([&] {
        std::vector<double> radii_m;
        // A nearer board hides more of the floor.
        for (const Body& body : bodies_)
          radii_m.push_back(RadiusOf(body.marker, scenario.swarm.gap_m) * distance_m_ / body.depth_m);
        return Traffic(OptionsOf(scenario, radii_m), RulesOf(scenario), DeriveSeed(scenario.seed, 3));
      }()) {}

RigidTransform Robots::PoseAt(std::size_t robot, double time_s) const {
  const Body& body = bodies_[robot];
  const DiscState state = traffic_.At(robot, time_s);
  const Eigen::Vector2d place = state.position * (body.depth_m / distance_m_);
  return FacingPose({place.x(), place.y(), body.depth_m}, state.heading_rad, body.tilt_rad,
                    state.heading_rad + body.tilt_axis_rad);
}

}  // namespace chequer
