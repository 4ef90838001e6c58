// The publication's Table I: how often a marker with 1 to 4 wrong cells is accepted as a marker it is not. A secded
// word with one wrong cell is corrected, hence accepted, but as itself; it counts as 0.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "chequer/marker.h"

namespace chequer {
namespace {

constexpr int kMostWrong = 4;

/// Per cent of all (word, pattern of that many wrong cells) that are accepted as another word, to one decimal.
std::array<double, kMostWrong> FalseAcceptancePercent(const MarkerCode& code) {
  std::array<std::vector<std::uint32_t>, kMostWrong> patterns;
  const std::uint32_t kernels = 1u << KernelBits(code.size());
  for (std::uint32_t pattern = 1; pattern < kernels; ++pattern) {
    const auto weight = static_cast<std::size_t>(std::popcount(pattern));
    if (weight <= patterns.size()) patterns[weight - 1].push_back(pattern);
  }
  // What each kernel is accepted as; every kernel is decoded, only not again for every way to get there.
  constexpr std::uint64_t kRefused = ~std::uint64_t{0};
  std::vector<std::uint64_t> accepted_as(kernels, kRefused);
  for (std::uint32_t kernel = 0; kernel < kernels; ++kernel) {
    if (const auto decoded = code.DecodeHard(kernel)) accepted_as[kernel] = decoded->id;
  }
  std::array<double, kMostWrong> percent{};
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    std::uint64_t accepted = 0;
    for (std::uint64_t id = 0; id <= code.max_id(); ++id) {
      const std::uint64_t kernel = code.Encode(id);
      for (const std::uint32_t pattern : patterns[i]) {
        const std::uint64_t read = accepted_as[kernel ^ pattern];
        accepted += read != kRefused && read != id;
      }
    }
    const double all = static_cast<double>(code.max_id() + 1) * static_cast<double>(patterns[i].size());
    percent[i] = std::round(1000.0 * static_cast<double>(accepted) / all) / 10.0;
  }
  return percent;
}

class PublishedTable : public testing::TestWithParam<const char*> {};

TEST_P(PublishedTable, FalseAcceptanceIsReproduced) {
  std::ifstream file(CHEQUER_TEST_DATA "/unit/marker/markers.json");
  const auto expected = nlohmann::json::parse(file)
                            .at("paper_table_1_percent_accepted_for_1_to_4_wrong_bits")
                            .at(GetParam())
                            .get<std::array<double, kMostWrong>>();
  const MarkerCode code({6, 6}, ParseVariant(GetParam()).value());
  EXPECT_EQ(FalseAcceptancePercent(code), expected);
}

INSTANTIATE_TEST_SUITE_P(AllPublishedVariants, PublishedTable,
                         testing::Values("unconstrained", "saturation_constrained", "color_constrained", "secded"),
                         [](const auto& variant) { return std::string(variant.param); });

}  // namespace
}  // namespace chequer
