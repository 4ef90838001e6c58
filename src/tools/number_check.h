#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace chequer {

// Checks of an option's value, for CLI::Option::check: empty where it is right, else what is wrong. CLI11's own let nan
// through, take numbers beyond 64 bits for the largest that there is, and name that with all its digits.

/// A finite number above zero.
std::string IsAboveZero(const std::string& typed);

using NumberCheck = std::function<std::string(const std::string&)>;

/// A finite number in that range, both ends included.
NumberCheck IsWithin(double min, double max);
/// A whole number in that range, both ends included.
NumberCheck IsWhole(std::uint64_t min = 0, std::uint64_t max = std::numeric_limits<std::uint64_t>::max());

}  // namespace chequer
