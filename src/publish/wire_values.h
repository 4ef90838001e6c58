#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "chequer/geometry.h"

// How single values travel: shared by the files that know LCM's types.

namespace chequer::wire_values {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <typename Enum>
std::int8_t WireEnum(Enum value) {
  return static_cast<std::int8_t>(value);
}

/// The enumerator, or whatever number a newer version may have sent: programs show those as unknown. One value that
/// is new must not lose a whole message.
template <typename Enum>
Enum ReadEnum(std::int8_t value) {
  static_assert(std::is_same_v<std::underlying_type_t<Enum>, std::uint8_t>);
  return static_cast<Enum>(value);
}

template <typename Time>
std::int64_t Microseconds(Time time) {
  return time.time_since_epoch().count();
}

template <typename Time>
Time FromMicroseconds(std::int64_t microseconds) {
  return Time(std::chrono::microseconds(microseconds));
}

/// LCM's integers are signed; counts stay far below 2^63, and an id keeps its 64 bits.
inline std::int64_t Signed(std::uint64_t value) { return static_cast<std::int64_t>(value); }
inline std::uint64_t Unsigned(std::int64_t value) { return static_cast<std::uint64_t>(value); }

inline void WriteVector(const Eigen::Vector3d& vector, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = vector(i);
}
inline Eigen::Vector3d ReadVector(const double* in) { return {in[0], in[1], in[2]}; }

/// w, x, y, z with w ≥ 0.
inline void WriteRotation(const Eigen::Quaterniond& rotation, double* out) {
  const Eigen::Quaterniond q = Canonical(rotation);
  const double values[4] = {q.w(), q.x(), q.y(), q.z()};
  for (int i = 0; i < 4; ++i) out[i] = values[i];
}
inline Eigen::Quaterniond ReadRotation(const double* in) { return {in[0], in[1], in[2], in[3]}; }

/// The upper triangle row by row.
template <typename Matrix>
void WriteTriangle(const Matrix& matrix, float* out) {
  for (int row = 0; row < matrix.rows(); ++row)
    for (int col = row; col < matrix.cols(); ++col) *out++ = static_cast<float>(matrix(row, col));
}
template <typename Matrix>
void ReadTriangle(const float* in, Matrix&& matrix) {
  for (int row = 0; row < matrix.rows(); ++row)
    for (int col = row; col < matrix.cols(); ++col) matrix(row, col) = matrix(col, row) = static_cast<double>(*in++);
}

}  // namespace chequer::wire_values
