#include "tools/recent_map.h"

#include <gtest/gtest.h>

#include <string>

namespace chequer {
namespace {

std::string Text(const RecentMap<std::string, int>& map) {
  std::string text;
  map.ForEach([&](const std::string& key, int value) {
    text += key + std::to_string(value);
    return true;
  });
  return text;
}

TEST(RecentMap, TheOneThatWasNotAskedForTheLongestGoes) {
  RecentMap<std::string, int> map(3);
  EXPECT_TRUE(map.empty());
  map["a"] = 1;
  map["b"] = 2;
  map["c"] = 3;
  map["a"] = 4;
  map["d"] = 5;
  EXPECT_EQ(Text(map), "a4c3d5");
  map["e"] = 6;
  EXPECT_EQ(Text(map), "a4d5e6");
  map.EraseIf([](int value) { return value == 4; });
  EXPECT_EQ(map.size(), 2u);
  map["f"] = 7;
  map["g"] = 8;
  EXPECT_EQ(Text(map), "e6f7g8");
}

}  // namespace
}  // namespace chequer
