#include "detect/common/colours.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "detect/common/normal_integral.h"

namespace chequer {
namespace {

/// The cube root of a positive number to 1e-6, at a tenth of the library's cost: a third of the exponent, then two
/// steps of Halley's.
float CubeRoot(float t) {
  float root = std::bit_cast<float>(std::bit_cast<std::uint32_t>(t) / 3 + 0x2a5137a0u);
  for (int step = 0; step < 2; ++step) {
    const float cube = root * root * root;
    root *= (cube + 2 * t) / (2 * cube + t);
  }
  return root;
}

/// CIE 1976: the cube root with its straight start.
float LabCurve(float t) {
  constexpr float kStart = 216.0f / 24389.0f, kSlope = 24389.0f / 27.0f;
  return t > kStart ? CubeRoot(t) : (kSlope * t + 16) / 116;
}

CellColour Lab(const Eigen::Vector3f& light, bool dark_cell) {
  // sRGB primaries, relative to the white point: the rows sum to 1. X is needed for a* alone.
  const float y = 0.212639f * light[0] + 0.715169f * light[1] + 0.072192f * light[2];
  const float z = 0.017753f * light[0] + 0.109483f * light[1] + 0.872765f * light[2];
  const float fy = LabCurve(std::max(y, 0.0f)), fz = LabCurve(std::max(z, 0.0f));
  const float b = 200 * (fy - fz);
  return {116 * fy - 16, dark_cell ? -b : b};
}

CellColour Hsv(const Eigen::Vector3f& light) {
  const float most = std::max(light.maxCoeff(), 0.0f), least = std::max(light.minCoeff(), 0.0f);
  // Coded values, as HSV is defined on them.
  const float v = std::pow(most, 1 / 2.2f), low = std::pow(least, 1 / 2.2f);
  return {100 * v, v > 1e-4f ? 100 * (v - low) / v : 0};
}

}  // namespace

CellColour ColourOf(const Eigen::Vector3f& light, const Eigen::Vector3f& white, bool dark_cell, ColorSpace space) {
  const Eigen::Vector3f relative = light.cwiseQuotient(white);
  return space == ColorSpace::kHsv ? Hsv(relative) : Lab(relative, dark_cell);
}

Gaussian GaussianSum::Get() const {
  if (count_ == 0) return {};
  const double mean = sum_ / count_, square = std::max(square_sum_ - sum_ * mean, 0.0);
  return {count_, mean, count_ > 1 ? std::sqrt(square / (count_ - 1)) : 0};
}

double Overlap(const Gaussian& a, const Gaussian& b) {
  const double spread = a.deviation + b.deviation;
  const double distance = std::abs(a.mean - b.mean);
  if (spread <= 0) return distance > 0 ? 0 : 0.5;
  return NormalIntegral(-distance / spread);
}

}  // namespace chequer
