#include "tools/phase_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/message_json.h"

namespace chequer {
namespace {

std::string ShareText(int part, int whole) {
  return whole == 0 ? "-" : fmt::format("{:.4f}", static_cast<double>(part) / whole);
}

/// Three digits that count, "-" where there is nothing.
std::string NumberText(const Spread& spread, double value) {
  return spread.count == 0 ? "-" : fmt::format("{:.3g}", value);
}

std::string ReadingRow(const PhaseScore& phase, std::size_t width) {
  const FrameScore& total = phase.total;
  return fmt::format("{:{}}{:>8}{:>9}{:>8}{:>9}{:>9}{:>9}{:>11}{:>7}{:>7}{:>8}\n", phase.name, width, phase.frames,
                     phase.missing, total.expected, ShareText(total.read, total.expected), total.carried,
                     ShareText(total.whole_read, total.whole), total.undecided, total.wrong, total.twice, total.ghosts);
}

std::string ExactnessRow(const PhaseScore& phase, std::size_t width) {
  const auto pair = [](const Spread& s, double a, double b) {
    return fmt::format("{:>9}{:>9}", NumberText(s, a), NumberText(s, b));
  };
  const auto times = [](const Spread& s) {
    return fmt::format("{:>8}{:>8}{:>8}", NumberText(s, s.median), NumberText(s, s.p99), NumberText(s, s.largest));
  };
  return fmt::format("{:{}}{}{}{:>9}{:>9}{}{}\n", phase.name, width,
                     pair(phase.position_mm, phase.position_mm.median, phase.position_mm.rms),
                     pair(phase.angle_deg, phase.angle_deg.median, phase.angle_deg.rms),
                     NumberText(phase.position_over_covariance, phase.position_over_covariance.mean),
                     NumberText(phase.rotation_over_covariance, phase.rotation_over_covariance.mean),
                     times(phase.detect_ms), times(phase.latency_ms));
}

Json SpreadJson(const Spread& spread) {
  if (spread.count == 0) return nullptr;
  return {{"count", spread.count}, {"mean", spread.mean}, {"median", spread.median},
          {"rms", spread.rms},     {"p99", spread.p99},   {"largest", spread.largest}};
}

std::string PhaseLine(const PhaseRun& run, const PhaseScore& phase, const Json& name) {
  const FrameScore& total = phase.total;
  const auto share = [](int part, int whole) -> Json {
    return whole == 0 ? Json(nullptr) : Json(static_cast<double>(part) / whole);
  };
  return Dump(Json{{"run", run.name},
                   {"phase", name},
                   {"frames", phase.frames},
                   {"missing", phase.missing},
                   {"expected", total.expected},
                   {"read", total.read},
                   {"recall", share(total.read, total.expected)},
                   {"carried", total.carried},
                   {"whole", total.whole},
                   {"whole_recall", share(total.whole_read, total.whole)},
                   {"undecided", total.undecided},
                   {"wrong", total.wrong},
                   {"twice", total.twice},
                   {"ghosts", total.ghosts},
                   {"position_mm", SpreadJson(phase.position_mm)},
                   {"angle_deg", SpreadJson(phase.angle_deg)},
                   {"position_over_covariance", SpreadJson(phase.position_over_covariance)},
                   {"rotation_over_covariance", SpreadJson(phase.rotation_over_covariance)},
                   {"carried_position_mm", SpreadJson(phase.carried_position_mm)},
                   {"carried_position_over_covariance", SpreadJson(phase.carried_position_over_covariance)},
                   {"detect_ms", SpreadJson(phase.detect_ms)},
                   {"latency_ms", SpreadJson(phase.latency_ms)}}) +
         "\n";
}

}  // namespace

std::string DescribePhases(const PhaseRun& run) {
  std::vector<PhaseScore> phases = ScorePhases(run.frames);
  phases.push_back(ScoreAll(run.frames, "all"));
  std::size_t width = 5;
  for (const PhaseScore& phase : phases) width = std::max(width, phase.name.size());
  std::string text =
      fmt::format("{}\n{:{}}{:>8}{:>9}{:>8}{:>9}{:>9}{:>9}{:>11}{:>7}{:>7}{:>8}\n", run.name, "phase", width, "frames",
                  "missing", "boards", "recall", "carried", "whole", "undecided", "wrong", "twice", "ghosts");
  for (const PhaseScore& phase : phases) text += ReadingRow(phase, width);
  text += fmt::format("\n{:{}}{:>18}{:>18}{:>18}{:>24}{:>24}\n", "", width, "position, mm", "angle, deg",
                      "error2/covariance", "detection, ms", "latency, ms");
  text += fmt::format("{:{}}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}", "phase", width, "median", "rms", "median", "rms",
                      "position", "rotation");
  for (int i = 0; i < 2; ++i) text += fmt::format("{:>8}{:>8}{:>8}", "median", "99 %", "max");
  text += "\n";
  for (const PhaseScore& phase : phases) text += ExactnessRow(phase, width);
  return text;
}

std::string PhasesJson(const PhaseRun& run) {
  std::string text;
  for (const PhaseScore& phase : ScorePhases(run.frames)) text += PhaseLine(run, phase, phase.name);
  return text + PhaseLine(run, ScoreAll(run.frames, "all"), nullptr);
}

}  // namespace chequer
