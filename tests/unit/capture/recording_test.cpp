#include "capture/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <functional>
#include <stdexcept>
#include <string>

#include "capture/png.h"
#include "capture/recording_text.h"
#include "capture/recording_writer.h"
#include "core/file.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using test::ErrorOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// An image whose bytes all have one value, so that a frame can be told from another.
Image Filled(PixelFormat format, int width, int height, std::uint8_t value) {
  Image image(format, width, height);
  for (std::uint8_t& byte : image.bytes()) byte = value;
  return image;
}

RecordingInfo SmallInfo(PixelFormat format = PixelFormat::kBgr8) {
  RecordingInfo info;
  info.camera = "north \"1\"\n";
  info.width = 4;
  info.height = 2;
  info.pixel_format = format;
  info.fps = 59.94;
  return info;
}

RecordedFrame FrameAt(std::int64_t utc_us, std::int64_t monotonic_us, std::uint64_t sequence) {
  return {"", UtcTime(microseconds(utc_us)), MonotonicTime(microseconds(monotonic_us)), sequence};
}

void AddFrame(RecordingWriter& writer, const Image& image, const RecordedFrame& frame) {
  writer.Add(image.view(), frame.captured_utc, frame.captured_monotonic, frame.sequence);
}

TEST(Recording, WhatIsWrittenIsRead) {
  const test::TemporaryDirectory folder;
  RecordingInfo info = SmallInfo();
  info.tone_curve = ToneCurve::Gamma(2.2);
  info.calibration = "camera.toml";
  info.truth = "truth.jsonl";
  RecordingWriter writer(folder / "a/b", info);
  AddFrame(writer, Filled(PixelFormat::kBgr8, 4, 2, 10), FrameAt(1000, 50, 7));
  AddFrame(writer, Filled(PixelFormat::kBgr8, 4, 2, 20), FrameAt(900, 60, 9));
  writer.Finish();
  EXPECT_EQ(writer.size(), 2u);

  const Recording recording = OpenRecording(folder / "a/b");
  EXPECT_EQ(recording.info.camera, info.camera);
  EXPECT_EQ(recording.info.width, 4);
  EXPECT_EQ(recording.info.height, 2);
  EXPECT_EQ(recording.info.pixel_format, PixelFormat::kBgr8);
  EXPECT_EQ(recording.info.tone_curve, ToneCurve::Gamma(2.2));
  EXPECT_EQ(recording.info.fps, 59.94);
  EXPECT_EQ(recording.info.calibration, "camera.toml");
  EXPECT_EQ(recording.info.truth, "truth.jsonl");
  ASSERT_EQ(recording.frames.size(), 2u);
  EXPECT_EQ(recording.frames[1].captured_utc, UtcTime(microseconds(900)));
  EXPECT_EQ(recording.frames[1].captured_monotonic, MonotonicTime(microseconds(60)));
  EXPECT_EQ(recording.frames[1].sequence, 9u);
  const Image second = LoadFrame(recording, 1);
  EXPECT_EQ(second.bytes()[23], 20);
  EXPECT_EQ(second.view().tone_curve(), ToneCurve::Gamma(2.2));
}

TEST(Recording, RawFilesHoldEveryFormat) {
  for (int i = 0; i <= static_cast<int>(PixelFormat::kYuv444p); ++i) {
    const auto format = static_cast<PixelFormat>(i);
    const test::TemporaryDirectory folder;
    RecordingInfo info = SmallInfo(format);
    info.yuv_range = YuvRange::kLimited;
    RecordingWriter writer(folder.path(), info, {FrameFileKind::kRaw, {}});
    Image image(format, 4, 2, ToneCurve::Srgb(), YuvRange::kLimited);
    for (std::size_t byte = 0; byte < image.bytes().size(); ++byte)
      image.bytes()[byte] = static_cast<std::uint8_t>(3 * byte);
    AddFrame(writer, image, FrameAt(0, 0, 0));
    const Image read = LoadFrame(OpenRecording(folder.path()), 0);
    EXPECT_EQ(read.format(), format);
    EXPECT_EQ(std::vector<int>(read.bytes().begin(), read.bytes().end()),
              std::vector<int>(image.bytes().begin(), image.bytes().end()));
    if (IsYuv(format)) {
      EXPECT_EQ(read.view().yuv_range(), YuvRange::kLimited);
    }
  }
}

TEST(Recording, PngHoldsBayerAndJpegHoldsPlanarYuv) {
  const test::TemporaryDirectory folder;
  RecordingWriter bayer(folder / "bayer", SmallInfo(PixelFormat::kBayerGr8));
  AddFrame(bayer, Filled(PixelFormat::kBayerGr8, 4, 2, 30), FrameAt(0, 0, 0));
  EXPECT_EQ(LoadFrame(OpenRecording(folder / "bayer"), 0).format(), PixelFormat::kBayerGr8);
  RecordingWriter yuv(folder / "yuv", SmallInfo(PixelFormat::kYuv422p), {FrameFileKind::kJpeg, {}});
  AddFrame(yuv, Filled(PixelFormat::kYuv422p, 4, 2, 128), FrameAt(0, 0, 0));
  EXPECT_EQ(LoadFrame(OpenRecording(folder / "yuv"), 0).format(), PixelFormat::kYuv422p);
}

TEST(Recording, FileKindsThatWouldLoseSomethingAreRefused) {
  EXPECT_EQ(CheckFrameFiles(FrameFileKind::kPng, PixelFormat::kBgr8, YuvRange::kFull), "");
  EXPECT_THAT(CheckFrameFiles(FrameFileKind::kPng, PixelFormat::kYuyv, YuvRange::kFull),
              HasSubstr("YUYV needs raw files"));
  EXPECT_THAT(CheckFrameFiles(FrameFileKind::kPng, PixelFormat::kYuv420p, YuvRange::kFull),
              HasSubstr("YUV420P needs raw files or JPEG"));
  EXPECT_THAT(CheckFrameFiles(FrameFileKind::kJpeg, PixelFormat::kBayerRg8, YuvRange::kFull),
              HasSubstr("BayerRG8 needs PNG or raw files"));
  EXPECT_THAT(CheckFrameFiles(FrameFileKind::kJpeg, PixelFormat::kYuv420p, YuvRange::kLimited),
              HasSubstr("full range; YUV420P needs raw files"));
  const test::TemporaryDirectory folder;
  EXPECT_THAT(ErrorOf([&] { RecordingWriter(folder.path(), SmallInfo(PixelFormat::kNv12)); }),
              HasSubstr("NV12 needs raw files"));
}

TEST(Recording, ALineThatWasBeingWrittenIsLeftOut) {
  const std::string whole = "file,utc_us,monotonic_us,sequence\n0.png,1,2,3\n";
  EXPECT_EQ(ParseFrameIndex(whole + "1.png,4,5,60", "frames.csv").size(), 1u);
  EXPECT_EQ(ParseFrameIndex(whole + "1.png,4", "frames.csv").size(), 1u);
  EXPECT_EQ(ParseFrameIndex(whole + "1.png,4,5,60\n", "frames.csv").size(), 2u);
  EXPECT_EQ(ParseFrameIndex("file,utc", "frames.csv").size(), 0u);
}

TEST(Recording, AFullDiskNamesThePathAndLeavesWhatWasThere) {
  const test::TemporaryDirectory folder;
  RecordingInfo info = SmallInfo(PixelFormat::kMono8);
  info.width = info.height = 100;
  RecordingWriter writer(folder.path(), info, {FrameFileKind::kRaw, {}});
  const Image image = Filled(PixelFormat::kMono8, 100, 100, 1);
  AddFrame(writer, image, FrameAt(1, 1, 1));
  // A limit on the size of files stands in for a full disk: write(2) fails, here with EFBIG.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{5000, before.rlim_max};
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = ErrorOf([&] { AddFrame(writer, image, FrameAt(2, 2, 2)); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, previous);
  EXPECT_THAT(error, HasSubstr((folder / "000001.raw").string() + ": cannot be written: File too large"));
  EXPECT_FALSE(std::filesystem::exists(folder / "000001.raw"));
  AddFrame(writer, image, FrameAt(3, 3, 3));
  EXPECT_EQ(OpenRecording(folder.path()).frames.size(), 2u);
}

TEST(Recording, AnIndexLineThatDoesNotFitIsTakenBack) {
  const test::TemporaryDirectory folder;
  RecordingWriter writer(folder.path(), SmallInfo(PixelFormat::kMono8), {FrameFileKind::kRaw, {}});
  const Image image = Filled(PixelFormat::kMono8, 4, 2, 1);
  AddFrame(writer, image, FrameAt(1, 1, 1));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{std::filesystem::file_size(folder / kFrameIndexFile) + 5, before.rlim_max};
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = ErrorOf([&] { AddFrame(writer, image, FrameAt(2, 2, 2)); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, previous);
  EXPECT_THAT(error, HasSubstr("frames.csv: cannot be written: "));
  AddFrame(writer, image, FrameAt(3, 3, 3));
  const Recording recording = OpenRecording(folder.path());
  ASSERT_EQ(recording.frames.size(), 2u);
  EXPECT_EQ(recording.frames[1].sequence, 3u);
}

TEST(RecordingWriter, DoesNotWriteOverARecording) {
  const test::TemporaryDirectory folder;
  RecordingWriter(folder.path(), SmallInfo());
  EXPECT_THAT(ErrorOf([&] { RecordingWriter(folder.path(), SmallInfo()); }), HasSubstr("already holds a recording"));
}

TEST(RecordingWriter, DoesNotWriteAmongOtherFiles) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "000000.png", "a picture");
  EXPECT_THAT(ErrorOf([&] { RecordingWriter(folder.path(), SmallInfo()); }), HasSubstr("is not empty"));
  EXPECT_EQ(ReadFile(folder / "000000.png", 100), "a picture");
}

TEST(RecordingWriter, CopiesEncodedFrames) {
  const test::TemporaryDirectory folder;
  RecordingWriter writer(folder.path(), SmallInfo());
  const auto file = PngFromImage(Filled(PixelFormat::kBgr8, 4, 2, 77).view());
  EXPECT_EQ(writer.AddEncoded(file, {}, MonotonicTime(microseconds(1)), 1), "000000.png");
  EXPECT_EQ(LoadFrame(OpenRecording(folder.path()), 0).bytes()[5], 77);
}

TEST(RecordingWriter, NamesAFolderThatCannotBeMade) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "x", "");
  EXPECT_THAT(ErrorOf([&] { RecordingWriter(folder / "x/y", SmallInfo()); }), HasSubstr("x/y: cannot be made: "));
}

TEST(RecordingWriter, RefusesWhatItCouldNotRead) {
  const test::TemporaryDirectory folder;
  RecordingInfo info = SmallInfo();
  info.truth = "../truth.jsonl";
  EXPECT_THAT(ErrorOf([&] { RecordingWriter(folder / "a", info); }), HasSubstr("../truth.jsonl: must be the name"));
  info = SmallInfo();
  info.fps = 0;
  EXPECT_THAT(ErrorOf([&] { RecordingWriter(folder / "a", info); }), HasSubstr("fps must be from 0.001 to 10000"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a"));
  RecordingWriter writer(folder / "b", SmallInfo());
  const Image image = Filled(PixelFormat::kBgr8, 4, 2, 1);
  AddFrame(writer, image, FrameAt(1, 5, 5));
  EXPECT_THAT(ErrorOf([&] { AddFrame(writer, image, FrameAt(1, 5, 6)); }), HasSubstr("must grow from frame to frame"));
  EXPECT_THAT(ErrorOf([&] { AddFrame(writer, image, FrameAt(1, 6, 5)); }), HasSubstr("must grow from frame to frame"));
}

std::string InfoError(const std::string& text) {
  return ErrorOf([&] { ParseRecordingInfo(TomlFile::Parse(text, "recording.toml")); });
}

TEST(RecordingInfo, EveryErrorSaysWhatWouldBeRight) {
  const std::string good =
      "[recording]\nwidth = 4\nheight = 2\nfps = 30\npixel_format = \"BGR8\"\n";  // camera has a default
  EXPECT_EQ(InfoError(good), "no error");
  EXPECT_EQ(InfoError(good + "truth = \"/etc/passwd\"\n"),
            "recording.toml:6: recording.truth = '/etc/passwd': must be the name of a file in the recording's folder, "
            "without \"..\" or a leading /");
  EXPECT_THAT(InfoError(good + "calibration = \"a/../../b\"\n"),
              HasSubstr("recording.calibration = 'a/../../b': must"));
  EXPECT_THAT(InfoError(good + "gamma = 9\n"), HasSubstr("recording.gamma = 9: must be from 0.2 to 5"));
  EXPECT_THAT(InfoError(good + "yuv_range = \"half\"\n"), HasSubstr("must be \"full\" or \"limited\""));
  EXPECT_THAT(InfoError(good + "size = 3\n"), HasSubstr("recording.toml:6: recording.size: unknown key"));
  EXPECT_THAT(InfoError("[recording]\nwidth = 4\nheight = 2\nfps = 30\npixel_format = \"bgr\""),
              HasSubstr("recording.pixel_format = 'bgr': must be one of Mono8, BGR8"));
  EXPECT_THAT(InfoError("[recording]\nwidth = 5\nheight = 2\nfps = 30\npixel_format = \"YUYV\""),
              HasSubstr("needs an even width"));
  EXPECT_THAT(InfoError("[recording]\nwidth = 5\nheight = 2\n"), HasSubstr("recording.pixel_format: is missing"));
  EXPECT_THAT(InfoError(""), HasSubstr("recording.width: is missing"));
}

std::string IndexError(const std::string& lines) {
  return ErrorOf([&] { ParseFrameIndex("file,utc_us,monotonic_us,sequence\n" + lines + "\n", "frames.csv"); });
}

TEST(FrameIndex, EveryErrorNamesTheLine) {
  EXPECT_EQ(IndexError("0.png,1,2,3"), "no error");
  EXPECT_EQ(IndexError("0.png,1,2,3\r\n1.png,2,3,4\r"), "no error");
  EXPECT_EQ(IndexError("0.png,1,2"), "frames.csv:2: must have the 4 fields file,utc_us,monotonic_us,sequence");
  EXPECT_EQ(IndexError("0.png,1,2,3,4"), "frames.csv:2: must have the 4 fields file,utc_us,monotonic_us,sequence");
  EXPECT_THAT(IndexError(""), HasSubstr("frames.csv:2: file: must be the name of a file"));
  EXPECT_THAT(IndexError("0.png,1,2,3\n../1.png,2,3,4"), HasSubstr("frames.csv:3: file: must be the name of a file"));
  EXPECT_THAT(IndexError("/dev/zero,2,3,4"), HasSubstr("without \"..\" or a leading /"));
  EXPECT_THAT(IndexError("a/./b.png,2,3,4"), HasSubstr("without \"..\" or a leading /"));
  EXPECT_THAT(IndexError("a\x01.png,2,3,4"), HasSubstr("control characters"));
  EXPECT_THAT(IndexError("0.png,-1,2,3"), HasSubstr("frames.csv:2: utc_us = -1: must be a whole number from 0 to"));
  EXPECT_THAT(IndexError("0.png,1e3,2,3"), HasSubstr("utc_us = 1e3: must be a whole number"));
  EXPECT_THAT(IndexError("0.png,99999999999999999999,2,3"), HasSubstr("utc_us = 99999999999999999999: must be"));
  EXPECT_THAT(
      IndexError("0.png,1,2,3\n1.png,1,2,4"),
      HasSubstr("frames.csv:3: monotonic_us = 2: must be a whole number from 3 (one more than in the line before)"));
  EXPECT_THAT(IndexError("0.png,1,2,3\n1.png,1,3,3"),
              HasSubstr("frames.csv:3: sequence = 3: must be a whole number from 4"));
  EXPECT_EQ(ErrorOf([] { ParseFrameIndex("0.png,1,2,3\n", "frames.csv"); }),
            "frames.csv:1: must be the line file,utc_us,monotonic_us,sequence");
}

TEST(FrameIndex, AHundredThousandFramesAreReadAtOnce) {
  std::string text = "file,utc_us,monotonic_us,sequence\n";
  for (std::uint64_t i = 0; i < 100'000; ++i)
    text += FormatFrameLine({std::to_string(i) + ".png", UtcTime(microseconds(i)), MonotonicTime(microseconds(i)), i});
  const auto frames = ParseFrameIndex(text, "frames.csv");
  ASSERT_EQ(frames.size(), 100'000u);
  EXPECT_EQ(frames.back().file, "99999.png");
  EXPECT_EQ(frames.back().sequence, 99'999u);
}

TEST(OpenRecording, SaysWhatIsMissing) {
  const test::TemporaryDirectory folder;
  EXPECT_THAT(ErrorOf([&] { OpenRecording(folder / "gone"); }), HasSubstr("gone: cannot be opened: No such file"));
  EXPECT_THAT(ErrorOf([&] { OpenRecording(folder.path()); }),
              HasSubstr("holds neither recording.toml nor images (PNG, JPEG, BMP, PGM, PPM)"));
  WriteFileAtomically(folder / kRecordingFile, FormatRecordingInfo(SmallInfo()));
  EXPECT_THAT(ErrorOf([&] { OpenRecording(folder.path()); }), HasSubstr("frames.csv: cannot be opened: No such file"));
  WriteFileAtomically(folder / kFrameIndexFile, std::string(kFrameIndexHeader) + "\n");
  EXPECT_THAT(ErrorOf([&] { OpenRecording(folder.path()); }), HasSubstr("frames.csv: lists no frame"));
}

TEST(OpenRecording, APlainFolderPlaysInTheOrderPeopleCount) {
  const test::TemporaryDirectory folder;
  for (const char* name : {"10.png", "9.png", "a2.png", "a10.png", "a02b.png", "note.txt"})
    WriteFileAtomically(folder / name, PngFromImage(Filled(PixelFormat::kMono8, 4, 2, 5).view()));
  PlainImageOptions options;
  options.fps = 20;
  options.one_channel = PixelFormat::kBayerRg8;
  options.tone_curve = ToneCurve::Linear();
  const Recording recording = OpenRecording(folder.path(), options);
  std::vector<std::string> names;
  for (const RecordedFrame& frame : recording.frames)
    names.push_back(std::filesystem::path(frame.file).filename().string());
  EXPECT_THAT(names, ElementsAre("9.png", "10.png", "a2.png", "a02b.png", "a10.png"));
  EXPECT_EQ(recording.info.pixel_format, PixelFormat::kBayerRg8);
  EXPECT_EQ(recording.info.width, 4);
  EXPECT_EQ(recording.frames[3].captured_monotonic, MonotonicTime(microseconds(150'000)));
  EXPECT_EQ(recording.frames[3].sequence, 3u);
  const Image image = LoadFrame(recording, 4);
  EXPECT_EQ(image.format(), PixelFormat::kBayerRg8);
  EXPECT_EQ(image.view().tone_curve(), ToneCurve::Linear());
}

TEST(OpenRecording, ASingleImageIsARecordingOfOne) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "x.png", PngFromImage(Filled(PixelFormat::kBgr8, 4, 2, 5).view()));
  const Recording recording = OpenRecording(folder / "x.png");
  ASSERT_EQ(recording.frames.size(), 1u);
  EXPECT_EQ(LoadFrame(recording, 0).width(), 4);
  EXPECT_THAT(ErrorOf([] { RecordingOfImages({}); }), HasSubstr("no images are given"));
}

TEST(LoadFrame, NamesTheFileThatDoesNotFit) {
  const test::TemporaryDirectory folder;
  RecordingWriter writer(folder.path(), SmallInfo());
  for (int i = 0; i < 3; ++i)
    AddFrame(writer, Filled(PixelFormat::kBgr8, 4, 2, 9), FrameAt(i, i, static_cast<unsigned>(i)));
  std::filesystem::remove(folder / "000000.png");
  WriteFileAtomically(folder / "000001.png", PngFromImage(Filled(PixelFormat::kMono8, 4, 4, 5).view()));
  std::filesystem::resize_file(folder / "000002.png", 60);
  const Recording recording = OpenRecording(folder.path());
  EXPECT_THAT(ErrorOf([&] { LoadFrame(recording, 0); }), HasSubstr("000000.png: cannot be opened: No such file"));
  EXPECT_THAT(ErrorOf([&] { LoadFrame(recording, 1); }),
              HasSubstr("000001.png: holds 4 x 4 Mono8, the recording is 4 x 2 BGR8"));
  EXPECT_THAT(ErrorOf([&] { LoadFrame(recording, 2); }), HasSubstr("000002.png: unusable PNG file: it is truncated"));
}

}  // namespace
}  // namespace chequer
