#include "simulate/random.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

namespace chequer {
namespace {

/// splitmix64 (Steele, Lea, Flood 2014): turns any seed into well-mixed bits.
std::uint64_t Mix(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/// Quantiles of the normal distribution at the middles of 65 536 equal steps of probability, by bisection of erfc.
std::vector<float> NormalQuantiles() {
  constexpr std::size_t kSteps = 65536;
  std::vector<float> table(kSteps);
  double x = -5;
  for (std::size_t i = 0; i < kSteps / 2; ++i) {
    const double p = (static_cast<double>(i) + 0.5) / kSteps;
    // Newton from the last quantile: the distribution function is convex below 0, so each step from the left of the
    // root overshoots at most once and then falls monotonically onto it.
    for (int step = 0; step < 50; ++step) {
      const double residual = 0.5 * std::erfc(-x / std::sqrt(2.0)) - p;
      const double density = std::exp(-0.5 * x * x) / std::sqrt(2 * M_PI);
      const double move = std::clamp(residual / density, -0.5, 0.5);
      x -= move;
      if (std::abs(move) < 1e-9) break;
    }
    table[i] = static_cast<float>(x);
    table[kSteps - 1 - i] = static_cast<float>(-x);
  }
  return table;
}

}  // namespace

Random::Random(std::uint64_t seed) {
  for (std::uint64_t& word : state_) word = Mix(seed);
}

std::uint64_t Random::Bits() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t shifted = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= shifted;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Random::Uniform() { return static_cast<double>(Bits() >> 11) * 0x1p-53; }

int Random::Below(int count) { return static_cast<int>(Uniform() * count); }

float Random::Normal() {
  static const std::vector<float> kQuantiles = NormalQuantiles();
  if (normals_left_ == 0) {
    normal_bits_ = Bits();
    normals_left_ = 4;
  }
  const auto index = static_cast<std::size_t>(normal_bits_ & 0xffffu);
  normal_bits_ >>= 16;
  --normals_left_;
  return kQuantiles[index];
}

float Random::Poisson(float mean) {
  if (mean > 50) return std::max(0.0f, mean + std::sqrt(mean) * Normal());
  double probability = std::exp(-static_cast<double>(mean));
  double left = Uniform();
  int events = 0;
  // 300 is beyond any tail of a mean of 50; it bounds the loop where rounding leaves a rest.
  while (left >= probability && events < 300) {
    left -= probability;
    ++events;
    probability *= static_cast<double>(mean) / events;
  }
  return static_cast<float>(events);
}

std::uint64_t DeriveSeed(std::uint64_t seed, std::uint64_t use) {
  std::uint64_t state = seed;
  state = Mix(state) ^ use;
  return Mix(state);
}

}  // namespace chequer
