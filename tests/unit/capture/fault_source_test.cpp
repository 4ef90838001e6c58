#include "capture/fault_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "capture/replay_source.h"
#include "small_recording.h"
#include "support/error_of.h"
#include "support/manual_clock.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string FaultError(const std::vector<std::string>& texts) {
  return test::ErrorOf([&] { ParseFaults(texts); });
}

TEST(ParseFault, ReadsEveryKind) {
  const Fault stall = ParseFault("stall 120 0.5s");
  EXPECT_EQ(stall.kind, FaultKind::kStall);
  EXPECT_EQ(stall.frame, 120u);
  EXPECT_EQ(stall.duration, 500ms);
  const Fault drop = ParseFault("drop 200 3");
  EXPECT_EQ(drop.kind, FaultKind::kDrop);
  EXPECT_EQ(drop.count, 3u);
  EXPECT_EQ(ParseFault(" truncate  0 ").kind, FaultKind::kTruncate);
  EXPECT_EQ(ParseFault("corrupt 310").kind, FaultKind::kCorrupt);
  const Fault vanish = ParseFault("vanish 400 20ms");
  EXPECT_EQ(vanish.kind, FaultKind::kVanish);
  EXPECT_EQ(vanish.duration, 20ms);
  EXPECT_EQ(vanish.failed_opens, 0);
  EXPECT_EQ(ParseFault("vanish 400 3 opens").failed_opens, 3);
}

TEST(ParseFault, SaysWhatWouldBeRight) {
  for (const char* text : {"",
                           "stall",
                           "stall 1",
                           "stall 1 2",
                           "stall 1 2h",
                           "stall 1 -1s",
                           "stall 1 nans",
                           "stall 1 0s",
                           "stall 1 4000s",
                           "stall 1 1s 1s",
                           "drop 1",
                           "drop 1 0",
                           "drop 1 1.5",
                           "drop -1 1",
                           "drop 1 1s",
                           "truncate 1 2",
                           "truncate x",
                           "corrupt",
                           "explode 1",
                           "vanish 1",
                           "vanish 1 3",
                           "vanish 1 3 times",
                           "vanish 1 0 opens",
                           "Stall 1 1s",
                           "drop 99999999999999999999 1"})
    EXPECT_THAT(FaultError({text}), HasSubstr("fault \"" + std::string(text) + "\": must be \"stall FRAME TIME\""));
  EXPECT_EQ(FaultError({"drop 5 1", "corrupt 5"}), "two faults at frame 5: one frame has one fault");
}

TEST(ParseFaults, OrdersByFrame) {
  const auto faults = ParseFaults({"drop 9 1", "corrupt 2"});
  EXPECT_EQ(faults[0].frame, 2u);
  EXPECT_EQ(faults[1].frame, 9u);
}

class FaultSourceTest : public ::testing::Test {
 protected:
  /// A recording of 12 frames, 10 ms apart from sequence 100 on, as fast as it goes unless paced.
  std::unique_ptr<FaultSource> Open(const std::vector<std::string>& faults, bool paced = false) {
    test::WriteSmallRecording(folder_.path(), 12);
    ReplayOptions options;
    options.path = folder_.path();
    options.pace = paced ? ReplayPace::kRecorded : ReplayPace::kUnlimited;
    auto source =
        std::make_unique<FaultSource>(std::make_unique<ReplaySource>(options, clock_), ParseFaults(faults), clock_);
    EXPECT_EQ(source->Open(), "");
    return source;
  }

  /// Sequence numbers of all frames to the end; −1 for a corrupt one.
  static std::vector<int> PlayAll(FaultSource& source) {
    std::vector<int> sequences;
    while (true) {
      const CaptureResult result = source.Next(1s);
      if (result.status == CaptureStatus::kEnd) return sequences;
      sequences.push_back(result.status == CaptureStatus::kCorrupt ? -1 : static_cast<int>(result.frame.sequence));
    }
  }

  test::TemporaryDirectory folder_;
  std::shared_ptr<test::ManualClock> clock_ = std::make_shared<test::ManualClock>();
};

TEST_F(FaultSourceTest, WithoutFaultsEverythingPasses) {
  const auto source = Open({});
  EXPECT_THAT(PlayAll(*source), ElementsAre(100, 101, 102, 103, 104, 105, 106, 107, 108, 109, 110, 111));
}

TEST_F(FaultSourceTest, DropLeavesAGapInTheSequence) {
  const auto source = Open({"drop 2 3", "drop 10 5"});
  EXPECT_THAT(PlayAll(*source), ElementsAre(100, 101, 105, 106, 107, 108, 109));
}

TEST_F(FaultSourceTest, TruncateGivesACorruptFrameThatIsNamed) {
  const auto source = Open({"truncate 1"});
  source->Next(1s);
  const CaptureResult result = source->Next(1s);
  EXPECT_EQ(result.status, CaptureStatus::kCorrupt);
  EXPECT_EQ(result.message, "frame 101 (000001.raw): only 4 of 8 bytes came (scripted fault)");
  EXPECT_EQ(source->Next(1s).frame.sequence, 102u);
}

TEST_F(FaultSourceTest, CorruptGivesAFrameWithNoise) {
  const auto source = Open({"corrupt 1"});
  source->Next(1s);
  const CaptureResult result = source->Next(1s);
  ASSERT_EQ(result.status, CaptureStatus::kFrame);
  EXPECT_EQ(result.frame.sequence, 101u);
  int changed = 0;
  for (int i = 0; i < 8; ++i) changed += result.frame.image.row(i / 4)[i % 4] != 1;
  EXPECT_EQ(changed, 2);  // a third of 8 bytes
}

TEST_F(FaultSourceTest, StallTimesOutUntilItIsOver) {
  const auto source = Open({"stall 1 500ms"}, true);
  source->Next(1s);
  const MonotonicTime before = clock_->Now();
  EXPECT_EQ(source->Next(200ms).status, CaptureStatus::kTimeout);
  EXPECT_EQ(source->Next(200ms).status, CaptureStatus::kTimeout);
  EXPECT_EQ(clock_->Now(), before + 400ms);
  // The recording is over by then; what its buffers held is left.
  const CaptureResult result = source->Next(200ms);
  EXPECT_EQ(clock_->Now(), before + 500ms);
  EXPECT_EQ(result.status, CaptureStatus::kEnd);
}

TEST_F(FaultSourceTest, AShortStallDelaysFramesAndKeepsThem) {
  const auto source = Open({"stall 1 35ms"}, true);
  const MonotonicTime start = clock_->Now();
  source->Next(1s);
  const CaptureResult result = source->Next(1s);
  EXPECT_EQ(result.frame.sequence, 101u);
  EXPECT_EQ(result.frame.captured_monotonic, start + 10ms);
  EXPECT_EQ(clock_->Now(), start + 35ms);
}

TEST_F(FaultSourceTest, AStallCanBeInterrupted) {
  const auto source = Open({"stall 0 500ms"});
  const MonotonicTime before = clock_->Now();
  source->Interrupt();
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kTimeout);
  EXPECT_EQ(clock_->Now(), before);
}

TEST_F(FaultSourceTest, VanishesForATimeAndReturns) {
  const auto source = Open({"vanish 2 1s"});
  source->Next(1s);
  source->Next(1s);
  const CaptureResult gone = source->Next(1s);
  EXPECT_EQ(gone.status, CaptureStatus::kDisconnected);
  EXPECT_EQ(gone.message, "the camera is gone (scripted fault at frame 2)");
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kDisconnected);
  EXPECT_EQ(source->Open(), "the camera is not there (scripted fault) for another 1000 ms");
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kDisconnected);
  clock_->Advance(1s);
  EXPECT_EQ(source->Open(), "");
  EXPECT_EQ(source->Next(1s).frame.sequence, 102u);
}

TEST_F(FaultSourceTest, VanishesForSomeAttemptsAndReturns) {
  const auto source = Open({"vanish 0 2 opens"});
  EXPECT_EQ(source->Next(1s).status, CaptureStatus::kDisconnected);
  EXPECT_THAT(source->Open(), HasSubstr("that will fail: 1"));
  EXPECT_THAT(source->Open(), HasSubstr("that will fail: 0"));
  EXPECT_EQ(source->Open(), "");
  EXPECT_EQ(source->Next(1s).frame.sequence, 100u);
}

TEST_F(FaultSourceTest, SeveralFaultsHappenInOrder) {
  const auto source = Open({"drop 1 2", "truncate 2", "truncate 5", "stall 6 20ms", "corrupt 7"});
  // The frame of the second fault is among the dropped ones.
  EXPECT_THAT(PlayAll(*source), ElementsAre(100, 103, 104, -1, 106, 107, 108, 109, 110, 111));
}

TEST_F(FaultSourceTest, DescribesItself) {
  EXPECT_THAT(Open({"corrupt 1"})->Describe(), HasSubstr("as fast as it goes, with 1 scripted faults"));
}

}  // namespace
}  // namespace chequer
