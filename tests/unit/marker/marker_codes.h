#pragma once

#include <string>
#include <vector>

#include "chequer/marker.h"

namespace chequer::test {

/// Every size the specification allows.
std::vector<MarkerSize> AllSizes();

/// Every variant with a rule of its own (not tables) that exists at a size.
std::vector<MarkerCode> AllCodes(MarkerSize size);

/// "secded at 6x6".
std::string Describe(const MarkerCode& code);

}  // namespace chequer::test
