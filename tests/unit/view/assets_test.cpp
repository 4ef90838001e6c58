#include "view/assets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

const std::filesystem::path kPage = std::filesystem::path(CHEQUER_TEST_DATA).parent_path() / "src" / "view" / "page";

TEST(Assets, AreThePageAndNothingElse) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder.path() / "chart.min.js", std::string_view("chart"), Durability::kUnsynced);
  const Assets assets = Assets::Load(kPage, folder.path() / "chart.min.js");
  ASSERT_NE(assets.Find("/"), nullptr);
  EXPECT_EQ(assets.Find("/")->bytes, assets.Find("/index.html")->bytes);
  EXPECT_EQ(assets.Find("/chart.js")->bytes, "chart");
  EXPECT_EQ(assets.Find("/main.js")->type, "text/javascript; charset=utf-8");
  for (const char* path :
       {"", "/..", "/../server.cpp", "/%2e%2e/server.cpp", "//etc/passwd", "/main.js/"})
    EXPECT_EQ(assets.Find(path), nullptr) << path;
}

TEST(Assets, SayWhatIsMissing) {
  const test::TemporaryDirectory folder;
  EXPECT_THAT(test::ErrorOf([&] { Assets::Load(folder.path(), "/none"); }), ::testing::HasSubstr("installed whole"));
  EXPECT_THAT(test::ErrorOf([&] { Assets::Load(kPage, "/none"); }), ::testing::HasSubstr("libjs-chart.js"));
}

/// What is fetched from elsewhere would fail on a host without a network, and the page's own rules forbid it.
TEST(Assets, FetchNothingFromElsewhere) {
  for (const auto& entry : std::filesystem::directory_iterator(kPage)) {
    std::string text = ReadFile(entry.path(), 1 << 20);
    const std::string name_space = "http://www.w3.org/2000/svg";  // no address to fetch
    for (auto at = text.find(name_space); at != std::string::npos; at = text.find(name_space))
      text.erase(at, name_space.size());
    EXPECT_EQ(text.find("http://"), std::string::npos) << entry.path();
    EXPECT_EQ(text.find("https://"), std::string::npos) << entry.path();
    EXPECT_EQ(text.find("innerHTML"), std::string::npos) << entry.path() << ": names come from the network";
    EXPECT_EQ(text.find("eval("), std::string::npos) << entry.path();
  }
}

}  // namespace
}  // namespace chequer
