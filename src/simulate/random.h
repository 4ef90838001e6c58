#pragma once

#include <cmath>
#include <cstdint>

namespace chequer {

/// A small seeded generator (xoshiro256++) with the distributions that a simulated sensor needs. Written out because
/// the standard's distributions differ between libraries, and a seed must give the same frame everywhere.
class Random {
 public:
  /// Streams of different seeds are independent; 0 is a seed like any other.
  explicit Random(std::uint64_t seed);

  std::uint64_t Bits();
  /// Uniform in [0, 1).
  double Uniform();
  /// Uniform in [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  /// Between low and high, its logarithm uniform. @pre 0 < low ≤ high.
  double LogUniform(double low, double high) { return std::exp(Uniform(std::log(low), std::log(high))); }
  /// Uniform in 0 … count − 1. @pre count ≥ 1.
  int Below(int count);
  /// Of mean 0 and variance 1, in 65 536 equally likely steps (tails end at 4.3).
  float Normal();
  /// Events of a Poisson process of that mean; Gaussian above a mean of 50, where the difference is below the read
  /// noise.
  /// @pre mean ≥ 0.
  float Poisson(float mean);

 private:
  std::uint64_t state_[4];
  std::uint64_t normal_bits_ = 0;
  int normals_left_ = 0;
};

/// A seed for one use of many that hang on one seed (a frame of a sequence, the background of a scene).
std::uint64_t DeriveSeed(std::uint64_t seed, std::uint64_t use);

}  // namespace chequer
