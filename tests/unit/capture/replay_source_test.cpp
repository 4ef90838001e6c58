#include "capture/replay_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <stdexcept>
#include <thread>

#include "capture/recording_text.h"
#include "core/file.h"
#include "small_recording.h"
#include "support/error_of.h"
#include "support/manual_clock.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ReplaySourceTest : public ::testing::Test {
 protected:
  ReplaySourceTest() { options_.path = folder_.path(); }

  /// Opened.
  std::unique_ptr<ReplaySource> Open() {
    auto source = std::make_unique<ReplaySource>(options_, clock_);
    EXPECT_EQ(source->Open(), "");
    return source;
  }

  test::TemporaryDirectory folder_;
  std::shared_ptr<test::ManualClock> clock_ = std::make_shared<test::ManualClock>();
  ReplayOptions options_;
};

TEST_F(ReplaySourceTest, PlaysAtTheRecordedTimesAndEnds) {
  test::WriteSmallRecording(folder_.path(), 3);
  const auto source = Open();
  const MonotonicTime start = clock_->Now();
  const UtcTime start_utc = clock_->NowUtc();
  for (int i = 0; i < 3; ++i) {
    const CaptureResult result = source->Next(1s);
    ASSERT_EQ(result.status, CaptureStatus::kFrame);
    EXPECT_EQ(result.frame.image.row(1)[3], i);
    EXPECT_EQ(result.frame.captured_monotonic, start + i * 10ms);
    EXPECT_EQ(result.frame.captured_utc, start_utc + i * 10ms);
    EXPECT_EQ(clock_->Now(), start + i * 10ms);
    EXPECT_EQ(result.frame.sequence, 100u + static_cast<unsigned>(i));
    EXPECT_EQ(result.frame.name, "00000" + std::to_string(i) + ".raw");
  }
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kEnd);
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kEnd);
}

TEST_F(ReplaySourceTest, PlaysAtAFixedRate) {
  test::WriteSmallRecording(folder_.path(), 3);
  options_.pace = ReplayPace::kFixedRate;
  options_.fps = 2;
  const auto source = Open();
  source->Next(1s);
  const MonotonicTime first = clock_->Now();
  EXPECT_EQ(source->Next(1s).frame.captured_monotonic, first + 500ms);
  EXPECT_EQ(source->Next(1s).frame.captured_monotonic, first + 1s);
}

TEST_F(ReplaySourceTest, SaysHowManyFramesASecondToExpect) {
  test::WriteSmallRecording(folder_.path(), 3);
  options_.fps = 2;
  options_.pace = ReplayPace::kRecorded;
  EXPECT_EQ(Open()->expected_rate_hz(), 100);
  options_.pace = ReplayPace::kFixedRate;
  EXPECT_EQ(Open()->expected_rate_hz(), 2);
  EXPECT_EQ(Open()->rate_hz(), 0) << "none is lost while it is away";
  options_.pace = ReplayPace::kUnlimited;
  EXPECT_EQ(Open()->expected_rate_hz(), 0);
}

TEST_F(ReplaySourceTest, PlaysAsFastAsItGoes) {
  test::WriteSmallRecording(folder_.path(), 3);
  options_.pace = ReplayPace::kUnlimited;
  const auto source = Open();
  const MonotonicTime start = clock_->Now();
  for (int i = 0; i < 3; ++i) {
    clock_->Advance(1h);  // being late loses nothing
    EXPECT_EQ(source->Next(0s).frame.captured_monotonic, clock_->Now());
  }
  EXPECT_EQ(clock_->Now(), start + 3h);
  EXPECT_EQ(source->frames_lost(), 0u);
  EXPECT_EQ(source->Next(0s).status, CaptureStatus::kEnd);
}

TEST_F(ReplaySourceTest, ALoopGoesOnInTimeAndSequence) {
  test::WriteSmallRecording(folder_.path(), 3);
  options_.loop = true;
  const auto source = Open();
  const MonotonicTime start = clock_->Now();
  for (int i = 0; i < 10; ++i) {
    const CaptureResult result = source->Next(1s);
    ASSERT_EQ(result.status, CaptureStatus::kFrame);
    EXPECT_EQ(result.frame.image.row(0)[0], i % 3);
    EXPECT_EQ(result.frame.captured_monotonic, start + i * 10ms);
    EXPECT_EQ(result.frame.sequence, 100u + static_cast<unsigned>(i));
  }
}

TEST_F(ReplaySourceTest, KeepsRecordedTimesIfAsked) {
  test::WriteSmallRecording(folder_.path(), 2);
  options_.loop = true;
  options_.times = ReplayTimes::kRecorded;
  const auto source = Open();
  for (int i = 0; i < 4; ++i) {
    const Frame frame = source->Next(1s).frame;
    EXPECT_EQ(frame.captured_monotonic, MonotonicTime(5s) + i * 10ms);
    EXPECT_EQ(frame.captured_utc, UtcTime(1'600'000'000s) + i * 10ms);
  }
}

TEST_F(ReplaySourceTest, GapsInTheRecordingStayGaps) {
  WriteFileAtomically(folder_ / kRecordingFile,
                      "[recording]\nwidth = 1\nheight = 1\npixel_format = \"Mono8\"\nfps = 10\n");
  WriteFileAtomically(folder_ / kFrameIndexFile, std::string(kFrameIndexHeader) + "\na.raw,0,0,5\na.raw,0,400000,9\n");
  WriteFileAtomically(folder_ / "a.raw", "x");
  options_.loop = true;
  const auto source = Open();
  std::vector<std::uint64_t> sequences;
  std::vector<std::int64_t> times_ms;
  const MonotonicTime start = clock_->Now();
  for (int i = 0; i < 4; ++i) {
    const Frame frame = source->Next(10s).frame;
    sequences.push_back(frame.sequence);
    times_ms.push_back(std::chrono::duration_cast<std::chrono::milliseconds>(frame.captured_monotonic - start).count());
  }
  EXPECT_THAT(sequences, ElementsAre(5, 9, 10, 14));
  EXPECT_THAT(times_ms, ElementsAre(0, 400, 800, 1200));
}

TEST_F(ReplaySourceTest, TimesOutBeforeTheFrameIsDueAndDeliversItLater) {
  test::WriteSmallRecording(folder_.path(), 2);
  const auto source = Open();
  const MonotonicTime start = clock_->Now();
  source->Next(1s);
  EXPECT_EQ(source->Next(4ms).status, CaptureStatus::kTimeout);
  EXPECT_EQ(clock_->Now(), start + 4ms);
  EXPECT_EQ(source->Next(5ms).status, CaptureStatus::kTimeout);
  const CaptureResult result = source->Next(1ms);
  ASSERT_EQ(result.status, CaptureStatus::kFrame);
  EXPECT_EQ(result.frame.captured_monotonic, start + 10ms);
}

TEST_F(ReplaySourceTest, ALateCallerGetsWhatTheBuffersHoldAndTheRestIsLost) {
  test::WriteSmallRecording(folder_.path(), 20);
  const auto source = Open();
  const MonotonicTime start = clock_->Now();
  source->Next(1s);
  clock_->Advance(105ms);  // frames 1 to 10 were due; 7, 8, 9 and 10 are in the buffers
  for (const int i : {7, 8, 9, 10}) {
    const Frame frame = source->Next(0s).frame;
    EXPECT_EQ(frame.sequence, 100u + static_cast<unsigned>(i));
    EXPECT_EQ(frame.image.row(0)[0], i);
    EXPECT_EQ(frame.captured_monotonic, start + i * 10ms);
  }
  EXPECT_EQ(source->frames_lost(), 6u);
  EXPECT_EQ(source->Next(0s).status, CaptureStatus::kTimeout);
  EXPECT_EQ(source->Next(1s).frame.sequence, 111u);
  clock_->Advance(1h);
  EXPECT_EQ(source->Next(0s).status, CaptureStatus::kEnd);
  EXPECT_EQ(source->frames_lost(), 6u + 8u);
}

TEST_F(ReplaySourceTest, AnInterruptionEndsOneWait) {
  test::WriteSmallRecording(folder_.path(), 2);
  const auto source = Open();
  source->Next(1s);
  const MonotonicTime before = clock_->Now();
  source->Interrupt();
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kTimeout);
  EXPECT_EQ(clock_->Now(), before);
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kFrame);
}

TEST_F(ReplaySourceTest, AnUnusableFrameIsNamedAndPlayingGoesOn) {
  for (const Preload preload : {Preload::kNo, Preload::kYes}) {
    const test::TemporaryDirectory folder;
    test::WriteSmallRecording(folder.path(), 4);
    std::filesystem::remove(folder / "000001.raw");
    std::filesystem::resize_file(folder / "000002.raw", 5);
    options_.path = folder.path();
    options_.preload = preload;
    const auto source = Open();
    EXPECT_EQ(source->Next(1s).status, CaptureStatus::kFrame);
    CaptureResult result = source->Next(1s);
    EXPECT_EQ(result.status, CaptureStatus::kCorrupt);
    EXPECT_THAT(result.message, HasSubstr("000001.raw: cannot be opened: No such file"));
    result = source->Next(1s);
    EXPECT_EQ(result.status, CaptureStatus::kCorrupt);
    EXPECT_THAT(result.message, HasSubstr("000002.raw: has 5 bytes"));
    EXPECT_EQ(source->Next(1s).frame.sequence, 103u);
  }
}

TEST_F(ReplaySourceTest, PreloadedFramesNeedNoFilesAndNoCopies) {
  test::WriteSmallRecording(folder_.path(), 2);
  options_.preload = Preload::kYes;
  options_.loop = true;
  const auto source = Open();
  EXPECT_TRUE(source->is_preloaded());
  std::filesystem::remove(folder_ / "000000.raw");
  const Frame first = source->Next(1s).frame;
  source->Next(1s);
  const Frame again = source->Next(1s).frame;
  EXPECT_EQ(first.image.row(0), again.image.row(0));
}

TEST_F(ReplaySourceTest, FramesOutliveTheirSource) {
  test::WriteSmallRecording(folder_.path(), 2);
  for (const Preload preload : {Preload::kNo, Preload::kYes}) {
    options_.preload = preload;
    auto source = Open();
    source->Next(1s);
    const Frame frame = source->Next(1s).frame;
    source.reset();
    EXPECT_EQ(frame.image.row(1)[3], 1);
  }
}

TEST_F(ReplaySourceTest, PreloadsByItselfOnlyWhereItHelps) {
  test::WriteSmallRecording(folder_.path(), 2);
  // Decoding takes no time in this clock.
  EXPECT_FALSE(Open()->is_preloaded());
  options_.pace = ReplayPace::kUnlimited;
  EXPECT_FALSE(Open()->is_preloaded());
  options_.loop = true;
  EXPECT_TRUE(Open()->is_preloaded());
  options_.preload_limit_bytes = 15;  // two frames have 16 bytes
  EXPECT_FALSE(Open()->is_preloaded());
  options_.preload_limit_bytes = 16;
  EXPECT_TRUE(Open()->is_preloaded());
}

/// A clock in which reading the time takes 1 ms, and so decoding, which is timed, seems to.
class SlowClock final : public WaitingClock {
 public:
  MonotonicTime Now() const override { return now_ += 1ms; }
  UtcTime NowUtc() const override { return UtcTime(now_.time_since_epoch()); }
  bool WaitUntil(MonotonicTime time) override {
    now_ = std::max(now_, time);
    return true;
  }
  void Interrupt() override {}
  bool IsInterrupted() const override { return false; }

 private:
  mutable MonotonicTime now_{1s};
};

TEST_F(ReplaySourceTest, PreloadsByItselfWhereDecodingIsTooSlowForThePace) {
  test::WriteSmallRecording(folder_.path(), 1);
  options_.pace = ReplayPace::kFixedRate;
  const auto preloads_at = [&](double fps) {
    options_.fps = fps;
    ReplaySource source(options_, std::make_shared<SlowClock>());
    source.Open();
    return source.is_preloaded();
  };
  EXPECT_FALSE(preloads_at(300));  // 1 ms of 3.3
  EXPECT_TRUE(preloads_at(400));   // 1 ms of 2.5
}

TEST_F(ReplaySourceTest, RefusesToPreloadBeyondTheLimit) {
  test::WriteSmallRecording(folder_.path(), 2);
  options_.preload = Preload::kYes;
  options_.preload_limit_bytes = 15;
  ReplaySource source(options_, clock_);
  try {
    source.Open();
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("needs 1 MB, the limit is 1 MB: raise it"));
  }
}

TEST_F(ReplaySourceTest, PreloadingCanBeInterruptedAndBegunAgain) {
  test::WriteSmallRecording(folder_.path(), 2);
  options_.preload = Preload::kYes;
  ReplaySource source(options_, clock_);
  source.Interrupt();
  EXPECT_THAT(source.Open(), HasSubstr("interrupted"));
  EXPECT_EQ(source.Next(1s).status, CaptureStatus::kDisconnected);
  EXPECT_FALSE(clock_->WaitUntil(clock_->Now()));  // uses the interruption up
  EXPECT_EQ(source.Open(), "");
  EXPECT_EQ(source.Next(1s).status, CaptureStatus::kFrame);
}

TEST_F(ReplaySourceTest, OpeningAgainGoesOnWhereItWas) {
  test::WriteSmallRecording(folder_.path(), 3);
  const auto source = Open();
  source->Next(1s);
  clock_->Advance(1h);
  EXPECT_EQ(source->Open(), "");
  const MonotonicTime reopened = clock_->Now();
  const Frame second = source->Next(1s).frame;
  EXPECT_EQ(second.sequence, 101u);
  EXPECT_EQ(second.captured_monotonic, reopened);
  EXPECT_EQ(source->Next(1s).frame.captured_monotonic, reopened + 10ms);
  EXPECT_EQ(source->frames_lost(), 0u);
}

TEST_F(ReplaySourceTest, IsNotPlayedUnopened) {
  test::WriteSmallRecording(folder_.path(), 1);
  ReplaySource source(options_, clock_);
  EXPECT_EQ(source.Next(1s).status, CaptureStatus::kDisconnected);
}

TEST_F(ReplaySourceTest, AListOfImagesPlays) {
  test::WriteSmallRecording(folder_.path(), 3, FrameFileKind::kPng);
  options_.path.clear();
  options_.images = {folder_ / "000002.png", folder_ / "000000.png"};
  options_.plain.fps = 4;
  const auto source = Open();
  const MonotonicTime start = clock_->Now();
  EXPECT_EQ(source->Next(1s).frame.image.row(0)[0], 2);
  const Frame second = source->Next(1s).frame;
  EXPECT_EQ(second.image.row(0)[0], 0);
  EXPECT_EQ(second.captured_monotonic, start + 250ms);
  EXPECT_EQ(source->Describe(), "2 images, 4x2 Mono8, 4 fps");
}

TEST_F(ReplaySourceTest, DescribesItself) {
  test::WriteSmallRecording(folder_.path(), 3);
  options_.preload = Preload::kYes;
  options_.loop = true;
  const std::string name = "recording " + folder_.path().string();
  EXPECT_EQ(ReplaySource(options_, clock_).Describe(), name);
  EXPECT_EQ(Open()->Describe(), name + ", 4x2 Mono8, 100 fps, in a loop, preloaded");
  options_ = {};
  options_.path = folder_.path();
  options_.pace = ReplayPace::kUnlimited;
  EXPECT_EQ(Open()->Describe(), name + ", 4x2 Mono8, as fast as it goes");
}

TEST_F(ReplaySourceTest, RefusesOptionsThatCannotBe) {
  const auto wrong = [&](const std::function<void(ReplayOptions&)>& change) {
    ReplayOptions options = options_;
    change(options);
    return test::ErrorOf([&] { ReplaySource source(options, clock_); });
  };
  EXPECT_EQ(wrong([](ReplayOptions&) {}), "no error");
  EXPECT_THAT(wrong([](ReplayOptions& o) { o.path.clear(); }), HasSubstr("either a path or a list of images"));
  EXPECT_THAT(wrong([](ReplayOptions& o) { o.images = {"a.png"}; }), HasSubstr("either a path or a list of images"));
  EXPECT_THAT(wrong([](ReplayOptions& o) { o.fps = 0; }), HasSubstr("replay fps = 0: must be from 0.001 to 10000"));
  EXPECT_THAT(wrong([](ReplayOptions& o) { o.plain.fps = -1; }), HasSubstr("fps of images = -1: must be"));
  EXPECT_THAT(wrong([](ReplayOptions& o) { o.plain.one_channel = PixelFormat::kBgr8; }), HasSubstr("not BGR8"));
}

TEST_F(ReplaySourceTest, ThrowsWhereTheRecordingCannotBeRead) {
  options_.path = folder_ / "gone";
  ReplaySource source(options_, clock_);
  EXPECT_THROW(source.Open(), std::runtime_error);
}

TEST(SystemClock, AnInterruptionFromAnotherThreadEndsTheWait) {
  const auto clock = MakeSystemClock();
  EXPECT_FALSE(clock->IsInterrupted());
  std::promise<void> about_to_wait;
  std::jthread other([&] {
    about_to_wait.get_future().wait();
    clock->Interrupt();
  });
  about_to_wait.set_value();
  // Without the interruption the test would last an hour.
  EXPECT_FALSE(clock->WaitUntil(clock->Now() + 1h));
  EXPECT_FALSE(clock->IsInterrupted());
  EXPECT_TRUE(clock->WaitUntil(clock->Now()));
}

TEST(SystemClock, ReachesATime) {
  const auto clock = MakeSystemClock();
  const MonotonicTime until = clock->Now() + 1ms;
  EXPECT_TRUE(clock->WaitUntil(until));
  EXPECT_GE(clock->Now(), until);
}

}  // namespace
}  // namespace chequer
