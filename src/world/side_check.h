#pragma once

#include <span>
#include <string>

#include "chequer/detector.h"
#include "world/world_file.h"

namespace chequer {

/// Where the sides that are configured contradict those that the world file has of its references: which, both sides,
/// and what to do; empty where they agree. A wrong side scales every pose, and no picture shows it.
std::string SideContradiction(const WorldCalibration& world, std::span<const MarkerFamily> families);

}  // namespace chequer
