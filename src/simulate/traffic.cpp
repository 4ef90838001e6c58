#include "simulate/traffic.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "simulate/random.h"
#include "simulate/stopping.h"

namespace chequer {
namespace {

using Eigen::Vector2d;

constexpr double kStepS = 1.0 / 120;  ///< as short as an exposure
constexpr double kReachedM = 0.05;    ///< as near to its goal a disc wants another one
constexpr double kPatienceS = 0.3;    ///< for so long a disc stands before it wants another goal
constexpr double kStandsM_S = 0.02;

/// What a disc wants, and what it was when the last step began.
struct Driver {
  Vector2d goal{0, 0};
  double pace = 1;  ///< share of the largest speed
  double stood_s = 0;
  bool may_leave = false;
};

/// The steps of a Traffic.
class Simulation {
 public:
  Simulation(const TrafficOptions& options, std::uint64_t seed) : options_(options), random_(seed) { Place(); }

  void Follow(const TrafficRule& rule) {
    rule_ = rule;
    for (std::size_t i = 0; i < drivers_.size(); ++i) {
      drivers_[i].may_leave = random_.Uniform() < rule.leave_share;
      ChooseGoal(i);
    }
  }

  void Step() {
    moved_.clear();
    // Those that have not chosen yet can brake at least.
    for (const DiscState& state : now_) moved_.push_back(Towards(state, {0, 0}));
    for (std::size_t i = 0; i < now_.size(); ++i) moved_[i] = Choose(i);
    for (std::size_t i = 0; i < now_.size(); ++i) Settle(i);
    std::swap(now_, moved_);
  }

  const std::vector<DiscState>& now() const { return now_; }

 private:
  Vector2d Within(const Eigen::AlignedBox2d& box) {
    const double x = random_.Uniform(box.min().x(), box.max().x());
    return {x, random_.Uniform(box.min().y(), box.max().y())};
  }

  void Place() {
    // So many darts find nearly every gap at the densities in which discs can still drive.
    constexpr int kDarts = 5000;
    for (std::size_t i = 0; i < options_.radii_m.size(); ++i) {
      bool found = false;
      for (int dart = 0; dart < kDarts && !found; ++dart) {
        const Vector2d place = Within(options_.arena);
        found = true;
        for (std::size_t j = 0; j < i; ++j)
          found &= (now_[j].position - place).norm() > options_.radii_m[i] + options_.radii_m[j];
        if (found) now_.push_back({.position = place, .heading_rad = random_.Uniform(-M_PI, M_PI)});
      }
      if (!found)
        throw std::runtime_error(std::to_string(options_.radii_m.size()) + " robots find no room in the arena; " +
                                 std::to_string(i) + " of them do");
    }
    drivers_.resize(now_.size());
  }

  /// Where a disc may stop: one that is outside already comes back by itself.
  const Eigen::AlignedBox2d& BoxOf(std::size_t i) const {
    const bool outside = !options_.arena.contains(now_[i].position);
    return outside || drivers_[i].may_leave ? options_.outskirts : options_.arena;
  }

  void ChooseGoal(std::size_t i) {
    Driver& driver = drivers_[i];
    const bool inside = options_.arena.contains(now_[i].position);
    const double far = 0.4 * options_.arena.sizes().minCoeff();
    // Leavers go out and come back by turns; the others take far goals, as a short way leaves no time to be fast.
    for (int attempt = 0; attempt < 50; ++attempt) {
      driver.goal = Within(driver.may_leave && inside ? options_.outskirts : options_.arena);
      const bool wanted = driver.may_leave && inside ? !options_.arena.contains(driver.goal)
                                                     : (driver.goal - now_[i].position).norm() > far;
      if (wanted) break;
    }
    driver.pace = random_.Uniform(0.6, 1);
    driver.stood_s = 0;
  }

  Vector2d WantedVelocity(std::size_t i) const {
    const Vector2d way = drivers_[i].goal - now_[i].position;
    const double distance = way.norm();
    if (distance < 1e-6) return {0, 0};
    const double braking = std::sqrt(2 * 0.8 * options_.acceleration_m_s2 * distance);
    return way / distance * std::min(drivers_[i].pace * rule_.speed_m_s, braking);
  }

  /// The state after a step towards a velocity, as far as the acceleration allows.
  DiscState Towards(const DiscState& from, const Vector2d& velocity) const {
    const double most = options_.acceleration_m_s2 * kStepS;
    const Vector2d change = velocity - from.velocity;
    const double norm = change.norm();
    DiscState to = from;
    to.velocity += norm > most ? Vector2d(change * (most / norm)) : change;
    to.position += 0.5 * kStepS * (from.velocity + to.velocity);
    return to;
  }

  bool IsSafe(std::size_t i, const DiscState& state) const {
    if (!BoxOf(i).contains(StopOf(state, options_.acceleration_m_s2))) return false;
    for (std::size_t j = 0; j < moved_.size(); ++j) {
      if (j == i) continue;
      const double apart = options_.radii_m[i] + options_.radii_m[j];
      if (!StopApart(state, moved_[j], options_.acceleration_m_s2, apart)) return false;
    }
    return true;
  }

  DiscState Choose(std::size_t i) const {
    const Vector2d wanted = WantedVelocity(i);
    // From what is wanted to what gives way, to both sides alike.
    constexpr std::pair<double, double> kWays[] = {{1, 0},   {0.5, 0},  {1, 0.5}, {1, -0.5}, {1, 1},     {1, -1},
                                                   {0.5, 1}, {0.5, -1}, {1, 1.6}, {1, -1.6}, {0.6, 2.2}, {0.6, -2.2}};
    for (const auto& [share, turn] : kWays) {
      const DiscState state = Towards(now_[i], Eigen::Rotation2Dd(turn) * (share * wanted));
      if (IsSafe(i, state)) return state;
    }
    return Towards(now_[i], {0, 0});
  }

  /// The rate at which a disc wants to turn into its way: so that it can stop turning in time, slow ones slowly.
  double WantedTurn(const DiscState& state) const {
    const double speed = state.velocity.norm();
    if (speed < kStandsM_S) return 0;
    constexpr double kAnswerPerS = 6;
    const double off = std::remainder(std::atan2(state.velocity.y(), state.velocity.x()) - state.heading_rad, 2 * M_PI);
    const double rate = std::min({std::sqrt(options_.turn_acceleration_rad_s2 * std::abs(off)),
                                  kAnswerPerS * std::abs(off), options_.turn_rate_rad_s * std::min(1.0, speed / 0.2)});
    return std::copysign(rate, off);
  }

  /// The heading, and whether another goal is due.
  void Settle(std::size_t i) {
    DiscState& state = moved_[i];
    Driver& driver = drivers_[i];
    const double before = state.turn_rate_rad_s, most = options_.turn_acceleration_rad_s2 * kStepS;
    state.turn_rate_rad_s += std::clamp(WantedTurn(state) - before, -most, most);
    state.heading_rad += 0.5 * kStepS * (before + state.turn_rate_rad_s);
    driver.stood_s = state.velocity.norm() < kStandsM_S ? driver.stood_s + kStepS : 0;
    if ((driver.goal - state.position).norm() < kReachedM || driver.stood_s > kPatienceS) ChooseGoal(i);
  }

  const TrafficOptions& options_;
  Random random_;
  TrafficRule rule_;
  std::vector<DiscState> now_;
  std::vector<DiscState> moved_;  ///< at the end of the step; of discs that have not chosen yet, braked
  std::vector<Driver> drivers_;
};

}  // namespace

std::string TrafficOptions::Check() const {
  for (const double radius : radii_m)
    if (!(radius > 0)) return "a robot's radius must be above 0";
  if (arena.isEmpty() || arena.sizes().minCoeff() <= 0) return "the robots' arena leaves them no room";
  if (!outskirts.contains(arena)) return "the outskirts must contain the arena";
  if (!(acceleration_m_s2 > 0)) return "acceleration must be above 0";
  return {};
}

Traffic::Traffic(TrafficOptions options, const std::vector<TrafficRule>& rules, std::uint64_t seed)
    : options_(std::move(options)) {
  if (std::string wrong = options_.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  Simulation simulation(options_, seed);
  const auto keep = [&] { states_.insert(states_.end(), simulation.now().begin(), simulation.now().end()); };
  keep();
  double end_s = 0, time_s = 0;
  for (const TrafficRule& rule : rules) {
    simulation.Follow(rule);
    for (end_s += rule.seconds; time_s < end_s; time_s += kStepS) {
      simulation.Step();
      keep();
    }
  }
}

DiscState Traffic::At(std::size_t disc, double time_s) const {
  const std::size_t steps = states_.size() / size() - 1;
  const double at = std::clamp(time_s / kStepS, 0.0, static_cast<double>(steps));
  const auto step = std::min(static_cast<std::size_t>(at), steps == 0 ? 0 : steps - 1);
  const DiscState& from = states_[step * size() + disc];
  if (steps == 0) return from;
  const DiscState& to = states_[(step + 1) * size() + disc];
  const double share = at - static_cast<double>(step), s = share * kStepS;
  // Accelerations are constant within a step.
  const Vector2d change = to.velocity - from.velocity;
  const double turn_change = to.turn_rate_rad_s - from.turn_rate_rad_s;
  return {.position = from.position + s * from.velocity + 0.5 * s * share * change,
          .velocity = from.velocity + share * change,
          .heading_rad = from.heading_rad + s * from.turn_rate_rad_s + 0.5 * s * share * turn_change,
          .turn_rate_rad_s = from.turn_rate_rad_s + share * turn_change};
}

}  // namespace chequer
