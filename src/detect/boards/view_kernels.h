#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "detect/common/plane.h"

namespace chequer {

/// Fills `view`, of `side` × `side` pixels, with what lies around a point of a plane, stretched and turned: its pixel
/// (x, y) shows middle + plane_by_view · (x − m, y − m), m = (side − 1) / 2, pixels outside the plane as its edge is.
/// Where a pixel of the view is wider along x than the plane's, it is the mean of those it covers.
/// @pre the plane is not empty and smaller than 16384 px.
void ViewPlane(const BytePlane& plane, const Eigen::Vector2f& middle, const Eigen::Matrix2f& plane_by_view, int side,
               BytePlane& view);

/// Widest running mean, px.
inline constexpr int kWidestMean = 15;

/// Smoothes rows by two running means of `width` values each, which have a variance of (width² − 1) / 6 px² together;
/// beyond its ends, a row goes on as it ends. @param width odd, 3 to kWidestMean. @param scratch keeps its memory.
void SmoothRows(int width, BytePlane& plane, std::vector<std::uint8_t>& scratch);

}  // namespace chequer
