#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace chequer {

/// Of the standard normal distribution, from −∞ to z: what a Gaussian blur makes of an edge.
inline double NormalIntegral(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

/// The same to 1e-5, in a tenth of the time.
class NormalTable {
 public:
  double operator()(double z) const {
    const double at = (z + kEnd) * kPerUnit;
    if (!(at > 0)) return 0;
    if (at >= kNodes - 1) return 1;
    const std::size_t node = static_cast<std::size_t>(at);
    return values_[node] + (at - static_cast<double>(node)) * (values_[node + 1] - values_[node]);
  }
  static const NormalTable& Get() {
    static const NormalTable table;
    return table;
  }

 private:
  static constexpr double kEnd = 5.5, kPerUnit = 64;
  static constexpr int kNodes = static_cast<int>(2 * kEnd * kPerUnit) + 1;

  NormalTable() {
    for (int i = 0; i < kNodes; ++i) values_[static_cast<std::size_t>(i)] = NormalIntegral(i / kPerUnit - kEnd);
  }
  std::array<double, kNodes> values_;
};

}  // namespace chequer
