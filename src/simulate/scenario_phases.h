#pragma once

#include <vector>

#include "core/toml_reader.h"
#include "simulate/scenario.h"

namespace chequer {

/// Reads a [[phase]]. Throws as LoadScenario.
Phase ReadPhase(TomlTable& table, double fps, const ScenarioSwarm& swarm);

/// Gives each phase without a name that of its kind, and each name that was there before a number: "calm", "calm-2".
void NamePhases(std::vector<Phase>& phases);

}  // namespace chequer
