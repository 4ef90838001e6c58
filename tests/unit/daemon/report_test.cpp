#include "daemon/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/mailbox.h"
#include "support/log_capture.h"
#include "support/stepped_clock.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using ::testing::HasSubstr;

StatusMessage Working() {
  StatusMessage status;
  status.camera_state = CameraState::kRunning;
  status.frames_published = 12;
  status.frames_dropped = 3;
  status.drops = {{"corrupt", 0}, {"superseded", 3}};
  status.stages = {{"total", 12, milliseconds(5), milliseconds(8), milliseconds(9)}};
  return status;
}

TEST(Report, IsMadeOnceAllIsWellAndThenEveryHour) {
  test::LogCapture log;
  test::SteppedClock clock;
  Report report(clock.clock());
  StatusMessage waiting;
  report.Take(waiting);
  EXPECT_EQ(log.lines().size(), 0u);
  report.Take(Working());
  report.Take(Working());
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("3 frames dropped"));
  clock.Advance(minutes(59));
  report.Take(Working());
  EXPECT_EQ(log.lines().size(), 1u);
  clock.Advance(minutes(1));
  report.Take(Working());
  EXPECT_EQ(log.lines().size(), 2u);
}

TEST(Report, HasItsFiguresAsFields) {
  const std::vector<LogField> fields = ReportFields(Working());
  const auto value = [&](std::string_view name) {
    for (const LogField& field : fields)
      if (field.name == name) return field.value;
    return std::string("missing");
  };
  EXPECT_EQ(value("CHEQUER_FRAMES_PUBLISHED"), "12");
  EXPECT_EQ(value("CHEQUER_FRAMES_DROPPED"), "3");
  EXPECT_EQ(value("CHEQUER_LATENCY_P99_US"), "8000");
}

TEST(Summary, NamesTheReasonsOfDrops) {
  EXPECT_EQ(Summary(Working()), "12 frames published, 3 dropped: superseded 3");
  StatusMessage status = Working();
  status.publisher.failed = 2;
  EXPECT_THAT(Summary(status), HasSubstr("LCM did not take 2 messages"));
}

TEST(Mailbox, KeepsTheNewestStatusAndForgetsWhatWasTaken) {
  Mailbox mailbox;
  EXPECT_FALSE(mailbox.Take().status);
  StatusMessage status;
  mailbox.Put(status);
  status.camera = "later";
  mailbox.Put(status);
  mailbox.PutReady();
  mailbox.PutFinished();
  const Mailbox::Mail first = mailbox.Take();
  ASSERT_TRUE(first.status);
  EXPECT_EQ(first.status->camera, "later");
  EXPECT_TRUE(first.ready);
  EXPECT_TRUE(first.finished);
  const Mailbox::Mail second = mailbox.Take();
  EXPECT_FALSE(second.status);
  EXPECT_TRUE(second.ready);
  EXPECT_FALSE(second.finished);
}

}  // namespace
}  // namespace chequer
