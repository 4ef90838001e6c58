#include "simulate/scenario_phases.h"

#include <cmath>
#include <numbers>
#include <set>

namespace chequer {
namespace {

constexpr NumberRange kShare{0, 1};

double Radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// `frames`, or `seconds`.
void ReadLength(TomlTable& table, double fps, Phase& phase) {
  double seconds = 0;
  if (table.Read("frames", phase.frames, IntegerRange{1, kMaxStreamFrames})) {
    if (table.Has("seconds")) table.Fail("seconds", "says the same as frames; give one of them");
    return;
  }
  if (!table.Read("seconds", seconds, NumberRange{0.5 / fps, kMaxStreamFrames / fps})) table.FailMissing("frames");
  phase.frames = std::max(1, static_cast<int>(std::lround(seconds * fps)));
}

void ReadFlicker(TomlTable& table, Phase& phase) {
  table.Read("light", phase.light, NumberRange{0.001, 100});
  table.Read("frequency_hz", phase.flicker_hz, NumberRange{0.1, 100'000});
  table.Read("depth", phase.flicker_depth, kShare);
}

void ReadHands(TomlTable& table, Phase& phase) {
  table.Read("share", phase.hands_share, kShare);
  std::vector<double> occluded{phase.occluded_least, phase.occluded_most};
  table.Read("occluded", occluded, LengthRange{2, 2}, kShare);
  if (occluded[0] > occluded[1]) table.Fail("occluded", "must be the least share and the largest, in this order");
  phase.occluded_least = occluded[0];
  phase.occluded_most = occluded[1];
  table.Read("hand_s", phase.hand_s, NumberRange{0.001, 3600});
  table.Read("patches", phase.hand_patches, IntegerRange{0, 100});
}

void ReadShadow(TomlTable& table, Phase& phase) {
  table.Read("takes", phase.shadow_takes, kShare);
  table.Read("edge_px", phase.shadow_width_px, NumberRange{0.1, 1000});
  table.Read("edge_speed_px_s", phase.shadow_speed_px_s, NumberRange{0, 100'000});
}

void ReadTurn(TomlTable& table, Phase& phase) {
  double turn_deg = 2, tilt_deg = 0;
  table.Read("turn_deg", turn_deg, NumberRange{-180, 180});
  table.Read("tilt_deg", tilt_deg, NumberRange{-30, 30});
  table.Read("over_s", phase.turn_s, NumberRange{0, 60});
  phase.turn_rad = Radians(turn_deg);
  phase.turn_tilt_rad = Radians(tilt_deg);
}

void ReadOfKind(TomlTable& table, Phase& phase) {
  switch (phase.kind) {
    case PhaseKind::kDark:
      phase.light = 0.1;
      table.Read("light", phase.light, NumberRange{0.001, 1});
      return;
    case PhaseKind::kBright:
      phase.light = 2;
      table.Read("light", phase.light, NumberRange{1, 100});
      return;
    case PhaseKind::kFlicker: return ReadFlicker(table, phase);
    case PhaseKind::kKnock: table.Read("max_px", phase.knock_px, NumberRange{0, 200}); return;
    case PhaseKind::kHands: return ReadHands(table, phase);
    case PhaseKind::kShadow: return ReadShadow(table, phase);
    case PhaseKind::kTraffic: table.Read("share", phase.leave_share, kShare); return;
    case PhaseKind::kTurn: return ReadTurn(table, phase);
    case PhaseKind::kCalm:
    case PhaseKind::kFast:
    case PhaseKind::kGap:
    case PhaseKind::kReopen: return;
  }
}

}  // namespace

Phase ReadPhase(TomlTable& table, double fps, const ScenarioSwarm& swarm) {
  Phase phase;
  table.Require("kind", phase.kind, kPhaseKinds);
  ReadLength(table, fps, phase);
  table.Read("name", phase.name, LengthRange{1, 40});
  phase.speed_m_s = phase.kind == PhaseKind::kFast ? 1.5 : swarm.speed_m_s;
  table.Read("speed", phase.speed_m_s, NumberRange{0, 20});
  ReadOfKind(table, phase);
  return phase;
}

void NamePhases(std::vector<Phase>& phases) {
  std::set<std::string> taken;
  for (Phase& phase : phases) {
    if (phase.name.empty())
      for (const auto& [name, kind] : kPhaseKinds)
        if (kind == phase.kind) phase.name = name;
    const std::string first = phase.name;
    for (int number = 2; !taken.insert(phase.name).second; ++number) phase.name = first + "-" + std::to_string(number);
  }
}

}  // namespace chequer
