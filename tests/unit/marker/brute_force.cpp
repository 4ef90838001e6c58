#include "unit/marker/brute_force.h"

#include <algorithm>
#include <limits>

namespace chequer::test {

BruteForce::BruteForce(const MarkerCode& code) {
  for (std::uint64_t id = 0; id <= code.max_id(); ++id) kernels_.push_back(code.Encode(id));
}

BruteForce::BruteForce(const MarkerCode& code, const Roster& roster) {
  for (const std::uint64_t id : roster.ids()) {
    if (id <= code.max_id()) kernels_.push_back(code.Encode(id));
  }
}

double CostOfKernel(std::span<const float> ratios, std::uint64_t kernel) {
  double cost = 0;
  for (std::size_t cell = 0; cell < ratios.size(); ++cell) {
    const bool saturated = (kernel >> (ratios.size() - 1 - cell) & 1) != 0;
    if (saturated != (ratios[cell] > 0)) cost += std::abs(static_cast<double>(ratios[cell]));
  }
  return cost;
}

BruteForce::Costs BruteForce::Evaluate(std::span<const float> ratios) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Costs costs{kNone, kNone};
  for (const std::uint64_t kernel : kernels_) {
    const double cost = CostOfKernel(ratios, kernel);
    if (cost < costs.best) {
      costs.second = costs.best;
      costs.best = cost;
    } else {
      costs.second = std::min(costs.second, cost);
    }
  }
  return costs;
}

void ExpectMostLikely(const MarkerCode& code, const BruteForce& reference, std::span<const float> ratios,
                      const std::optional<SoftDecoded>& decoded) {
  const BruteForce::Costs costs = reference.Evaluate(ratios);
  ASSERT_TRUE(decoded.has_value());
  double total = 0;
  for (const float ratio : ratios) total += std::abs(static_cast<double>(ratio));
  const double tolerance = 1e-12 * total;
  ASSERT_LE(decoded->best.id, code.max_id());
  ASSERT_EQ(code.Encode(decoded->best.id), decoded->best.kernel);
  EXPECT_NEAR(CostOfKernel(ratios, decoded->best.kernel), costs.best, tolerance);
  EXPECT_GE(decoded->margin, 0.0);
  if (std::isinf(costs.second)) {
    EXPECT_EQ(decoded->margin, costs.second);
  } else {
    EXPECT_NEAR(decoded->margin, costs.second - costs.best, tolerance);
  }
  int corrected = 0;
  for (std::size_t cell = 0; cell < ratios.size(); ++cell) {
    const bool saturated = (decoded->best.kernel >> (ratios.size() - 1 - cell) & 1) != 0;
    corrected += ratios[cell] != 0 && saturated != (ratios[cell] > 0);
  }
  EXPECT_EQ(decoded->best.bits_corrected, corrected);
}

std::vector<float> RandomRatios(std::mt19937_64& random, int bits) {
  std::normal_distribution<float> normal(0.0f, 3.0f);
  std::vector<float> ratios(static_cast<std::size_t>(bits));
  const auto kind = random() % 4;
  for (float& ratio : ratios) {
    ratio = normal(random);
    if (kind == 1) ratio = std::round(ratio);
    if (kind == 2 && random() % 3 == 0) ratio = 0.0f;
    if (kind == 3) ratio = std::exp(ratio) * (random() % 2 == 0 ? 1.0f : -1.0f);
  }
  return ratios;
}

}  // namespace chequer::test
