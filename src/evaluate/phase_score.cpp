#include "evaluate/phase_score.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace chequer {
namespace {

/// What a phase's frames show, before it is summed up.
struct Gathered {
  PhaseScore score;
  std::vector<double> detect_ms, latency_ms;

  void Add(const ScoredFrame& frame) {
    ++score.frames;
    if (!frame.score) {
      ++score.missing;
      return;
    }
    score.total += *frame.score;
    if (frame.detect_ms) detect_ms.push_back(*frame.detect_ms);
    if (frame.latency_ms) latency_ms.push_back(*frame.latency_ms);
  }

  PhaseScore Finish() {
    std::vector<double> position, angle, position_ratio, rotation_ratio, carried, carried_ratio;
    for (const PoseError& error : score.total.errors) {
      if (error.carried) {
        carried.push_back(error.position_mm);
        if (error.position_over_covariance) carried_ratio.push_back(*error.position_over_covariance);
        continue;
      }
      position.push_back(error.position_mm);
      angle.push_back(error.angle_deg);
      if (error.position_over_covariance) position_ratio.push_back(*error.position_over_covariance);
      if (error.rotation_over_covariance) rotation_ratio.push_back(*error.rotation_over_covariance);
    }
    score.total.errors.clear();
    score.position_mm = SpreadOf(std::move(position));
    score.angle_deg = SpreadOf(std::move(angle));
    score.position_over_covariance = SpreadOf(std::move(position_ratio));
    score.rotation_over_covariance = SpreadOf(std::move(rotation_ratio));
    score.carried_position_mm = SpreadOf(std::move(carried));
    score.carried_position_over_covariance = SpreadOf(std::move(carried_ratio));
    score.detect_ms = SpreadOf(std::move(detect_ms));
    score.latency_ms = SpreadOf(std::move(latency_ms));
    return std::move(score);
  }
};

}  // namespace

Spread SpreadOf(std::vector<double> values) {
  Spread spread;
  spread.count = values.size();
  if (values.empty()) return spread;
  std::sort(values.begin(), values.end());
  const std::size_t last = values.size() - 1;
  spread.median = 0.5 * (values[last / 2] + values[(last + 1) / 2]);
  // The smallest value that 99 % of all do not exceed.
  spread.p99 = values[static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(values.size()))) - 1];
  spread.largest = values[last];
  double sum = 0, squares = 0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  spread.mean = sum / static_cast<double>(values.size());
  spread.rms = std::sqrt(squares / static_cast<double>(values.size()));
  return spread;
}

std::vector<PhaseScore> ScorePhases(std::span<const ScoredFrame> frames) {
  std::vector<Gathered> phases;
  for (const ScoredFrame& frame : frames) {
    auto phase = std::find_if(phases.begin(), phases.end(),
                              [&](const Gathered& known) { return known.score.name == frame.phase; });
    if (phase == phases.end()) {
      phases.emplace_back().score.name = frame.phase;
      phase = phases.end() - 1;
    }
    phase->Add(frame);
  }
  std::vector<PhaseScore> scores;
  for (Gathered& phase : phases) scores.push_back(phase.Finish());
  return scores;
}

PhaseScore ScoreAll(std::span<const ScoredFrame> frames, const std::string& name) {
  Gathered all;
  all.score.name = name;
  for (const ScoredFrame& frame : frames) all.Add(frame);
  return all.Finish();
}

}  // namespace chequer
