#include "simulate/stream_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "chequer/geometry.h"
#include "simulate/random.h"

namespace chequer {
namespace {

/// The rotation of the camera that moves the middle of its picture by so many pixels right and down.
Eigen::Vector3d SwingOf(const Eigen::Vector2d& move_px, const CameraModel& camera) {
  return {-move_px.y() / camera.fy, move_px.x() / camera.fx, 0};
}

/// A part of a board's side, in from the rim.
Occluder HandFrom(int side, double share) {
  Occluder hand;
  // A little over the rim, so that no bright line is left of it.
  constexpr double kOver = 0.03;
  hand.from = {-kOver, -kOver};
  hand.to = {1 + kOver, 1 + kOver};
  if (side == 0) hand.to.y() = share;
  if (side == 1) hand.from.x() = 1 - share;
  if (side == 2) hand.from.y() = 1 - share;
  if (side == 3) hand.to.x() = share;
  return hand;
}

std::vector<std::optional<Occluder>> LayHands(const Phase& phase, int robots, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::optional<Occluder>> hands(static_cast<std::size_t>(robots));
  const auto count = std::lround(phase.hands_share * robots);
  for (long laid = 0; laid < count;) {
    std::optional<Occluder>& hand = hands[static_cast<std::size_t>(random.Below(robots))];
    if (hand) continue;
    const double share = random.Uniform(phase.occluded_least, phase.occluded_most);
    hand = HandFrom(random.Below(4), share);
    hand->patches = phase.hand_patches;
    hand->seed = random.Bits();
    ++laid;
  }
  return hands;
}

/// An edge that goes to and fro across the middle of the frame, in a direction of the phase's own.
CastShadow ShadowAt(const Phase& phase, const CameraModel& camera, double since_s, std::uint64_t seed) {
  Random random(seed);
  const double direction = random.Uniform(-M_PI, M_PI);
  const double reach = 0.4 * std::hypot(camera.width, camera.height);
  const double phase_of_way = random.Uniform() + phase.shadow_speed_px_s * since_s / (4 * reach);
  const double at = reach * (4 * std::abs(phase_of_way - std::floor(phase_of_way + 0.5)) - 1);
  return {.takes = phase.shadow_takes,
          .direction_rad = direction,
          .through_x = 0.5 * camera.width + at * std::cos(direction),
          .through_y = 0.5 * camera.height + at * std::sin(direction),
          .width_px = phase.shadow_width_px};
}

/// A camera that follows the light by what the frames before showed.
class ExposureControl {
 public:
  explicit ExposureControl(const ScenarioCamera& camera) : camera_(camera) {}

  void Apply(FramePlan& frame) {
    frame.exposure_s = camera_.exposure_ms / 1000;
    if (!camera_.auto_exposure) return;
    const AutoExposure& automatic = *camera_.auto_exposure;
    const double longest = automatic.longest_ms / camera_.exposure_ms;
    const double time = std::min(factor_, longest);
    frame.exposure_s *= time;
    frame.gain = std::min(factor_ / time, automatic.largest_gain);
    const double wanted = std::min(1 / frame.light, longest * automatic.largest_gain);
    const double answered = 1 - std::exp(-1 / (camera_.fps * automatic.lag_s));
    factor_ *= std::pow(wanted / factor_, answered);
  }

  /// A camera that is opened anew begins with the exposure that it is set to.
  void Reset() { factor_ = 1; }

 private:
  const ScenarioCamera& camera_;
  double factor_ = 1;  ///< over the exposure that is set
};

/// Goes through the phases.
class Director {
 public:
  explicit Director(const Scenario& scenario) : scenario_(scenario), exposure_(scenario.camera) {}

  std::vector<FramePlan> Plan() {
    for (std::size_t i = 0; i < scenario_.phases.size(); ++i) PlanPhase(i);
    return std::move(frames_);
  }

 private:
  void PlanPhase(std::size_t index) {
    const Phase& phase = scenario_.phases[index];
    seed_ = DeriveSeed(scenario_.seed, 1000 + index);
    if (phase.kind == PhaseKind::kReopen) exposure_.Reset();
    for (int i = 0; i < phase.frames; ++i) {
      if (phase.kind != PhaseKind::kGap && phase.kind != PhaseKind::kReopen) PlanFrame(index, i);
      if (phase.kind != PhaseKind::kReopen) ++sequence_;
      ++ticks_;
    }
    if (phase.kind == PhaseKind::kTurn) turned_ = TurnOf(phase, phase.frames / scenario_.camera.fps) * turned_;
  }

  void PlanFrame(std::size_t index, int number) {
    const Phase& phase = scenario_.phases[index];
    const ScenarioCamera& camera = scenario_.camera;
    FramePlan frame;
    frame.phase = index;
    frame.time_s = static_cast<double>(ticks_) / camera.fps;
    frame.sequence = sequence_;
    frame.light = phase.light;
    frame.camera_from_level = turned_;
    exposure_.Apply(frame);
    const double since_s = number / camera.fps;
    if (phase.kind == PhaseKind::kFlicker)
      frame.flicker = FlickerOf(phase.flicker_hz, phase.flicker_depth, frame.time_s, frame.exposure_s);
    if (phase.kind == PhaseKind::kTurn) Turn(phase, since_s, frame);
    if (phase.kind == PhaseKind::kKnock) Knock(phase, number, frame);
    if (phase.kind == PhaseKind::kShadow) frame.shadow = ShadowAt(phase, camera.render.camera, since_s, seed_);
    if (phase.kind == PhaseKind::kHands)
      frame.hands = LayHands(phase, scenario_.swarm.robots,
                             DeriveSeed(seed_, static_cast<std::uint64_t>(since_s / phase.hand_s + 1e-9)));
    frames_.push_back(std::move(frame));
  }

  /// Vibration faster than the frames come: each frame sees another straight piece of it.
  void Knock(const Phase& phase, int number, FramePlan& frame) const {
    const CameraModel& camera = scenario_.camera.render.camera;
    Random random(DeriveSeed(seed_, static_cast<std::uint64_t>(number)));
    const double length_px = random.Uniform(0, phase.knock_px);
    const double direction = random.Uniform(-M_PI, M_PI), aside = random.Uniform(-M_PI, M_PI);
    const double off_px = 0.5 * phase.knock_px * std::sqrt(random.Uniform());
    const auto towards = [](double angle) { return Eigen::Vector2d(std::cos(angle), std::sin(angle)); };
    frame.swing_rad = SwingOf(length_px * towards(direction), camera);
    frame.camera_from_level = RotationFromVector(SwingOf(off_px * towards(aside), camera)) * turned_;
  }

  void Turn(const Phase& phase, double since_s, FramePlan& frame) const {
    const Eigen::Quaterniond begin = TurnOf(phase, since_s - 0.5 * frame.exposure_s);
    const Eigen::Quaterniond end = TurnOf(phase, since_s + 0.5 * frame.exposure_s);
    frame.swing_rad = VectorFromRotation(end * begin.conjugate());
    frame.camera_from_level = TurnOf(phase, since_s) * turned_;
  }

  /// How far the camera has turned since the phase began: it starts and stops gently.
  Eigen::Quaterniond TurnOf(const Phase& phase, double since_s) const {
    const double share = phase.turn_s > 0 ? std::clamp(since_s / phase.turn_s, 0.0, 1.0) : 1.0;
    const double smooth = share * share * (3 - 2 * share);
    const double axis = Random(seed_).Uniform(-M_PI, M_PI);
    const Eigen::Vector3d across(std::cos(axis), std::sin(axis), 0);
    return Eigen::Quaterniond(Eigen::AngleAxisd(smooth * phase.turn_tilt_rad, across)) *
           Eigen::Quaterniond(Eigen::AngleAxisd(smooth * phase.turn_rad, Eigen::Vector3d::UnitZ()));
  }

  const Scenario& scenario_;
  ExposureControl exposure_;
  std::vector<FramePlan> frames_;
  std::uint64_t seed_ = 0;      ///< of the phase
  std::uint64_t sequence_ = 0;  ///< of the next frame
  std::uint64_t ticks_ = 0;     ///< frame times since the start
  Eigen::Quaterniond turned_ = Eigen::Quaterniond::Identity();
};

}  // namespace

double FlickerLight::At(double later_s) const { return 1 + amplitude * std::cos(phase_rad + 2 * M_PI * hz * later_s); }

FlickerLight FlickerOf(double hz, double depth, double middle_s, double length_s) {
  // The mean of a cosine over a window is the cosine at its middle times sin(x) / x.
  const double x = M_PI * hz * length_s;
  const double left = x == 0 ? 1 : std::sin(x) / x;
  return {hz, depth * left, 2 * M_PI * hz * middle_s};
}

Eigen::Quaterniond FramePlan::CameraAt(double share) const {
  if (swing_rad.isZero()) return camera_from_level;
  return RotationFromVector((share - 0.5) * swing_rad) * camera_from_level;
}

std::vector<FramePlan> PlanStream(const Scenario& scenario) { return Director(scenario).Plan(); }

}  // namespace chequer
