// What a user sees who does not know yet what is wrong: the README's first commands as written, and the hints of
// `chequer status` while chequerd runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/file.h"
#include "integration/workspace.h"
#include "support/process.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

namespace fs = std::filesystem;
using test::Process;
using test::Received;
using test::RunToEnd;
using test::Subscriber;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const fs::path kSource = fs::path(CHEQUER_TEST_DATA).parent_path();

/// The README's blocks of commands, those that are marked sh, one after the other.
std::vector<std::string> CommandBlocks() {
  const std::string readme = ReadFile(kSource / "README.md", 1 << 20);
  const std::string mark = "```sh\n";
  std::vector<std::string> blocks;
  for (std::size_t at = readme.find(mark); at != std::string::npos; at = readme.find(mark, at)) {
    at += mark.size();
    const std::size_t end = readme.find("```", at);
    blocks.push_back(readme.substr(at, end - at));
    at = end;
  }
  return blocks;
}

TEST(Readme, CommandsWorkAsWritten) {
  const TemporaryDirectory folder;
  for (const char* part : {"scripts", "tests", "config", "examples"})
    fs::create_directory_symlink(kSource / part, folder.path() / part);
  const fs::path bin = fs::path(CHEQUER).parent_path();
  const std::vector<std::string> blocks = CommandBlocks();
  ASSERT_GE(blocks.size(), 4u);
  for (const std::string& block : blocks) {
    // What a block leaves running ends with it.
    std::ofstream(folder / "block.sh") << "set -e\ntrap 'kill $(jobs -p) 2>/dev/null || true; wait' EXIT\nexport PATH='"
                                       << bin.string() << "':$PATH CHEQUER_BUILD='" << bin.parent_path().string()
                                       << "'\ncd '" << folder.path().string() << "'\n"
                                       << block;
    Process shell({"/bin/bash", folder / "block.sh"});
    EXPECT_EQ(shell.Wait(std::chrono::seconds(110)), 0) << block << "\n" << shell.output();
  }
  for (const char* made : {"plan.png", "north-markers.pdf", "north-robots.toml", "read.png", "why.png", "tracks.png"})
    EXPECT_GT(fs::file_size(folder / made), 100u) << made;
}

TEST(Readme, IsShortAndItsLinksLeadSomewhere) {
  const std::string readme = ReadFile(kSource / "README.md", 1 << 20);
  std::istringstream text(readme);
  const auto words = std::distance(std::istream_iterator<std::string>(text), std::istream_iterator<std::string>());
  EXPECT_LE(words, 1200);
  for (const char* file : {"docs/swarm.jpg", "docs/changes.md", "lcmtypes/README.md", "src/detect/README.md",
                           "tests/README.md", "tests/bench/README.md", "config/chequerd.toml"}) {
    EXPECT_THAT(readme, HasSubstr(file));
    EXPECT_TRUE(fs::exists(kSource / file)) << file;
  }
  EXPECT_LT(fs::file_size(kSource / "docs/swarm.jpg"), 300'000u);
}

TEST(Readme, ALogByTheExamplesUrlIsWritten) {
  const std::string text = ReadFile(kSource / "examples" / "README.md", 1 << 20);
  const std::size_t begin = text.find("\"file://") + 1;
  std::string url = text.substr(begin, text.find('"', begin) - begin);
  const TemporaryDirectory folder;
  url.replace(url.find("/tmp"), 4, folder.path().string());
  const test::Workspace workspace;
  Process daemon(
      {CHEQUERD, "--config", workspace.Configure("pace = \"unlimited\"", "[publish]\nurl = \"" + url + "\"")});
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
  EXPECT_TRUE(fs::exists(folder.path() / "swarm.lcm"));
}

TEST(Check, OpensTheRecording) {
  const test::Workspace workspace;
  const std::string config = workspace.Configure("", "", "/nowhere/recording");
  const auto result = RunToEnd({CHEQUERD, "--check", "--config", config});
  EXPECT_EQ(result.status, 78);
  EXPECT_THAT(result.output, HasSubstr("/nowhere/recording"));
  EXPECT_EQ(RunToEnd({CHEQUERD, "--check", "--config", workspace.Configure("")}).status, 0);
}

/// Renders, replays it slowly enough for several statuses, and gives all that `chequer status` says of it meanwhile.
std::string StatusOf(const std::vector<std::string>& scene, const std::string& variant) {
  const TemporaryDirectory folder;
  const std::string recording = folder.path() / "recording";
  std::vector<std::string> render{CHEQUER, "render", "--size",  "640x480", "--frames", "10",
                                  "--fps", "10",     "--speed", "0",       "--out",    recording};
  render.insert(render.end(), scene.begin(), scene.end());
  EXPECT_EQ(RunToEnd(render).status, 0);
  const std::string config = folder.path() / "chequerd.toml";
  std::ofstream(config)
      << "[camera]\nname = \"north\"\n[capture]\npath = \"recording\"\nloop = true\n[[marker]]\nsize = "
         "\"6x6\"\nvariant = \""
      << variant << "\"\n";
  Process daemon({CHEQUERD, "--config", config});
  Subscriber subscriber;
  EXPECT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.statuses.size() >= 2; })) << daemon.output();
  const auto status = RunToEnd({CHEQUER, "status", "north"});
  EXPECT_EQ(status.status, 0) << status.output;
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  return status.output;
}

TEST(StatusHints, TellBlackPictures) {
  EXPECT_THAT(StatusOf({"--side", "12cm", "--exposure", "0.0001"}, "secded"), HasSubstr("north: black"));
}

TEST(StatusHints, TellBlurredPictures) {
  EXPECT_THAT(StatusOf({"--side", "12cm", "--blur", "9", "--background", "tiles"}, "secded"), HasSubstr("blurred"));
}

TEST(StatusHints, TellAnotherVariant) {
  const std::vector<std::string> swarm{"--marker", "6x6:secded:0.12", "--swarm",    "8",
                                       "--ids",    "900-999",         "--distance", "2"};
  EXPECT_THAT(StatusOf(swarm, "unconstrained"), HasSubstr("these look like secded"));
  EXPECT_THAT(StatusOf(swarm, "reed_muller"), HasSubstr("these look like secded"));
  EXPECT_THAT(StatusOf(swarm, "secded"), AllOf(HasSubstr("north"), Not(HasSubstr("look like"))));
}

TEST(StatusHints, NameWhoIsHeardInstead) {
  const test::Workspace workspace;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  Subscriber subscriber;
  ASSERT_TRUE(subscriber.ReceiveUntil(test::HasPoses(1)));
  const auto status = RunToEnd({CHEQUER, "status", "tset"});
  EXPECT_EQ(status.status, 4);
  EXPECT_THAT(status.output, AllOf(HasSubstr("did you mean 'test'?"), HasSubstr("Heard were test")));
}

}  // namespace
}  // namespace chequer
