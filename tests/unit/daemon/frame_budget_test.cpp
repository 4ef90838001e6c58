#include "daemon/frame_budget.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "chequer/detector.h"
#include "daemon/machine_speed.h"
#include "daemon/service.h"
#include "support/log_capture.h"
#include "support/no_room_for_threads.h"
#include "support/recording_publisher.h"
#include "support/scripted_source.h"

namespace chequer {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(FrameBudget, IsUnlimitedUnlessSaidOtherwise) {
  EXPECT_EQ(FrameBudget().For(0), 0u);
  EXPECT_EQ(FrameBudget().For(60), 0u);
}

TEST(FrameBudget, IsTheNumberThatWasGivenAtAnyRate) {
  EXPECT_EQ(FrameBudget::Units(5000).For(0), 5000u);
  EXPECT_EQ(FrameBudget::Units(5000).For(1000), 5000u);
}

TEST(FrameBudget, LetsWorkersKeepUpWithTheCamera) {
  EXPECT_EQ(FrameBudget::Auto(12e6, 1).For(60), 140'000u);
  EXPECT_EQ(FrameBudget::Auto(12e6, 1).For(30), 280'000u);
  EXPECT_EQ(FrameBudget::Auto(12e6, 2).For(60), 240'000u);
}

TEST(FrameBudget, GivesNoFrameLongerWhereThereAreManyWorkers) {
  EXPECT_EQ(FrameBudget::Auto(6e6, 16).For(60), FrameBudget::Auto(6e6, 2).For(60));
}

TEST(FrameBudget, IsUnlimitedWhereTheRateIsNotKnown) { EXPECT_EQ(FrameBudget::Auto(6e6, 2).For(0), 0u); }

/// On a machine that was slow when it was measured, or is slow, markers would be left out of every frame.
TEST(FrameBudget, LastsForBoardsInPlainViewOnAnyMachine) {
  EXPECT_EQ(FrameBudget::Auto(1000, 1).For(1000), FrameBudget::kLeastAuto);
  EXPECT_GT(FrameBudget::kLeastAuto, kLeastBudget);
}

TEST(MachineSpeed, IsMeasuredOnAFrameWithWork) {
  test::LogCapture log;
  for (const int workers : {1, 3}) EXPECT_GT(MeasureSpeed(workers), 0);
  EXPECT_THAT(log.lines(), testing::SizeIs(2));
  EXPECT_THAT(log.lines(), testing::Each(HasSubstr("million units of work a second")));
}

/// Threads that were started may not wait for those that were not.
TEST(MachineSpeed, FailsWhereThreadsCannotBeStarted) {
  test::LogCapture log;
  const test::NoRoomForThreads none;
  EXPECT_THROW(MeasureSpeed(2), std::system_error);
}

/// What the detectors of a service were given for three frames of a camera of 50 frames a second.
std::vector<std::uint64_t> BudgetsGiven(const std::string& config_text) {
  const DaemonConfig config = ParseDaemonConfig(
      "[capture]\nsource = \"v4l2\"\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\n" + config_text, "a.toml", "/base");
  const auto published = std::make_shared<test::Published>();
  std::vector<std::uint64_t> given;
  ServiceParts parts;
  parts.make_source = [](const CaptureOptions&) {
    using test::operator+;
    auto source = std::make_unique<test::ScriptedSource>(std::vector{test::Opens()} + test::Frames(1, 3) +
                                                         std::vector{test::kEnd});
    source->rate = 50;
    return source;
  };
  parts.make_publisher = [&](const LcmPublisherOptions&) { return std::make_unique<test::RecordingPublisher>(published); };
  parts.make_detect = [&](const DetectorOptions&) {
    return [&](const ImageView&, DetectedFrame& found) { given.push_back(found.budget); };
  };
  parts.measure_speed = [](int) { return 1e7; };
  parts.set_up_logging = [](const DaemonConfig&) {};
  Service service(config, "1.0", parts, {});
  service.Join();
  EXPECT_FALSE(given.empty());
  return given;
}

TEST(ServiceBudget, ComesFromTheCamerasRateAndTheSpeedOfTheMachine) {
  EXPECT_THAT(BudgetsGiven("[pipeline]\nworkers = 1\n"), Each(140'000u));
}

TEST(ServiceBudget, IsTheConfiguredNumber) {
  EXPECT_THAT(BudgetsGiven("[detect]\nbudget = 4321\n[pipeline]\nworkers = 1\n"), Each(4321u));
}

TEST(ServiceBudget, IsNoneWhereItIsUnlimited) {
  EXPECT_THAT(BudgetsGiven("[detect]\nbudget = \"unlimited\"\n[pipeline]\nworkers = 1\n"), Each(0u));
}

}  // namespace
}  // namespace chequer
