#pragma once

#include <span>
#include <string>

#include "world/tie_fit.h"

namespace chequer {

/// Why references that do not agree do not, as well as it can be told: a list that is a mirror image, a scale that is
/// off, or the references that do not fit the majority, and where the majority puts them. @pre at least two ties.
std::string ExplainContradiction(std::span<const Tie> ties, double sigma_m);

/// Whether the ties would agree if y were the other way round: the list is then left-handed.
bool IsMirrored(std::span<const Tie> ties, double sigma_m);

/// Whether boards that are said to lie flat are seen from below.
bool IsUpsideDown(std::span<const Tie> ties, const RigidTransform& world_from_camera);

}  // namespace chequer
