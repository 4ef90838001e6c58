#include "tools/status_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

MonotonicTime AtSecond(int s) { return MonotonicTime(seconds(s)); }

StatusMessage Well(const std::string& camera = "north") {
  StatusMessage status;
  status.camera = camera;
  status.version = "1.2.3";
  status.camera_state = CameraState::kRunning;
  status.publisher.state = PublisherState::kReady;
  status.window = seconds(1);
  status.publish_rate_hz = 50;
  status.markers_mean = 4;
  status.frames_dropped = 17;
  status.stages = {{"total", 50, microseconds(5170), milliseconds(8), milliseconds(9)}};
  return status;
}

TEST(Trouble, IsWhatKeepsAServiceFromItsWork) {
  EXPECT_THAT(Trouble(Well(), seconds(1)), IsEmpty());
  EXPECT_THAT(Trouble(Well(), seconds(7)), HasSubstr("7 s"));
  StatusMessage status = Well();
  status.camera_state = CameraState::kWaiting;
  EXPECT_THAT(Trouble(status, {}), HasSubstr("waiting"));
  status.camera_message = "no such device";
  EXPECT_EQ(Trouble(status, {}), "no such device");
  status = Well();
  status.camera_state = CameraState::kEnded;
  EXPECT_THAT(Trouble(status, {}), HasSubstr("over"));
  status = Well();
  status.publisher.message = "no route";
  EXPECT_EQ(Trouble(status, {}), "no route");
  status = Well();
  status.camera_message = "no frame comes";
  EXPECT_EQ(Trouble(status, {}), "no frame comes");
  status = Well();
  status.publish_rate_hz = 0;
  EXPECT_THAT(Trouble(status, {}), HasSubstr("no frame"));
}

TEST(QualityRemark, TellsWhichShareOfTheMarkersCarriesAWarning) {
  StatusMessage status = Well();
  EXPECT_THAT(QualityRemark(status), IsEmpty());
  status.detections = {{"boards", 200},
                       {"warning_poor_illumination", 20},
                       {"warning_ambiguous_pose", 0},
                       {"warning_partly_hidden", 200}};
  EXPECT_EQ(QualityRemark(status), "poor_illumination 10 %, partly_hidden 100 %");
}

TEST(StatusBoard, ShowsALineACamera) {
  StatusBoard board("");
  EXPECT_TRUE(board.IsEmpty());
  board.Add("CHEQUER_north_STATUS", Well(), AtSecond(9));
  board.Add("CHEQUER_south_STATUS", Well("south"), AtSecond(10));
  EXPECT_TRUE(board.AllWell(AtSecond(10)));
  const std::string text = board.Text(AtSecond(10));
  EXPECT_THAT(text, HasSubstr("north   running  50.0      4.0      5.2 (8.0)          17       1.2.3    1.0\n"));
  EXPECT_THAT(text, HasSubstr("south   running"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

TEST(StatusBoard, KeepsTheNewest) {
  StatusBoard board("");
  board.Add("a", Well(), AtSecond(1));
  StatusMessage later = Well();
  later.camera_state = CameraState::kWaiting;
  later.camera_message = "unplugged";
  later.stages.clear();
  board.Add("a", later, AtSecond(2));
  EXPECT_EQ(board.entries().size(), 1u);
  EXPECT_FALSE(board.AllWell(AtSecond(2)));
  EXPECT_THAT(board.Text(AtSecond(2)), AllOf(HasSubstr("waiting"), HasSubstr("north: unplugged\n")));
}

TEST(StatusBoard, HeedsOnlyTheCameraThatWasAskedFor) {
  StatusBoard board("south");
  board.Add("CHEQUER_north_STATUS", Well(), AtSecond(1));
  EXPECT_TRUE(board.IsEmpty());
  board.Add("CHEQUER_south_STATUS", Well("south"), AtSecond(1));
  EXPECT_FALSE(board.IsEmpty());
}

TEST(StatusBoard, SendsNoControlCharactersToTheTerminal) {
  StatusBoard board("");
  StatusMessage status = Well("\x1b[2Jevil");
  status.version = "\a1";
  status.publisher.message = "a\nb";
  status.detections = {{"warning_\x1b", 3}};
  board.Add("a", status, AtSecond(1));
  EXPECT_THAT(board.Text(AtSecond(1)), AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\a")), HasSubstr("a?b")));
}

}  // namespace
}  // namespace chequer
