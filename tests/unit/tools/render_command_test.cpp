#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "capture/recording.h"
#include "chequer/camera_file.h"
#include "simulate/truth.h"
#include "support/temporary_directory.h"
#include "tools/commands.h"

namespace chequer {
namespace {

void RunRender(std::vector<std::string> arguments) {
  CLI::App app;
  AddRenderCommand(app);
  arguments.insert(arguments.begin(), "render");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
}

std::vector<std::string> Small(const std::filesystem::path& folder, std::vector<std::string> more) {
  std::vector<std::string> arguments{"--size",         "320x240", "--focal", "250",   "--marker",
                                     "6x6:secded:0.2", "--swarm", "3",       "--out", folder.string(),
                                     "--frames",       "3",       "--fps",   "50"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(RenderCommand, WritesARecordingWithItsTruthAndCamera) {
  const test::TemporaryDirectory folder;
  RunRender(Small(folder / "out", {}));
  const Recording recording = OpenRecording(folder / "out");
  EXPECT_EQ(recording.info.width, 320);
  EXPECT_EQ(recording.info.fps, 50);
  ASSERT_EQ(recording.frames.size(), 3u);
  EXPECT_EQ(recording.frames[2].captured_utc - recording.frames[0].captured_utc, std::chrono::milliseconds(40));
  EXPECT_EQ(LoadCamera(folder / "out" / recording.info.calibration).fx, 250);
  const auto truth = ReadTruth(folder / "out" / recording.info.truth);
  ASSERT_EQ(truth.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(truth[i].file, recording.frames[i].file);
    EXPECT_EQ(truth[i].markers.size(), 3u);
    EXPECT_EQ(LoadFrame(recording, i).height(), 240);
  }
}

TEST(RenderCommand, EveryFormatIsReadBackAsItIs) {
  const test::TemporaryDirectory folder;
  for (const char* format : {"Mono8", "RGB8", "BayerGR8", "UYVY", "NV12", "YUV420P"}) {
    RunRender(Small(folder / format, {"--pixel-format", format, "--gamma", "1.8"}));
    const Recording recording = OpenRecording(folder / format);
    const Image image = LoadFrame(recording, 1);
    EXPECT_EQ(PixelFormatName(image.format()), format);
    EXPECT_EQ(image.view().tone_curve(), ToneCurve::Gamma(1.8));
  }
}

TEST(RenderCommand, SameSeedSameFrames) {
  const test::TemporaryDirectory folder;
  for (const char* seed : {"4", "4again", "5"})
    RunRender(Small(folder / seed, {"--seed", std::string(seed).substr(0, 1)}));
  const auto bytes = [&](const char* seed) {
    const Image image = LoadFrame(OpenRecording(folder / seed), 2);
    return std::vector<std::uint8_t>(image.bytes().begin(), image.bytes().end());
  };
  EXPECT_EQ(bytes("4"), bytes("4again"));
  EXPECT_NE(bytes("4"), bytes("5"));
}

TEST(RenderCommand, JpegFilesAreWritten) {
  const test::TemporaryDirectory folder;
  RunRender(Small(folder / "out", {"--jpeg", "80"}));
  const Recording recording = OpenRecording(folder / "out");
  EXPECT_THAT(recording.frames[0].file, ::testing::EndsWith(".jpg"));
  EXPECT_EQ(LoadFrame(recording, 0).width(), 320);
}

}  // namespace
}  // namespace chequer
