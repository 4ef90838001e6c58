#include "view/http_rules.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

const HttpRules kRules({"tower", "cam.lab.example"});

TEST(HttpRules, AServerIsAskedUnderItsOwnNames) {
  for (const char* host :
       {"127.0.0.1:8180", "localhost", "LOCALHOST:1", "[::1]:8180", "192.168.1.9", "tower:8180", "Cam.Lab.Example"})
    EXPECT_TRUE(kRules.HostIsOurs(host)) << host;
  using namespace std::string_view_literals;
  for (const std::string_view host :
       {""sv, "evil.example"sv, "evil.example:8180"sv, "localhost.evil.example"sv, "127.0.0.1.evil.example"sv, "[::1"sv,
        "[::1]x"sv, "127.0.0.1:"sv, "127.0.0.1:80a"sv, "127.0.0.1:800000"sv, "tower\0.evil"sv, "localhost\0"sv,
        ":8180"sv, "user@localhost"sv, "localhost/"sv, " localhost"sv})
    EXPECT_FALSE(kRules.HostIsOurs(host)) << host;
  EXPECT_FALSE(kRules.HostIsOurs(std::string(10000, '1')));
}

TEST(HttpRules, OnlyAPageThatWasServedHereMayConnect) {
  EXPECT_TRUE(kRules.OriginIsOurs("http://127.0.0.1:8180", "127.0.0.1:8180"));
  EXPECT_TRUE(kRules.OriginIsOurs("http://LocalHost:8180", "localhost:8180"));
  for (const char* origin : {"", "null", "http://evil.example", "https://127.0.0.1:8180", "http://127.0.0.1:8181",
                             "http://127.0.0.1:8180/", "http://127.0.0.1", "file://", "http://localhost:8180"})
    EXPECT_FALSE(kRules.OriginIsOurs(origin, "127.0.0.1:8180")) << origin;
  EXPECT_FALSE(kRules.OriginIsOurs("http://evil.example:8180", "evil.example:8180")) << "a name that was pointed here";
}

}  // namespace
}  // namespace chequer
