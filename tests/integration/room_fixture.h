#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "support/process.h"
#include "support/room.h"
#include "support/temporary_directory.h"

namespace chequer::test {

/// Of the recording of the robots that drive.
inline constexpr int kDriveFrames = 10;
inline constexpr double kDriveFps = 20;

/// The room as recorded and calibrated, once for all tests of the program.
class Room : public ::testing::Test {
 protected:
  static std::string Run(std::vector<std::string> arguments, int expected_status = 0) {
    arguments.insert(arguments.begin(), CHEQUER);
    Process process(std::move(arguments));
    EXPECT_EQ(process.Wait(std::chrono::seconds(120)), expected_status) << process.output();
    return process.output();
  }
  static std::string At(const std::string& name) { return (folder_->path() / name).string(); }

  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryDirectory>();
    RecordSheet(At("sheet"), 24, 1);
    RecordReferences(At("empty"), 8, 2);
    RecordDrive(At("drive"), kDriveFrames, kDriveFps, 3);
    WriteReferenceList(At("references.toml"));
    lens_output_ =
        Run({"calibrate", "lens", "--side", "12cm", "--ids", "200-219", At("sheet"), "--out", At("camera.toml")});
    world_output_ = Run({"calibrate", "world", "--calibration", At("camera.toml"), "--side", "12cm", "--references",
                         At("references.toml"), At("empty"), "--out", At("world.toml")});
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static inline std::unique_ptr<TemporaryDirectory> folder_;
  static inline std::string lens_output_, world_output_;
};

}  // namespace chequer::test
