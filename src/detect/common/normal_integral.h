#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace chequer {

/// Of the standard normal distribution, from −∞ to z: what a Gaussian blur makes of an edge.
inline double NormalIntegral(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }
inline double NormalDensity(double z) {
  return std::exp(-0.5 * z * z) * (0.5 * std::numbers::inv_sqrtpi * std::numbers::sqrt2);
}
/// The integral of NormalIntegral().
inline double NormalRamp(double z) { return z * NormalIntegral(z) + NormalDensity(z); }

/// The same to 1e-5, in a tenth of the time; beyond its ends, as at them.
class NormalTable {
 public:
  static const NormalTable& Get() {
    static const NormalTable table;
    return table;
  }
  float operator()(float z) const {
    // In this order, what is no number lies at an end too.
    const float at = (std::min(kEnd, std::max(-kEnd, z)) + kEnd) * kPerUnit;
    const std::size_t node = static_cast<std::size_t>(at);
    return values_[node] + (at - static_cast<float>(node)) * (values_[node + 1] - values_[node]);
  }
  double operator()(double z) const { return double{(*this)(static_cast<float>(z))}; }

 private:
  static constexpr float kEnd = 5.5f, kPerUnit = 64;

  NormalTable() {
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_[i] = static_cast<float>(NormalIntegral(static_cast<double>(i) / kPerUnit - kEnd));
  }
  /// One more than there are nodes: of the last, too, there is a next.
  std::array<float, static_cast<std::size_t>(2 * kEnd * kPerUnit) + 2> values_;
};

}  // namespace chequer
