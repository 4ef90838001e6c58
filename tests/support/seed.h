#pragma once

#include <cstdint>
#include <random>

namespace chequer::test {

/// A generator for a test's random input. Its seed is fixed, or the environment's CHEQUER_TEST_SEED, and printed, so
/// that a failure can be repeated.
std::mt19937_64 SeededGenerator();

}  // namespace chequer::test
