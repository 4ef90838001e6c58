#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "integration/workspace.h"
#include "publish/lcm_publisher.h"
#include "publish/lcm_url.h"
#include "support/process.h"

namespace chequer {
namespace {

using nlohmann::json;
using test::DemoRecording;
using test::Process;
using test::SetMulticastRoute;
using test::Workspace;
using ::testing::HasSubstr;

std::vector<json> JsonLines(const std::string& text) {
  std::vector<json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with("{")) lines.push_back(json::parse(line));
  return lines;
}

TEST(Listen, PrintsFramesAsJson) {
  const Workspace workspace;
  Process listener({CHEQUER, "listen", "--json", "--channel", "CHEQUER_test_POSES", "--count", "5"});
  ASSERT_TRUE(listener.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  EXPECT_EQ(listener.Wait(), 0) << listener.output();
  const auto lines = JsonLines(listener.output());
  ASSERT_EQ(lines.size(), 5u);
  for (const json& line : lines) {
    EXPECT_EQ(line["type"], "poses");
    EXPECT_EQ(line["channel"], "CHEQUER_test_POSES");
    EXPECT_EQ(line["markers"].size(), 8u);
    EXPECT_EQ(line["markers"][0]["position"].size(), 3u);
  }
}

TEST(Listen, TakesChannelsAndUrlFromAConfiguration) {
  const Workspace workspace;
  const std::string config =
      workspace.Configure("loop = true", "[publish]\nurl = \"udpm://239.255.76.68:7668?ttl=0\"\nprefix = \"ARENA\"");
  Process listener({CHEQUER, "listen", "--config", config, "--json", "--count", "3"});
  ASSERT_TRUE(listener.WaitForOutput("listening at udpm://239.255.76.68:7668?ttl=0")) << listener.output();
  LcmPublisher other({.url = "udpm://239.255.76.68:7668?ttl=0", .prefix = "OTHER"});
  other.Publish(PosesMessage{});
  Process daemon({CHEQUERD, "--config", config});
  EXPECT_EQ(listener.Wait(), 0) << listener.output();
  const auto lines = JsonLines(listener.output());
  ASSERT_GE(lines.size(), 3u);
  for (const json& line : lines) EXPECT_TRUE(line["channel"].get<std::string>().starts_with("ARENA_")) << line;
  Process status({CHEQUER, "status", "--config", config, "--seconds", "20"});
  EXPECT_EQ(status.Wait(), 0) << status.output();
  // What is typed goes before it.
  Process typed({CHEQUER, "listen", "--config", config, "--url", std::string(kDefaultLcmUrl), "--seconds", "0.01"});
  EXPECT_EQ(typed.Wait(), 0) << typed.output();
  EXPECT_THAT(typed.output(), HasSubstr("listening at udpm://239.255.76.67:7667"));
}

TEST(Listen, PrintsTracksAsJson) {
  const Workspace workspace;
  Process listener({CHEQUER, "listen", "--json", "--channel", "CHEQUER_test_TRACKS", "--count", "5"});
  ASSERT_TRUE(listener.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true", "[tracks]\nenabled = true")});
  EXPECT_EQ(listener.Wait(), 0) << listener.output();
  const auto lines = JsonLines(listener.output());
  ASSERT_EQ(lines.size(), 5u);
  for (const json& line : lines) {
    EXPECT_EQ(line["type"], "tracks");
    EXPECT_EQ(line["frame"], "camera");
    EXPECT_EQ(line["tracks"].size(), 8u);
  }
}

TEST(Listen, HearsOnlyThePrefixThatWasAskedFor) {
  const Workspace workspace;
  Process other({CHEQUER, "listen", "--prefix", "OTHER", "--seconds", "1"});
  Process ours({CHEQUER, "listen", "--prefix", "CHEQUER_test", "--count", "3"});
  ASSERT_TRUE(other.WaitForOutput("listening at"));
  ASSERT_TRUE(ours.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  EXPECT_EQ(ours.Wait(), 0);
  EXPECT_THAT(ours.output(), HasSubstr("test frame"));
  EXPECT_EQ(other.Wait(), 0);
  EXPECT_EQ(other.output().find("test frame"), std::string::npos);
}

TEST(Listen, DrawsAMapOnATerminal) {
  const Workspace workspace;
  Process listener({"script", "-qec", CHEQUER " listen --arena --count 30", "/dev/null"}, {"TERM=xterm"});
  ASSERT_TRUE(listener.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true", "[tracks]\nenabled = true")});
  EXPECT_EQ(listener.Wait(), 0) << listener.output();
  EXPECT_THAT(listener.output(), HasSubstr("8 in the camera's frame"));
  EXPECT_THAT(listener.output(), HasSubstr("cm"));
  Process no_terminal({CHEQUER, "listen", "--arena"});
  EXPECT_EQ(no_terminal.Wait(), 2);
  EXPECT_THAT(no_terminal.output(), HasSubstr("draws on a terminal"));
}

TEST(Listen, EndsWhereItsOutputCannotBeWritten) {
  const Workspace workspace;
  Process listener({"/bin/sh", "-c", "exec '" CHEQUER "' listen >/dev/full"});
  ASSERT_TRUE(listener.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  EXPECT_EQ(listener.Wait(), 1);
  EXPECT_THAT(listener.output(), HasSubstr("standard output cannot be written"));
}

TEST(Listen, FailsWhereTooFewFramesCome) {
  Process listener({CHEQUER, "listen", "--count", "3", "--seconds", "0.2"});
  EXPECT_EQ(listener.Wait(), 1);
  EXPECT_THAT(listener.output(), HasSubstr("only 0 of 3 frames"));
}

TEST(Listen, NamesTheRemedyWithoutAMulticastRoute) {
  SetMulticastRoute(false);
  Process listener({CHEQUER, "listen"});
  EXPECT_EQ(listener.Wait(), 1);
  EXPECT_THAT(listener.output(), HasSubstr("ip route add 224.0.0.0/4 dev lo"));
}

TEST(Listen, ComparesWithTheTruth) {
  const Workspace workspace;
  Process listener({CHEQUER, "listen", "--truth", DemoRecording().string()});
  ASSERT_TRUE(listener.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("pace = \"unlimited\"")});
  EXPECT_EQ(listener.Wait(), 0) << listener.output();
  EXPECT_THAT(listener.output(), HasSubstr("60 of 60 frames"));
}

TEST(Listen, SaysWhenThePosesAreNotTheTruth) {
  const Workspace workspace;
  std::string config = workspace.Configure("pace = \"unlimited\"");
  Process sed({"sed", "-i", "s/^side = .*/side = 0.13/", config});  // all too far away
  ASSERT_EQ(sed.Wait(), 0);
  Process listener({CHEQUER, "listen", "--truth", DemoRecording().string()});
  ASSERT_TRUE(listener.WaitForOutput("listening at"));
  Process daemon({CHEQUERD, "--config", config});
  EXPECT_EQ(listener.Wait(), 1);
  EXPECT_THAT(listener.output(), HasSubstr("NOT as the truth says"));
}

TEST(ConvertLog, TurnsALogOfTheDaemonIntoJsonAndCsv) {
  const Workspace workspace;
  const std::string log = (workspace.path() / "poses.lcm").string();
  Process daemon({CHEQUERD, "--config",
                  workspace.Configure("pace = \"unlimited\"", "[publish]\nurl = \"file://" + log + "?mode=w\"")});
  ASSERT_EQ(daemon.Wait(), 0) << daemon.output();
  Process to_json({CHEQUER, "convert", log, "--out", "-"});
  EXPECT_EQ(to_json.Wait(), 0) << to_json.output();
  const auto lines = JsonLines(to_json.output());
  EXPECT_EQ(std::count_if(lines.begin(), lines.end(), [](const json& line) { return line["type"] == "poses"; }), 60);
  const std::string csv = (workspace.path() / "poses.csv").string();
  Process to_csv({CHEQUER, "convert", log, "--out", csv});
  EXPECT_EQ(to_csv.Wait(), 0) << to_csv.output();
  std::ifstream file(csv);
  int rows = 0;
  for (std::string line; std::getline(file, line);) ++rows;
  EXPECT_EQ(rows, 1 + 60 * 8);
}

}  // namespace
}  // namespace chequer
