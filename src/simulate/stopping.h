#pragma once

#include <Eigen/Core>

#include "simulate/traffic.h"

namespace chequer {

/// Where a disc is after a time of braking as hard as it can, straight on.
DiscState Braked(const DiscState& state, double braking_m_s2, double time_s);

/// Where it stands in the end.
Eigen::Vector2d StopOf(const DiscState& state, double braking_m_s2);

/// Whether two discs that brake from now on keep their middles apart for ever, to within millimetres.
bool StopApart(const DiscState& a, const DiscState& b, double braking_m_s2, double apart_m);

}  // namespace chequer
