#include "tools/truth_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

std::filesystem::path Demo() { return std::filesystem::path(CHEQUER_TEST_DATA) / "data/demo_swarm"; }

/// Frame `index` of the demo as its truth has it.
PosesMessage TrueFrame(std::size_t index) {
  static const std::vector<FrameTruth> truth = ReadTruth(Demo() / "truth.jsonl");
  PosesMessage message;
  message.sequence = index;
  for (const TrueMarker& marker : truth.at(index).markers) {
    MarkerPose pose;
    pose.id = marker.id;
    pose.variant = *ParseVariant(marker.variant);
    pose.size = marker.size;
    pose.has_pose = true;
    pose.camera_from_marker = marker.camera_from_marker;
    message.markers.push_back(pose);
  }
  return message;
}

TruthCheck All(const std::function<void(PosesMessage&)>& change = {}, std::size_t frames = 60) {
  TruthCheck check(Demo());
  for (std::size_t i = 0; i < frames; ++i) {
    PosesMessage message = TrueFrame(i);
    if (change && i == 30) change(message);
    check.Add(message);
  }
  return check;
}

TEST(TruthCheck, PassesTheTruth) {
  const TruthCheck check = All();
  EXPECT_TRUE(check.Passed()) << check.Summary();
  EXPECT_THAT(check.Summary(), HasSubstr("60 of 60 frames, 480 of 480 markers found, 0 wrong ids"));
  EXPECT_THAT(check.Summary(), HasSubstr("0.00 mm rms"));
  EXPECT_THAT(check.Summary(), HasSubstr("all as the truth says"));
}

void ExpectFailure(const TruthCheck& check, const std::string& why) {
  EXPECT_FALSE(check.Passed());
  EXPECT_THAT(check.Summary(), HasSubstr("NOT as the truth says"));
  EXPECT_THAT(check.Summary(), HasSubstr(why));
}

TEST(TruthCheck, RefusesOneWrongId) {
  ExpectFailure(All([](PosesMessage& message) { message.markers[0].id = 77; }), "1 ids are wrong");
}

TEST(TruthCheck, RefusesAnIdThatIsFoundTwice) {
  ExpectFailure(All([](PosesMessage& message) { message.markers.push_back(message.markers[0]); }), "1 ids are wrong");
}

TEST(TruthCheck, RefusesAPoseThatIsOff) {
  ExpectFailure(All([](PosesMessage& message) { message.markers[0].camera_from_marker.translation.z() *= 1.02; }),
                "1 poses are off");
  ExpectFailure(All([](PosesMessage& message) {
                  auto& rotation = message.markers[0].camera_from_marker.rotation;
                  rotation = RotationFromVector({0, 0, 0.1}) * rotation;
                }),
                "1 poses are off");
  ExpectFailure(All([](PosesMessage& message) { message.markers[0].has_pose = false; }), "1 poses are off");
}

TEST(TruthCheck, ForgivesAFewUndecidedMarkersOnly) {
  EXPECT_TRUE(All([](PosesMessage& message) { message.markers[0].id.reset(); }).Passed());
  ExpectFailure(All([](PosesMessage& message) { message.markers.clear(); }), "too few markers");
}

TEST(TruthCheck, ForgivesAFewDroppedFramesOnly) {
  EXPECT_TRUE(All({}, 54).Passed());
  ExpectFailure(All({}, 53), "too few frames");
  ExpectFailure(TruthCheck(Demo()), "too few frames");
}

TEST(TruthCheck, RefusesFramesOfAnotherRecording) {
  ExpectFailure(All([](PosesMessage& message) { message.sequence = 1000; }), "1 frames are not the recording's");
}

TEST(TruthCheck, NeedsARecordingWithTruth) {
  EXPECT_THROW(TruthCheck("/nowhere"), std::runtime_error);
  EXPECT_THROW(TruthCheck(Demo() / "000000.jpg"), std::runtime_error);
}

TEST(TruthCheck, ExpectsNoBoardThatIsNotSeenWhole) {
  const test::TemporaryDirectory folder;
  std::filesystem::copy(Demo(), folder / "demo", std::filesystem::copy_options::recursive);
  std::vector<FrameTruth> truth = ReadTruth(Demo() / "truth.jsonl");
  for (FrameTruth& frame : truth) {
    frame.time_s = 0;
    frame.markers[0].visible = 0.6;
  }
  WriteTruth(folder / "demo/truth.jsonl", truth);
  TruthCheck check(folder / "demo");
  for (std::size_t i = 0; i < truth.size(); ++i) {
    PosesMessage message = TrueFrame(i);
    // Whether it is found or not, all is right.
    if (i % 2 == 0) message.markers.erase(message.markers.begin());
    check.Add(message);
  }
  EXPECT_TRUE(check.Passed()) << check.Summary();
  EXPECT_THAT(check.Summary(), HasSubstr("420 of 420 markers found"));
}

}  // namespace
}  // namespace chequer
