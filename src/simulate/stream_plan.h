#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "simulate/cast_shadow.h"
#include "simulate/scenario.h"
#include "simulate/scene.h"

namespace chequer {

/// The light of lamps that flicker, as an exposure averages it.
struct FlickerLight {
  double hz = 0;
  double amplitude = 0;  ///< of the averaged light, about 1
  double phase_rad = 0;  ///< at the middle of the exposure of the frame's middle row

  /// Of an exposure whose middle is so much later than the middle row's.
  double At(double later_s) const;
};

/// `depth` of the light comes and goes `hz` times a second; an exposure from middle − length/2 to middle + length/2
/// sees its mean.
FlickerLight FlickerOf(double hz, double depth, double middle_s, double length_s);

/// A frame of a stream, before anything is drawn.
struct FramePlan {
  std::size_t phase = 0;       ///< index in the scenario
  double time_s = 0;           ///< of the middle of the exposure, since the stream began
  std::uint64_t sequence = 0;  ///< lost frames count, a camera that is closed does not
  double exposure_s = 0;
  double light = 1;  ///< of the lamps, without flicker
  double gain = 1;
  FlickerLight flicker;
  CastShadow shadow;
  std::vector<std::optional<Occluder>> hands;  ///< one a robot, or empty
  /// Turns what a level camera sees into what this one sees, at the middle of the exposure.
  Eigen::Quaterniond camera_from_level = Eigen::Quaterniond::Identity();
  /// By which the camera turns from the begin to the end of the exposure, about its own axes, radians.
  Eigen::Vector3d swing_rad{0, 0, 0};

  /// Of the camera at a share of the exposure, 0..1.
  Eigen::Quaterniond CameraAt(double share) const;
};

/// All frames of a scenario. Hangs on the scenario and its seed alone.
std::vector<FramePlan> PlanStream(const Scenario& scenario);

}  // namespace chequer
