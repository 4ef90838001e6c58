#pragma once

#include <Eigen/Geometry>

#include "chequer/image.h"

namespace chequer {

/// A marker has a fortieth of each of its inks even where half of what is looked at is something else; clutter has one
/// of them at most.
inline constexpr double kLeastInkShare = 0.025;

/// Share of the pixels in a box that have a marker's inks: the lesser of blue's and yellow's. @param image BGR8.
double InkShare(const ImageView& image, const Eigen::AlignedBox2d& box);

}  // namespace chequer
