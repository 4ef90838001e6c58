#include "unit/marker/marker_codes.h"

namespace chequer::test {

std::vector<MarkerSize> AllSizes() {
  std::vector<MarkerSize> sizes;
  for (int rows = 3; rows <= 66; ++rows) {
    for (int cols = 3; cols <= 66; ++cols) {
      if ((rows - 2) * (cols - 2) <= 64) sizes.push_back({rows, cols});
    }
  }
  return sizes;
}

std::vector<MarkerCode> AllCodes(MarkerSize size) {
  std::vector<MarkerCode> codes;
  for (const Variant variant :
       {Variant::kUnconstrained, Variant::kSaturationConstrained, Variant::kColorConstrained, Variant::kSecded}) {
    codes.emplace_back(size, variant);
  }
  if (KernelBits(size) >= 24) codes.emplace_back(size, Variant::kGolay);
  if (KernelBits(size) == 16) {
    codes.emplace_back(size, Variant::kNordstromRobinson);
    codes.emplace_back(size, Variant::kReedMuller);
  }
  return codes;
}

std::string Describe(const MarkerCode& code) {
  return std::string(VariantName(code.variant())) + " at " + ToString(code.size());
}

}  // namespace chequer::test
