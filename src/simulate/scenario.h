#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "chequer/marker.h"
#include "simulate/print_quality.h"
#include "simulate/render.h"

namespace chequer {

/// What a phase of a stream is about.
enum class PhaseKind : std::uint8_t {
  kCalm,     ///< nothing else happens
  kDark,     ///< a share of the light
  kBright,   ///< more light than the exposure is meant for
  kFlicker,  ///< lamps flicker against the shutter
  kKnock,    ///< the camera is shaken
  kFast,     ///< robots drive fast
  kHands,    ///< hands occlude parts of boards
  kShadow,   ///< the edge of a shadow wanders over the floor
  kTraffic,  ///< robots leave the frame and come back
  kTurn,     ///< the camera is turned and stays so
  kGap,      ///< frames are lost
  kReopen,   ///< the camera is closed for a time and opened again
};

inline constexpr std::array<std::pair<std::string_view, PhaseKind>, 12> kPhaseKinds{{
    {"calm", PhaseKind::kCalm},
    {"dark", PhaseKind::kDark},
    {"bright", PhaseKind::kBright},
    {"flicker", PhaseKind::kFlicker},
    {"knock", PhaseKind::kKnock},
    {"fast", PhaseKind::kFast},
    {"hands", PhaseKind::kHands},
    {"shadow", PhaseKind::kShadow},
    {"traffic", PhaseKind::kTraffic},
    {"turn", PhaseKind::kTurn},
    {"gap", PhaseKind::kGap},
    {"reopen", PhaseKind::kReopen},
}};

/// How a camera follows the light by itself: exposure first, gain where that does not suffice.
struct AutoExposure {
  double lag_s = 0.3;       ///< time constant of its answer
  double longest_ms = 10;   ///< exposure
  double largest_gain = 8;  ///< makes noise: a photosite holds fewer electrons at full scale
};

struct ScenarioCamera {
  RenderOptions render;  ///< its camera model, blur, lighting, sensor and format
  Background background;
  double fps = 60;
  double exposure_ms = 4;  ///< boards move during it
  double distance_m = 3;   ///< of the floor
  std::optional<AutoExposure> auto_exposure;
};

/// Robots on a floor that the camera looks straight down on.
struct ScenarioSwarm {
  int robots = 16;
  MarkerSize size{6, 6};
  Variant variant = Variant::kSecded;
  double side_m = 0.1;
  std::uint64_t first_id = 0;  ///< the others follow
  double margin_cells = 0;
  InkSet inks;
  double ink_spread_cells = 0;
  PrintQuality print;
  double speed_m_s = 0.4;         ///< the largest, where a phase says nothing else
  double acceleration_m_s2 = 5;   ///< the largest, also of braking
  double gap_m = 0.02;            ///< kept free between the circles about boards
  double height_spread_m = 0.05;  ///< robots are up to so much nearer to the camera
  double max_tilt_rad = 0.05;     ///< of a board against the floor
  /// Width and height of the floor that boards may cover; as far as the camera sees where there is none.
  std::optional<Eigen::Vector2d> arena_m;
};

/// A part of a stream. What belongs to another kind keeps its default.
struct Phase {
  PhaseKind kind = PhaseKind::kCalm;
  std::string name;              ///< unique in its scenario
  int frames = 60;               ///< of kGap: frames lost; of kReopen: as long as so many
  double speed_m_s = 0;          ///< largest, of robots
  double light = 1;              ///< factor
  double flicker_hz = 100;       ///< of the light, twice that of the mains
  double flicker_depth = 0.3;    ///< share of the light that comes and goes
  double knock_px = 14;          ///< longest motion in the middle of the frame; each frame has 0 to so much
  double hands_share = 1.0 / 3;  ///< of the boards
  double occluded_least = 0.15;  ///< share of each of these that is occluded
  double occluded_most = 0.45;
  double hand_s = 0.25;            ///< time after which hands move to other boards
  int hand_patches = 0;            ///< of random colour; 0: plain skin
  double shadow_takes = 0.6;       ///< share of the light, in the shadow
  double shadow_width_px = 4;      ///< standard deviation of its edge
  double shadow_speed_px_s = 300;  ///< of the edge
  double leave_share = 0.5;        ///< of the robots, that drive out of the frame and back
  double turn_rad = 0;             ///< about the optical axis
  double turn_tilt_rad = 0;        ///< about an axis across it
  double turn_s = 0.2;             ///< time that the turn takes
};

/// A stream: what is filmed, and what happens one after another.
struct Scenario {
  ScenarioCamera camera;
  ScenarioSwarm swarm;
  std::vector<Phase> phases;
  std::uint64_t seed = 1;

  /// Frames that the camera delivers: those of all phases but gaps and reopenings.
  int FrameCount() const;
};

/// Frames and gaps that a scenario may have.
inline constexpr int kMaxStreamFrames = 100'000;

/// Reads a scenario. Throws std::runtime_error naming file, line, key, value and what would be right.
Scenario LoadScenario(const std::filesystem::path& path);
/// The same from a text. @param name stands for the file in messages. @param folder where files that it names are.
Scenario ParseScenario(std::string_view text, const std::string& name, const std::filesystem::path& folder = {});

}  // namespace chequer
