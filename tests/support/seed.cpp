#include "support/seed.h"

#include <cstdlib>
#include <iostream>
#include <string>

namespace chequer::test {

std::mt19937_64 SeededGenerator() {
  constexpr std::uint64_t kDefaultSeed = 20240607;
  const char* const given = std::getenv("CHEQUER_TEST_SEED");
  const std::uint64_t seed = given == nullptr ? kDefaultSeed : std::stoull(given);
  std::cout << "seed " << seed << " (CHEQUER_TEST_SEED)\n";
  return std::mt19937_64(seed);
}

}  // namespace chequer::test
