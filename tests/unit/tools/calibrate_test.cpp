#include "tools/calibrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

std::string WhyRefused(const std::filesystem::path& file, bool force = false) {
  try {
    CheckOut(file, force);
  } catch (const CLI::ValidationError& error) {
    return error.what();
  }
  return {};
}

TEST(Calibration, WhatTheToolWroteIsReplaced) {
  const test::TemporaryDirectory folder;
  for (const char* text : {"a = 1\n", "a = 2\n"}) {
    EXPECT_EQ(WhyRefused(folder / "x.toml"), "");
    WriteCalibration(folder / "x.toml", text);
    EXPECT_FALSE(IsEdited(folder / "x.toml"));
    EXPECT_THAT(ReadFile(folder / "x.toml", 1000), HasSubstr(text));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(Calibration, WhatSomebodyEditedIsNotLost) {
  const test::TemporaryDirectory folder;
  WriteCalibration(folder / "x.toml", "name = \"robot_0\"\n");
  const std::string written = ReadFile(folder / "x.toml", 1000);
  const std::string renamed = "name = \"alice\"\n" + written.substr(written.find('#'));
  for (const std::string& edited : {renamed, written + "# a remark\n", "# before\n" + written, std::string("mine")}) {
    WriteFileAtomically(folder / "x.toml", edited);
    EXPECT_TRUE(IsEdited(folder / "x.toml"));
    EXPECT_THAT(WhyRefused(folder / "x.toml"), HasSubstr("--force"));
    EXPECT_EQ(WhyRefused(folder / "x.toml", true), "");
    WriteCalibration(folder / "x.toml", "name = \"robot_0\"\n");
    bool kept = false;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      kept = kept || ReadFile(entry.path(), 1000) == edited;
    EXPECT_TRUE(kept) << edited;
  }
}

TEST(Calibration, DevicesAndEmptyFilesAreNobodysWork) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "empty", "");
  EXPECT_EQ(WhyRefused(folder / "empty"), "");
  EXPECT_EQ(WhyRefused("/dev/null"), "");
  EXPECT_THAT(WhyRefused(folder / "none/x"), HasSubstr("there is no folder"));
}

}  // namespace
}  // namespace chequer
