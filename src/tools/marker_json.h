#pragma once

#include <string>
#include <string_view>

#include "chequer/detector.h"
#include "tools/message_json.h"

namespace chequer {

/// What is told of a marker wherever it comes from, so that the same names mean the same everywhere.

/// "position" and "orientation" (w, x, y, z, w not negative); nothing where the marker has no pose.
void AddPose(const MarkerPose& marker, Json& json);

/// How well it was seen, from "corners_used" to "warnings"; "covariance" (upper triangle) and "ambiguity" only with a
/// pose.
void AddQuality(const MarkerPose& marker, Json& json);

/// The names of its warnings.
std::string WarningNames(const MarkerPose& marker, std::string_view separator);

}  // namespace chequer
