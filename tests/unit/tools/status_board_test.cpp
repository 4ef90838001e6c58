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

TEST(Trouble, NamesFramesOfTheWrongSize) {
  StatusMessage status = Well();
  status.publish_rate_hz = 0;
  status.drops = {{"wrong_size", 12}};
  EXPECT_THAT(Trouble(status, {}), HasSubstr("wrong size: 12 frames"));
}

TEST(HintsOf, SaysWhyMarkersAreNotRead) {
  StatusMessage status = Well();
  EXPECT_THAT(HintsOf(status), IsEmpty());
  status.detections = {{"boards", 200},        {"robots", 100},     {"off_floor", 80},
                       {"hint_black", 1},      {"hint_blurred", 0}, {"hint_looks_like_secded", 5},
                       {"hint_of_tomorrow", 1}};
  const std::vector<std::string> hints = HintsOf(status);
  ASSERT_EQ(hints.size(), 4u);
  EXPECT_THAT(hints[0], HasSubstr("black: there is no light"));
  EXPECT_THAT(hints[1],
              AllOf(HasSubstr("these look like secded: 5 different boards"), HasSubstr("variant = \"secded\"")));
  EXPECT_EQ(hints[2], "hint: of_tomorrow");
  EXPECT_THAT(hints[3], AllOf(HasSubstr("off the floor: 80 %"), HasSubstr("heights")));
}

TEST(StatusBoard, ShowsHintsWithoutCallingTheServiceUnwell) {
  StatusBoard board("");
  StatusMessage status = Well();
  status.detections = {{"hint_no_board", 1}};
  board.Add("A_STATUS", status, AtSecond(1));
  EXPECT_TRUE(board.AllWell(AtSecond(1)));
  EXPECT_THAT(board.Text(AtSecond(1)), HasSubstr("north: nothing that looks like a board is in view"));
}

TEST(StatusBoard, RemembersWhoElseWasHeard) {
  StatusBoard board("nroth");
  board.Add("A_STATUS", Well("north"), AtSecond(1));
  board.Add("B_STATUS", Well("so\nuth"), AtSecond(1));
  EXPECT_TRUE(board.IsEmpty());
  EXPECT_THAT(board.OthersHeard(), ::testing::ElementsAre("north", "so?uth"));
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

StatusMessage Of(std::uint64_t instance) {
  StatusMessage status = Well();
  status.detections = {{"instance", instance}};
  return status;
}

TEST(StatusBoard, TwoDaemonsOfOneNameAreTrouble) {
  StatusBoard board("");
  for (int s = 10; s < 12; ++s) {
    board.Add("CHEQUER_north_STATUS", Of(1), AtSecond(s));
    board.Add("CHEQUER_north_STATUS", Of(2), AtSecond(s));
  }
  EXPECT_FALSE(board.AllWell(AtSecond(12)));
  const std::string text = board.Text(AtSecond(12));
  EXPECT_THAT(text, HasSubstr("north: 2 programs publish as CHEQUER_north_STATUS: give each camera a name"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5) << "a line each, and what is wrong with each";
}

TEST(StatusBoard, ADaemonThatWasStartedAgainIsOne) {
  StatusBoard board("");
  board.Add("CHEQUER_north_STATUS", Of(1), AtSecond(10));
  board.Add("CHEQUER_north_STATUS", Of(2), AtSecond(11));
  board.Add("CHEQUER_north_STATUS", Of(2), AtSecond(12));
  EXPECT_TRUE(board.AllWell(AtSecond(12)));
  EXPECT_EQ(board.Rows(AtSecond(12)).size(), 1u);
}

TEST(StatusBoard, HoldsNoMoreThanItCanShow) {
  StatusBoard board("");
  for (int i = 0; i < 10'000; ++i) board.Add("CHANNEL_" + std::to_string(i), Of(1), AtSecond(10));
  EXPECT_EQ(board.Rows(AtSecond(10)).size(), 256u);
}

TEST(StatusBoard, KeepsTheNewest) {
  StatusBoard board("");
  board.Add("a", Well(), AtSecond(1));
  StatusMessage later = Well();
  later.camera_state = CameraState::kWaiting;
  later.camera_message = "unplugged";
  later.stages.clear();
  board.Add("a", later, AtSecond(2));
  EXPECT_EQ(board.Rows(AtSecond(2)).size(), 1u);
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
  status.version = "\u009b2J\x9b\xff";
  status.publisher.message = "a\nb";
  status.detections = {{"warning_\x1b", 3}};
  board.Add("a", status, AtSecond(1));
  EXPECT_THAT(board.Text(AtSecond(1)), AllOf(Not(HasSubstr("\x1b")), Not(HasSubstr("\a")), HasSubstr("a?b"),
                                             HasSubstr("?2J??"), Not(HasSubstr("\u009b"))));
}

}  // namespace
}  // namespace chequer
