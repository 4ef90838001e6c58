#pragma once

#include <random>

#include "chequer/detector.h"

// Markers as a detector would give them, without an image: their homographies from known poses.

namespace chequer::test {

inline constexpr double kCellM = 0.02;
inline constexpr double kFocalPx = 1200;
/// How well each of the 25 corners is known.
inline constexpr double kCornerPx = 0.02;

/// A camera 2.5 m over the floor that looks down, leaning a little.
RigidTransform WorldFromCamera();

/// What is measured of a 6x6 marker; with noise where a generator is given.
BoardMeasurement Measure(const RigidTransform& camera_from_marker, std::mt19937_64* random = nullptr);

/// The marker with its free pose, estimated from the measurement.
MarkerPose Detect(std::uint64_t id, const RigidTransform& camera_from_marker, std::mt19937_64* random = nullptr);

/// A body that stands on the floor.
RigidTransform OnFloor(double x, double y, double heading_rad, double height_m = 0);

}  // namespace chequer::test
