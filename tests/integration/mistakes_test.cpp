// What people type wrong. The answer says what is wrong, and what was probably meant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <ostream>
#include <string>
#include <vector>

#include "support/process.h"
#include "support/temporary_directory.h"

namespace chequer::test {
namespace {

using ::testing::HasSubstr;

struct Mistake {
  const char* name;
  std::vector<std::string> arguments;
  int status;
  std::string answer;
};

std::ostream& operator<<(std::ostream& out, const Mistake& mistake) { return out << mistake.name; }

class CommandLine : public ::testing::TestWithParam<Mistake> {};

/// A file of 32 MB of zeros, which take no room on the disk.
std::string EndlessLine(const TemporaryDirectory& folder) {
  const auto file = folder / "run.json";
  std::ofstream{file};
  std::filesystem::resize_file(file, 32u << 20);
  return file.string();
}

TEST_P(CommandLine, SaysWhatWasProbablyMeant) {
  const Mistake& mistake = GetParam();
  TemporaryDirectory folder;
  std::vector<std::string> arguments = mistake.arguments;
  for (std::string& argument : arguments)
    if (argument == "FOLDER")
      argument = folder.path().string();
    else if (argument == "ENDLESS_LINE")
      argument = EndlessLine(folder);
  const bool daemon = !arguments.empty() && arguments.front() == "chequerd";
  if (daemon)
    arguments.front() = CHEQUERD;
  else
    arguments.insert(arguments.begin(), CHEQUER);
  Process process(std::move(arguments));
  EXPECT_EQ(process.Wait(std::chrono::seconds(60)), mistake.status) << process.output();
  EXPECT_THAT(process.output(), HasSubstr(mistake.answer));
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, CommandLine,
    ::testing::Values(
        Mistake{"Option", {"detect", "--calibratoin", "c.toml", "a.png"}, 2, "did you mean '--calibration'?"},
        Mistake{"OptionWithValue", {"detect", "--repaet=3", "a.png"}, 2, "did you mean '--repeat'?"},
        Mistake{"OptionOfAnother",
                {"print", "--ids", "0", "--size", "60mm", "--out", "x.pdf"},
                2,
                "did you mean '--side'?"},
        Mistake{
            "SideWithoutUnit", {"print", "--ids", "0", "--side", "60", "--out", "x.pdf"}, 2, "did you mean \"60mm\"?"},
        Mistake{"SideIsNoLength", {"detect", "--side", "60miles", "a.png"}, 2, "have a unit, such as 60mm or 6cm"},
        Mistake{"Command", {"dtect", "a.png"}, 2, "did you mean 'detect'?"},
        Mistake{"CommandOfACommand", {"calibrate", "wrld"}, 2, "did you mean 'world'?"},
        Mistake{"NoCommand", {"calibrate"}, 2, "known are lens, world, robots"},
        Mistake{"Configuration", {"chequerd", "x.toml"}, 2, "did you mean --config x.toml?"},
        Mistake{"OptionOfTheDaemon", {"chequerd", "--conifg", "x.toml"}, 2, "did you mean '--config'?"},
        Mistake{"TiltOfASwarm",
                {"render", "--swarm", "3", "--side", "10cm", "--tilt", "70", "--out", "FOLDER"},
                2,
                "--tilt: 70 must be a number from 0 to 68"},
        Mistake{"Background",
                {"render", "--side", "10cm", "--background", "plian", "--out", "FOLDER"},
                2,
                "did you mean 'plain'?"},
        Mistake{"Variant", {"detect", "--variant", "secdde", "a.png"}, 2, "did you mean 'secded'?"},
        Mistake{"FolderAsRun", {"evaluate", "FOLDER"}, 1, "is a folder, not a run; of frames, `chequer detect --json"},
        Mistake{"EndlessRun", {"evaluate", "ENDLESS_LINE"}, 1, "the line has no end"},
        Mistake{"DeviceAsRun", {"evaluate", "/dev/zero"}, 1, "/dev/zero: is a device, not a file"},
        Mistake{"SecondsThatAreNoNumber", {"status", "--seconds", "nan"}, 2, "'nan' must be a number from 0.01"},
        Mistake{"CountBeyondBelief",
                {"listen", "--count", "18446744073709551616"},
                2,
                "'18446744073709551616' must be a whole number"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace chequer::test
