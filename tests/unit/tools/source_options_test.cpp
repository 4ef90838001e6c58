#include "tools/source_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "capture/recording.h"
#include "capture/recording_writer.h"
#include "chequer/camera_file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "tools/commands.h"
#include "tools/number_check.h"
#include "tools/record_limit.h"
#include "tools/undistort.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(CaptureText, IsTheTableThatTheOptionsMean) {
  SourceRequest request;
  request.device = "/dev/video0";
  request.pixel_format = "YUYV";
  request.size = "640x480";
  request.fps = 25;
  request.settings = {"gain=7", "auto_exposure=Manual Mode", "flip=true"};
  EXPECT_EQ(CaptureText(request),
            "[capture]\nsource = \"v4l2\"\ndevice = \"/dev/video0\"\npixel_format = \"YUYV\"\nwidth = 640\nheight = "
            "480\nfps = 25.0\n[capture.controls]\n\"gain\" = 7\n\"auto_exposure\" = \"Manual Mode\"\n\"flip\" = "
            "true\n");
}

TEST(CaptureText, TellsTheKindByTheDevice) {
  SourceRequest request;
  EXPECT_THAT(CaptureText(request), HasSubstr("\"v4l2\""));
  request.device = "Maker-Cam-\"1\"";
  request.settings = {"Gain=1.5"};
  EXPECT_THAT(CaptureText(request), HasSubstr("source = \"aravis\"\ndevice = \"Maker-Cam-\\\"1\\\"\""));
  EXPECT_THAT(CaptureText(request), HasSubstr("[capture.features]\n\"Gain\" = 1.5"));
  request.source = "v4l2";
  EXPECT_THAT(CaptureText(request), HasSubstr("source = \"v4l2\""));
}

TEST(CaptureText, WritesEveryNumberAsTomlReadsIt) {
  const auto text_of = [](const std::string& value) {
    SourceRequest request;
    request.settings = {"gain=" + value};
    const std::string text = CaptureText(request);
    return text.substr(text.find("= ", text.find("gain")) + 2);
  };
  EXPECT_EQ(text_of(".5"), "0.5\n");
  EXPECT_EQ(text_of("007"), "7\n");
  EXPECT_EQ(text_of("7.0"), "7.0\n");
  EXPECT_EQ(text_of("-3"), "-3\n");
  EXPECT_EQ(text_of("nan"), "\"nan\"\n");
  EXPECT_EQ(text_of("50 Hz"), "\"50 Hz\"\n");
  EXPECT_EQ(text_of("a\nb"), "\"a b\"\n");
}

TEST(ChooseSource, SaysWhatIsWrongWithoutLinesThatNobodyWrote) {
  SourceRequest request;
  request.device = "GV01";
  request.pixel_format = "FOO";
  EXPECT_THAT(test::ErrorOf([&] { ChooseSource(request); }),
              StartsWith("capture.pixel_format = 'FOO': must be one of"));
}

TEST(ChooseSource, KnowsTwoKindsOfCamera) {
  SourceRequest request;
  for (const char* source : {"replay", "usb"}) {
    request.source = source;
    EXPECT_THAT(test::ErrorOf([&] { ChooseSource(request); }), HasSubstr("must be v4l2 or aravis")) << source;
  }
}

TEST(IsAboveZero, SaysWhatANumberMustBe) {
  EXPECT_EQ(IsAboveZero("0.1"), "");
  EXPECT_EQ(IsAboveZero("7"), "");
  for (const char* wrong : {"0", "-1", "nan", "inf", "x", "1x", ""})
    EXPECT_EQ(IsAboveZero(wrong), std::string("'") + wrong + "' must be a number above 0");
}

TEST(CaptureText, RefusesWhatIsNoSizeAndNoSetting) {
  for (const char* size : {"640", "640x", "x480", "640X480", "-1x5", "6400000x1"}) {
    SourceRequest request;
    request.size = size;
    EXPECT_THROW(CaptureText(request), CLI::ValidationError) << size;
  }
  for (const char* setting : {"gain", "=3", ""}) {
    SourceRequest request;
    request.settings = {setting};
    EXPECT_THROW(CaptureText(request), CLI::ValidationError) << setting;
  }
}

TEST(ChooseSource, RefusesAConfigurationWithOtherOptions) {
  SourceRequest request;
  request.config = "chequerd.toml";
  request.fps = 3;
  EXPECT_THROW(ChooseSource(request), CLI::ValidationError);
}

TEST(RecordLimit, ReadsUnits) {
  EXPECT_EQ(MakeRecordLimit(0, 0, "").bytes, std::nullopt);
  EXPECT_EQ(MakeRecordLimit(3, 0, "").frames, 3u);
  EXPECT_EQ(MakeRecordLimit(0, 1.5, "").seconds, 1.5);
  EXPECT_EQ(MakeRecordLimit(0, 0, "1500").bytes, 1500u);
  EXPECT_EQ(MakeRecordLimit(0, 0, "1.5k").bytes, 1500u);
  EXPECT_EQ(MakeRecordLimit(0, 0, "20G").bytes, 20'000'000'000u);
  for (const char* wrong : {"0", "-3M", "M", "3 M", "3MB", "1e99", "nan", "inf"})
    EXPECT_THROW(MakeRecordLimit(0, 0, wrong), CLI::ValidationError) << wrong;
}

/// Runs `chequer record` with a configuration that replays a recording of five frames.
class RecordTest : public ::testing::Test {
 protected:
  RecordTest() {
    RecordingInfo info;
    info.width = 8;
    info.height = 4;
    info.pixel_format = PixelFormat::kYuyv;
    info.fps = 20;
    FrameFileOptions raw;
    raw.kind = FrameFileKind::kRaw;
    RecordingWriter writer(Original(), info, raw);
    for (int i = 0; i < 5; ++i) {
      Image image(PixelFormat::kYuyv, 8, 4);
      std::fill(image.bytes().begin(), image.bytes().end(), static_cast<std::uint8_t>(40 * i));
      // The second frame was lost.
      writer.Add(image.view(), UtcTime(std::chrono::seconds(100 + i)), MonotonicTime(std::chrono::seconds(10 + i)),
                 static_cast<std::uint64_t>(i == 0 ? 0 : i + 1));
    }
    std::ofstream(folder_ / "camera.toml")
        << FormatCamera({.width = 8, .height = 4, .fx = 8, .fy = 8, .cx = 4, .cy = 2});
    std::ofstream(folder_ / "chequerd.toml")
        << "[camera]\nname = \"left\"\ncalibration = \"camera.toml\"\n[capture]\npath = \"original\"\npace = "
           "\"unlimited\"\ntimes = \"recorded\"\n[detect]\nthreads = 2\n";
  }

  std::filesystem::path Original() const { return folder_ / "original"; }

  Recording Record(std::vector<std::string> arguments) const {
    const std::filesystem::path out = folder_ / "out";
    CLI::App app;
    AddRecordCommand(app);
    arguments.insert(arguments.begin(),
                     {"record", "--config", (folder_ / "chequerd.toml").string(), "--out", out.string()});
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
    return OpenRecording(out);
  }

  test::TemporaryDirectory folder_;
};

TEST_F(RecordTest, KeepsTimesNumbersFormatAndPixels) {
  const Recording copy = Record({});
  const Recording original = OpenRecording(Original());
  ASSERT_EQ(copy.frames.size(), 5u);
  EXPECT_EQ(copy.info.camera, "left");
  EXPECT_EQ(copy.info.pixel_format, PixelFormat::kYuyv);
  EXPECT_EQ(LoadCamera(copy.folder / copy.info.calibration).fx, 8);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(copy.frames[i].captured_utc, original.frames[i].captured_utc);
    EXPECT_EQ(copy.frames[i].captured_monotonic, original.frames[i].captured_monotonic);
    EXPECT_EQ(copy.frames[i].sequence, original.frames[i].sequence);
    EXPECT_EQ(LoadFrame(copy, i).bytes()[0], LoadFrame(original, i).bytes()[0]);
  }
}

TEST_F(RecordTest, EndsAtALimitOfFrames) { EXPECT_EQ(Record({"--frames", "2"}).frames.size(), 2u); }

TEST_F(RecordTest, EndsAtALimitOfSeconds) { EXPECT_EQ(Record({"--seconds", "2.5"}).frames.size(), 4u); }

TEST_F(RecordTest, EndsAtALimitOfBytes) { EXPECT_EQ(Record({"--bytes", "150"}).frames.size(), 3u); }  // 64 a frame

TEST_F(RecordTest, WritesUndistortedCopies) {
  const std::filesystem::path straight = folder_ / "straight";
  Record({"--undistorted", straight.string()});
  const Recording recording = OpenRecording(straight);
  EXPECT_EQ(recording.frames.size(), 5u);
  EXPECT_EQ(recording.info.pixel_format, PixelFormat::kBgr8);
  EXPECT_EQ(LoadCamera(straight / recording.info.calibration).kind, CameraModel::Kind::kPinhole);
}

TEST_F(RecordTest, RefusesAFolderThatHoldsOne) {
  Record({});
  EXPECT_THROW(Record({}), std::runtime_error);
}

TEST_F(RecordTest, RefusesACalibrationForAnotherSize) {
  std::ofstream(folder_ / "other.toml") << FormatCamera({.width = 9, .height = 4, .fx = 8, .fy = 8, .cx = 4, .cy = 2});
  EXPECT_THROW(Record({"--calibration", (folder_ / "other.toml").string()}), std::runtime_error);
}

TEST(Undistorter, MovesPixelsToWhereAPinholeSeesThem) {
  CameraModel camera{.width = 200, .height = 100, .fx = 150, .fy = 150, .cx = 99.5, .cy = 49.5};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.3, 0.05, 0, 0, 0};
  const Eigen::Vector3d point(0.4, 0.2, 1);
  const Eigen::Vector2d seen = camera.Project(point);
  Image image(PixelFormat::kMono8, 200, 100);
  const int x = static_cast<int>(std::lround(seen.x())), y = static_cast<int>(std::lround(seen.y()));
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) image.bytes()[static_cast<std::size_t>((y + dy) * 200 + x + dx)] = 255;
  const Undistorter undistorter(camera);
  const Image straight = undistorter.Undistort(image.view());
  const Eigen::Vector2d expected = undistorter.pinhole().Project(point);
  EXPECT_GT((expected - seen).norm(), 3);
  const auto at = [&](const Eigen::Vector2d& pixel) {
    return straight.view().row(static_cast<int>(std::lround(pixel.y())))[3 * std::lround(pixel.x())];
  };
  EXPECT_GT(at(expected), 128);
  EXPECT_LT(at(seen), 128);
}

}  // namespace
}  // namespace chequer
