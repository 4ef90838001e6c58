#include <gtest/gtest.h>

#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "chequer/marker.h"

namespace chequer {
namespace {

/// One marker of the specification's test vectors.
struct Vector {
  MarkerSize size;
  Variant variant = Variant::kTable;
  std::uint64_t id = 0;
  std::uint64_t kernel = 0;
  std::string colours;
};

Vector ParseVector(const nlohmann::json& entry) {
  Vector vector;
  vector.size = {entry.at("rows").get<int>(), entry.at("cols").get<int>()};
  vector.variant = ParseVariant(entry.at("variant").get<std::string>()).value();
  vector.id = std::stoull(entry.at("id").get<std::string>());
  for (const char digit : entry.at("kernel").get<std::string>()) vector.kernel = vector.kernel << 1 | (digit == '1');
  for (const nlohmann::json& row : entry.at("cells")) vector.colours += row.get<std::string>();
  return vector;
}

std::vector<Vector> LoadVectors() {
  std::ifstream file(CHEQUER_TEST_DATA "/unit/marker/markers.json");
  const nlohmann::json specification = nlohmann::json::parse(file);
  std::vector<Vector> vectors;
  for (const nlohmann::json& entry : specification.at("markers")) vectors.push_back(ParseVector(entry));
  return vectors;
}

TEST(SpecificationVectors, AreEncodedAndDecoded) {
  const std::vector<Vector> vectors = LoadVectors();
  ASSERT_EQ(vectors.size(), 274u);
  for (const Vector& vector : vectors) {
    SCOPED_TRACE(std::string(VariantName(vector.variant)) + " at " + ToString(vector.size) + " id " +
                 std::to_string(vector.id));
    const MarkerCode code(vector.size, vector.variant);
    EXPECT_EQ(code.Encode(vector.id), vector.kernel);
    EXPECT_EQ(CellColours(vector.size, vector.kernel), vector.colours);
    const std::optional<Decoded> decoded = code.DecodeHard(vector.kernel);
    ASSERT_TRUE(decoded.has_value());
    EXPECT_EQ(decoded->id, vector.id);
    EXPECT_EQ(decoded->kernel, vector.kernel);
    EXPECT_EQ(decoded->bits_corrected, 0);
  }
}

TEST(SpecificationVectors, CoverEveryVariantWithARule) {
  std::set<Variant> variants;
  for (const Vector& vector : LoadVectors()) variants.insert(vector.variant);
  EXPECT_EQ(variants.size(), 7u);
}

}  // namespace
}  // namespace chequer
