#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "capture/recording.h"
#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "core/file.h"
#include "simulate/truth.h"
#include "support/temporary_directory.h"
#include "tools/commands.h"
#include "tools/convert_job.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

void RunConvert(std::vector<std::string> arguments) {
  CLI::App app;
  AddConvertCommand(app);
  arguments.insert(arguments.begin(), "convert");
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
}

/// What it throws.
std::string ConvertError(const std::vector<std::string>& arguments) {
  try {
    RunConvert(arguments);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no error";
}

class ConvertCommand : public ::testing::Test {
 protected:
  std::string In() const { return (folder_ / "in").string(); }
  std::string Out(const char* name = "out") const { return (folder_ / name).string(); }

  /// 8 × 4, smooth colours, frame i brighter by i; with camera file and truth, 1 ms apart, every second number lost.
  void WriteInput(PixelFormat format, FrameFileKind kind, int frames) {
    RecordingInfo info;
    info.camera = "north";
    info.width = 8;
    info.height = 4;
    info.pixel_format = format;
    info.tone_curve = ToneCurve::Linear();
    info.fps = 50;
    info.calibration = "lens.toml";
    info.truth = "where.jsonl";
    RecordingWriter writer(folder_ / "in", info, {kind, {}});
    std::vector<FrameTruth> truth;
    for (int i = 0; i < frames; ++i) {
      Image image(format, 8, 4, info.tone_curve);
      for (std::size_t b = 0; b < image.bytes().size(); ++b)
        image.bytes()[b] = static_cast<std::uint8_t>(100 + static_cast<std::size_t>(i) + b / 24);
      FrameTruth frame;
      frame.file = writer.Add(image.view(), UtcTime(microseconds(5000 + i)), MonotonicTime(microseconds(1000 * i)),
                              static_cast<std::uint64_t>(2 * i));
      frame.markers.emplace_back().id = static_cast<std::uint64_t>(i);
      truth.push_back(frame);
    }
    CameraModel camera;
    camera.width = 8;
    camera.height = 4;
    camera.fx = 12.5;
    WriteCamera(folder_ / "in/lens.toml", camera);
    WriteTruth(folder_ / "in/where.jsonl", truth);
  }

  test::TemporaryDirectory folder_;
};

TEST_F(ConvertCommand, KeepsTimesSequenceCalibrationAndTruthOfTheFramesChosen) {
  WriteInput(PixelFormat::kBgr8, FrameFileKind::kPng, 6);
  RunConvert({In(), "--out", Out(), "--frames", "1-5", "--every", "2"});
  const Recording out = OpenRecording(Out());
  EXPECT_EQ(out.info.camera, "north");
  EXPECT_EQ(out.info.fps, 50);
  EXPECT_EQ(out.info.tone_curve, ToneCurve::Linear());
  ASSERT_EQ(out.frames.size(), 3u);
  EXPECT_EQ(out.frames[1].captured_utc, UtcTime(microseconds(5003)));
  EXPECT_EQ(out.frames[1].captured_monotonic, MonotonicTime(microseconds(3000)));
  EXPECT_EQ(out.frames[1].sequence, 6u);
  EXPECT_EQ(LoadFrame(out, 1).bytes()[0], 103);
  EXPECT_EQ(LoadCamera(folder_ / "out" / out.info.calibration).fx, 12.5);
  const auto truth = ReadTruth(folder_ / "out" / out.info.truth);
  ASSERT_EQ(truth.size(), 3u);
  EXPECT_EQ(truth[1].file, out.frames[1].file);
  EXPECT_EQ(truth[1].markers[0].id, 3u);
}

TEST_F(ConvertCommand, FilesThatStayTheSameAreCopied) {
  WriteInput(PixelFormat::kYuv420p, FrameFileKind::kJpeg, 2);
  RunConvert({In(), "--out", Out()});
  EXPECT_EQ(ReadFile(folder_ / "out/000001.jpg", 10000), ReadFile(folder_ / "in/000001.jpg", 10000));
  RunConvert({In(), "--out", Out("worse"), "--quality", "5"});
  EXPECT_NE(ReadFile(folder_ / "worse/000001.jpg", 10000), ReadFile(folder_ / "in/000001.jpg", 10000));
}

TEST_F(ConvertCommand, EveryPixelFormatCanBeAskedFor) {
  WriteInput(PixelFormat::kBgr8, FrameFileKind::kPng, 1);
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i) {
    const std::string name(PixelFormatName(static_cast<PixelFormat>(i)));
    RunConvert({In(), "--out", Out(name.c_str()), "--pixel-format", name});
    const Recording out = OpenRecording(Out(name.c_str()));
    EXPECT_EQ(PixelFormatName(out.info.pixel_format), name);
    EXPECT_EQ(PixelFormatName(LoadFrame(out, 0).format()), name);
    RunConvert({Out(name.c_str()), "--out", Out((name + "back").c_str()), "--pixel-format", "BGR8"});
    EXPECT_NEAR(LoadFrame(OpenRecording(Out((name + "back").c_str())), 0).bytes()[50], 102, 2) << name;
  }
}

TEST_F(ConvertCommand, TheRangeOfYuvCanBeChanged) {
  WriteInput(PixelFormat::kBgr8, FrameFileKind::kPng, 1);
  RunConvert({In(), "--out", Out(), "--pixel-format", "YUYV", "--yuv-range", "limited"});
  EXPECT_EQ(OpenRecording(Out()).info.yuv_range, YuvRange::kLimited);
  EXPECT_EQ(LoadFrame(OpenRecording(Out()), 0).bytes()[0], 102);  // 16 + 100 · 219 / 255
}

TEST_F(ConvertCommand, RecordingsBecomeImagesAndImagesRecordings) {
  WriteInput(PixelFormat::kYuyv, FrameFileKind::kRaw, 3);
  RunConvert({In(), "--images", "--out", Out("pictures")});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "pictures/recording.toml"));
  EXPECT_EQ(LoadImage(folder_ / "pictures/000002.png").format(), PixelFormat::kBgr8);
  RunConvert({Out("pictures"), "--out", Out("again"), "--fps", "4", "--gamma", "2.2", "--camera", "south",
              "--calibration", (folder_ / "in/lens.toml").string()});
  const Recording again = OpenRecording(Out("again"));
  EXPECT_EQ(again.info.camera, "south");
  EXPECT_EQ(again.info.fps, 4);
  EXPECT_EQ(again.info.tone_curve, ToneCurve::Gamma(2.2));
  EXPECT_EQ(again.frames[2].captured_monotonic, MonotonicTime(microseconds(500'000)));
  EXPECT_EQ(LoadCamera(folder_ / "again/camera.toml").fx, 12.5);
}

TEST_F(ConvertCommand, OneImageBecomesAnother) {
  WriteInput(PixelFormat::kMono8, FrameFileKind::kPng, 2);
  RunConvert({In() + "/000001.png", "--one-channel", "BayerRG8", "--pixel-format", "BGR8", "--out", Out("x.png")});
  EXPECT_EQ(LoadImage(folder_ / "x.png").format(), PixelFormat::kBgr8);
  RunConvert({In(), "--frames", "1", "--out", Out("y.jpg"), "--quality", "100"});
  EXPECT_NEAR(LoadImage(folder_ / "y.jpg").bytes()[0], 101, 1);
}

TEST_F(ConvertCommand, SeveralImagesAreARecordingInTheirOrder) {
  WriteInput(PixelFormat::kMono8, FrameFileKind::kPng, 3);
  RunConvert({In() + "/000002.png", In() + "/000000.png", "--out", Out()});
  const Recording out = OpenRecording(Out());
  EXPECT_EQ(LoadFrame(out, 0).bytes()[0], 102);
  EXPECT_EQ(LoadFrame(out, 1).bytes()[0], 100);
}

TEST_F(ConvertCommand, AFrameThatCannotBeReadIsLeftOutAndTheStatusSaysSo) {
  WriteInput(PixelFormat::kMono8, FrameFileKind::kPng, 3);
  std::filesystem::remove(folder_ / "in/000001.png");
  ::testing::internal::CaptureStderr();
  EXPECT_THROW(RunConvert({In(), "--out", Out()}), CLI::RuntimeError);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("in/000001.png: cannot be opened: No such file"));
  const Recording out = OpenRecording(Out());
  ASSERT_EQ(out.frames.size(), 2u);
  EXPECT_EQ(out.frames[1].sequence, 4u);
  const auto truth = ReadTruth(folder_ / "out/truth.jsonl");
  ASSERT_EQ(truth.size(), 2u);
  EXPECT_EQ(truth[1].markers[0].id, 2u);
}

TEST_F(ConvertCommand, EveryErrorSaysWhatWouldBeRight) {
  WriteInput(PixelFormat::kBgr8, FrameFileKind::kPng, 3);
  const auto error = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {In(), "--out", Out()});
    return ConvertError(more);
  };
  EXPECT_THAT(error({"--frames", "1-3"}), HasSubstr("--frames: 1-3: must lie in 0-2"));
  EXPECT_THAT(error({"--frames", "2-1"}), HasSubstr("must lie in 0-2"));
  EXPECT_THAT(error({"--frames", "a"}), HasSubstr("--frames: a: must be FIRST-LAST or one number"));
  EXPECT_THAT(error({"--every", "0"}), HasSubstr("--every: must be at least 1"));
  EXPECT_THAT(error({"--pixel-format", "bgr"}), HasSubstr("--pixel-format: bgr: must be one of Mono8, BGR8"));
  EXPECT_THAT(error({"--pixel-format", "NV12", "--files", "png"}), HasSubstr("--files: PNG files hold"));
  EXPECT_THAT(error({"--files", "gif"}), HasSubstr("--files: gif: must be one of png, jpeg, raw"));
  EXPECT_THAT(error({"--files", "png", "--quality", "9"}), HasSubstr("--quality: is for JPEG files"));
  EXPECT_THAT(error({"--quality", "0"}), HasSubstr("--quality: must be from 1 to 100"));
  EXPECT_THAT(error({"--chroma", "411"}), HasSubstr("--chroma: 411: must be one of 444, 422, 420"));
  EXPECT_THAT(error({"--yuv-range", "full"}), HasSubstr("--yuv-range: needs a YUV --pixel-format"));
  EXPECT_THAT(error({"--pixel-format", "YUYV", "--yuv-range", "all"}), HasSubstr("all: must be one of full, limited"));
  EXPECT_THAT(error({"--fps", "9"}), HasSubstr("--fps: is for images alone: a recording says it itself"));
  EXPECT_THAT(error({"--gamma", "9"}), HasSubstr("--gamma: must be from 0.2 to 5"));
  EXPECT_THAT(error({"--fps", "0"}), HasSubstr("--fps: must be from 0.001 to 10000"));
  EXPECT_THAT(error({"--one-channel", "BGR8"}), HasSubstr("--one-channel: BGR8: must be Mono8, BayerRG8"));
  EXPECT_THAT(error({"--images", "--files", "raw"}), HasSubstr("--files: raw files are no images"));
  EXPECT_THAT(error({"--images", "--camera", "x"}), HasSubstr("--camera: is for recordings"));
  EXPECT_THAT(error({"--camera", ""}), HasSubstr("--camera: must have 1 to 100 characters"));
  EXPECT_THAT(error({"--calibration", "/gone.toml"}), HasSubstr("/gone.toml: cannot be opened"));
  EXPECT_FALSE(std::filesystem::exists(Out()));
  EXPECT_THAT(ConvertError({In(), "--out", Out("x.png")}), HasSubstr("is one image, the input has 3 frames"));
  EXPECT_THAT(ConvertError({In(), "--out", Out("x.bmp")}), HasSubstr("written as .png, .jpg or .jpeg"));
  EXPECT_THAT(ConvertError({In(), "--frames", "1", "--files", "png", "--out", Out("x.png")}),
              HasSubstr("--files: is for folders"));
  EXPECT_THAT(ConvertError({In(), "--frames", "1", "--pixel-format", "NV12", "--out", Out("x.png")}),
              HasSubstr("--out: PNG files hold"));
  EXPECT_THAT(ConvertError({In(), "--out", In()}), HasSubstr("already holds a recording"));
  EXPECT_THAT(ConvertError({In(), "--images", "--out", In()}), HasSubstr("is not empty"));
  EXPECT_THAT(ConvertError({Out("gone"), "--out", Out()}), HasSubstr("gone: cannot be opened"));
  EXPECT_THAT(ConvertError({In() + "/000000.png", In(), "--out", Out("y")}), HasSubstr("in is a folder: of several"));
}

TEST_F(ConvertCommand, ALogIsNoRecording) {
  WriteFileAtomically(folder_ / "log", "\xed\xa1\xda\x01");
  EXPECT_THAT(ConvertError({Out("log"), "--out", Out(), "--frames", "1"}), HasSubstr("the input is an LCM log"));
}

TEST(KindOf, LooksAtTheName) {
  EXPECT_EQ(KindOf("a.PNG"), FrameFileKind::kPng);
  EXPECT_EQ(KindOf("a.JPG"), FrameFileKind::kJpeg);
  EXPECT_EQ(KindOf("a.jpeg"), FrameFileKind::kJpeg);
  EXPECT_EQ(KindOf("a.raw"), FrameFileKind::kRaw);
  EXPECT_EQ(KindOf("a.bmp"), FrameFileKind::kPng);
}

}  // namespace
}  // namespace chequer
