#include "daemon/capture_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "support/deadline.h"
#include "support/log_capture.h"
#include "support/scripted_source.h"
#include "support/stepped_clock.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::FrameNumber;
using test::Frames;
using test::Gives;
using test::kEnd;
using test::OpenFails;
using test::Opens;
using test::OpenThrows;
using test::ScriptedSource;
using test::Step;
using test::operator+;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Step kGone = Gives(CaptureStatus::kDisconnected, "unplugged");

/// Runs a script to its end.
class CaptureLoopTest : public ::testing::Test {
 protected:
  void Run(std::vector<Step> script, CaptureLoopOptions options = {}) {
    ScriptedSource source(std::move(script));
    source.remarks = remarks_;
    source.health = health_;
    source.rate = rate_hz_;
    options.first_reopen = options.longest_reopen = milliseconds(0);
    CaptureLoop(
        options, source,
        [this](CapturedFrame frame) {
          sequences_.push_back(frame.frame.sequence);
          dropped_.push_back(frame.dropped_before);
          clock_.Advance(milliseconds(10));
          return true;
        },
        report_, sequence_, activity_, clock_.clock())
        .Run(std::stop_token());
    opened_ = source.opened();
  }

  std::vector<std::string> remarks_;
  std::string health_;
  double rate_hz_ = 0;
  test::SteppedClock clock_;
  test::LogCapture log_;
  Shared<CaptureReport> report_;
  SequenceCounter sequence_;
  CaptureActivity activity_;
  std::vector<std::uint64_t> sequences_;
  std::vector<std::uint64_t> dropped_;
  int opened_ = 0;
};

TEST_F(CaptureLoopTest, PassesFramesOnUntilTheEnd) {
  Run(Frames(5, 8) + std::vector{kEnd});
  EXPECT_THAT(sequences_, ElementsAre(5, 6, 7, 8));
  const CaptureReport report = report_.Get();
  EXPECT_EQ(report.state, CameraState::kEnded);
  EXPECT_EQ(report.source, "scripted camera");
  EXPECT_EQ(report.unusable(), 0u);
  EXPECT_THAT(log_.lines(), IsEmpty());
}

TEST_F(CaptureLoopTest, CountsFramesThatWereLostBefore) {
  Run({FrameNumber(1), FrameNumber(4), FrameNumber(5), kEnd});
  EXPECT_THAT(sequences_, ElementsAre(1, 4, 5));
  EXPECT_THAT(dropped_, ElementsAre(0, 2, 2));
  EXPECT_EQ(report_.Get().lost_before, 2u);
}

TEST_F(CaptureLoopTest, CountsCorruptFramesOnceAndGoesOn) {
  Run({FrameNumber(1), Gives(CaptureStatus::kCorrupt, "b.png is cut off"),
       Gives(CaptureStatus::kCorrupt, "c.png is cut off"), FrameNumber(4), kEnd});
  EXPECT_THAT(sequences_, ElementsAre(1, 4));
  EXPECT_THAT(dropped_, ElementsAre(0, 2));
  EXPECT_EQ(report_.Get().corrupt, 2u);
  EXPECT_EQ(report_.Get().lost_before, 0u);
  EXPECT_THAT(log_.lines(), ElementsAre(HasSubstr("b.png is cut off")));
}

TEST_F(CaptureLoopTest, SaysWhatIsWrongWhileEveryFrameIsUnusable) {
  const Step corrupt = Gives(CaptureStatus::kCorrupt, "is cut off");
  Run({FrameNumber(1), corrupt, kEnd});
  EXPECT_EQ(report_.Get().message, "");  // one alone
  Run({corrupt, corrupt, kEnd});
  EXPECT_EQ(report_.Get().message, "frames are unusable: is cut off");
  Run({corrupt, corrupt, FrameNumber(2), corrupt, kEnd});
  EXPECT_EQ(report_.Get().message, "");
}

TEST_F(CaptureLoopTest, OpensAgainAfterADisconnection) {
  Run({FrameNumber(1), kGone, OpenFails("not there"), OpenFails("not there"), Opens(), FrameNumber(0), kEnd});
  EXPECT_THAT(sequences_, ElementsAre(1, 2));
  EXPECT_EQ(opened_, 4);
  EXPECT_THAT(log_.lines(), ElementsAre(HasSubstr("the camera was lost: unplugged"), HasSubstr("not there"),
                                        HasSubstr("frames come from scripted camera")));
}

TEST_F(CaptureLoopTest, TellsWhyItWaits) {
  ScriptedSource source({OpenFails("Device 'A' is not there; is it plugged in?")});
  std::stop_source stop;
  CaptureLoopOptions options;
  options.first_reopen = seconds(1000);  // ended by the stop, not by the time
  {
    std::jthread thread([&] {
      CaptureLoop(
          options, source, [](CapturedFrame) { return true; }, report_, sequence_, activity_, clock_.clock())
          .Run(stop.get_token());
    });
    EXPECT_TRUE(test::ComesTrue([&] { return !report_.Get().message.empty(); }));
    stop.request_stop();
  }
  EXPECT_EQ(report_.Get().state, CameraState::kWaiting);
  EXPECT_THAT(report_.Get().message, HasSubstr("is it plugged in?"));
}

TEST_F(CaptureLoopTest, ForgetsTheTroubleWhenFramesCome) {
  Run({OpenFails("not there"), Opens(), FrameNumber(1), kEnd});
  EXPECT_THAT(report_.Get().message, IsEmpty());
}

TEST_F(CaptureLoopTest, ThrowsWhereWaitingCannotHelp) {
  EXPECT_THROW(Run({OpenThrows("no such recording")}), std::runtime_error);
}

TEST_F(CaptureLoopTest, ComplainsOnceOfACameraThatFallsSilent) {
  CaptureLoopOptions options;
  options.stall = milliseconds(5);  // the clock goes 10 ms a frame
  const Step silence = Gives(CaptureStatus::kTimeout);
  Run({FrameNumber(1), silence, silence, silence, FrameNumber(2), kEnd}, options);
  EXPECT_THAT(sequences_, ElementsAre(1, 2));
  EXPECT_THAT(log_.lines(), ElementsAre(HasSubstr("no frame comes from scripted camera"), HasSubstr("frames come")));
  EXPECT_THAT(report_.Get().message, IsEmpty());
}

TEST_F(CaptureLoopTest, DoesNotComplainOfAShortSilence) {
  Run({FrameNumber(1), Gives(CaptureStatus::kTimeout), FrameNumber(2), kEnd});
  EXPECT_THAT(log_.lines(), IsEmpty());
}

TEST_F(CaptureLoopTest, DropsFramesThatTheCalibrationIsNotFor) {
  CaptureLoopOptions options;
  options.size = FrameSize{8, 2};
  Run({FrameNumber(1, 4), FrameNumber(2, 8), FrameNumber(3, 4), kEnd}, options);
  EXPECT_THAT(sequences_, ElementsAre(2));
  const CaptureReport report = report_.Get();
  EXPECT_EQ(report.wrong_size, 2u);
  EXPECT_THAT(report.message, HasSubstr("delivers 4x2, its calibration is for 8x2"));
  EXPECT_THAT(log_.lines(), ElementsAre(HasSubstr("delivers 4x2")));
}

TEST_F(CaptureLoopTest, LogsOnceWhatACameraDoesNotDoAsAsked) {
  remarks_ = {"the camera gives 25"};
  Run({FrameNumber(1), kGone, Opens(), FrameNumber(2), kEnd});
  EXPECT_THAT(log_.lines(), ElementsAre(HasSubstr("the camera gives 25"), HasSubstr("the camera was lost"),
                                        HasSubstr("frames come from")));
}

TEST_F(CaptureLoopTest, TellsHowTheCameraFares) {
  health_ = "3 packets resent";
  Run({FrameNumber(1), kEnd});
  EXPECT_EQ(report_.Get().source, "scripted camera (3 packets resent)");
}

TEST_F(CaptureLoopTest, ShowsTheGapThatALostCameraLeaves) {
  rate_hz_ = 400;  // the clock goes 10 ms from frame to frame: three would have come between them
  Run({FrameNumber(7), kGone, Opens(), FrameNumber(0), FrameNumber(1), kEnd});
  EXPECT_THAT(sequences_, ElementsAre(7, 11, 12));
  EXPECT_THAT(dropped_, ElementsAre(0, 3, 3));
  EXPECT_EQ(report_.Get().lost_before, 3u);
}

TEST_F(CaptureLoopTest, ShowsAGapHoweverShortTheCameraWasAway) {
  rate_hz_ = 1;
  Run({FrameNumber(7), kGone, Opens(), FrameNumber(0), kEnd});
  EXPECT_THAT(sequences_, ElementsAre(7, 9));
}

}  // namespace
}  // namespace chequer
