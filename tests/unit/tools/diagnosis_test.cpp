// What `chequer explain` says is wrong, and what would help.
#include "tools/diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/convert.h"
#include "support/scenes.h"
#include "tools/explanation.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

MarkerFamily Family(MarkerSize size, Variant variant, std::vector<std::uint64_t> roster = {}) {
  return {.code = MarkerCode(size, variant), .side_m = 0.12, .roster = std::move(roster)};
}

/// All findings in one text.
std::string Found(const ImageView& image, const MarkerFamily& sought) {
  DetectorOptions options;
  options.families = {sought};
  Detector detector(options);
  std::vector<MarkerPose> markers;
  DetectTrace trace;
  detector.Detect(image, markers, &trace);
  const Image bgr = ToBgr(image);
  std::string text;
  for (const Finding& finding : Diagnose(bgr.view(), options, markers, trace)) text += finding.text + "\n";
  return text;
}

test::KnownFrame Secded(std::uint64_t id = 77, std::uint64_t seed = 3) {
  return test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), id, 14, seed);
}

/// Several boards side by side.
Image Boards(const MarkerCode& code, int count) {
  test::KnownFrame frame = test::OneMarker(code, 100, 12, 4, 0);
  frame.scene.markers.clear();
  for (int i = 0; i < count; ++i) {
    const RigidTransform pose{RotationFromVector({M_PI, 0, 0}), {-0.45 + 0.22 * (i % 5), -0.25 + 0.25 * (i / 5), 1}};
    frame.scene.markers.push_back(test::MarkerOf(code, static_cast<std::uint64_t>(1000 + 37 * i), pose));
  }
  return frame.Draw();
}

TEST(Diagnose, IsSilentWhereAllIsRead) {
  EXPECT_THAT(Found(Secded().Draw().view(), Family({6, 6}, Variant::kSecded)), IsEmpty());
}

TEST(Diagnose, NamesTheSize) {
  EXPECT_THAT(Found(Secded().Draw().view(), Family({8, 8}, Variant::kGolay)),
              AllOf(HasSubstr("a marker of 6x6 cells, and 8x8 is sought"), HasSubstr("--marker 6x6"),
                    HasSubstr("secded (id 77)")));
}

TEST(Diagnose, NamesTheRoster) {
  EXPECT_THAT(Found(Secded().Draw().view(), Family({6, 6}, Variant::kSecded, {1, 2, 3})),
              AllOf(HasSubstr("id 77, which --ids"), Not(HasSubstr("variant"))));
}

TEST(Diagnose, NamesTheVariantOfOneBoardThatHasNoId) {
  // A word of secded that is far from all of reed_muller.
  for (std::uint64_t id = 70; id < 90; ++id)
    if (!MarkerCode({6, 6}, Variant::kReedMuller).DecodeHard(MarkerCode({6, 6}, Variant::kSecded).Encode(id))) {
      EXPECT_THAT(Found(Secded(id).Draw().view(), Family({6, 6}, Variant::kReedMuller)),
                  AllOf(HasSubstr("no word of reed_muller"), HasSubstr("secded (id " + std::to_string(id) + ")")));
      return;
    }
  FAIL() << "no such id";
}

TEST(Diagnose, TellsTheVariantOfBoardsThatAreSilentlyReadAsOthers) {
  const Image image = Boards(MarkerCode({6, 6}, Variant::kSecded), 6);
  EXPECT_THAT(Found(image.view(), Family({6, 6}, Variant::kUnconstrained)),
              AllOf(HasSubstr("these look like secded, not unconstrained"), HasSubstr("1037")));
  EXPECT_THAT(Found(image.view(), Family({6, 6}, Variant::kReedMuller)),
              HasSubstr("these look like secded, not reed_muller"));
  EXPECT_THAT(Found(image.view(), Family({6, 6}, Variant::kSecded)), Not(HasSubstr("look like")));
}

TEST(Diagnose, KnowsMirrorImages) {
  test::KnownFrame frame = Secded();
  for (SceneMarker& marker : frame.scene.markers) marker.mirrored = true;
  EXPECT_THAT(Found(frame.Draw().view(), Family({6, 6}, Variant::kSecded)),
              AllOf(HasSubstr("mirror image of a marker of 6x6 cells (id 77)"), Not(HasSubstr("white balance"))));
}

TEST(Diagnose, KnowsMotionFromFocus) {
  test::KnownFrame moved = Secded();
  moved.scene.background.kind = BackgroundKind::kTiles;
  test::KnownFrame soft = moved;
  moved.options.motion_px = 30;
  EXPECT_THAT(Found(moved.Draw().view(), Family({6, 6}, Variant::kSecded)), HasSubstr("moved during the exposure"));
  soft.options.blur_sigma_px = 8;
  EXPECT_THAT(Found(soft.Draw().view(), Family({6, 6}, Variant::kSecded)), HasSubstr("focus the lens"));
}

TEST(Diagnose, KnowsABlackPicture) {
  EXPECT_THAT(Found(Image(PixelFormat::kBgr8, 640, 480).view(), Family({6, 6}, Variant::kSecded)),
              HasSubstr("the picture is black"));
}

// A large group of clutter has more corners than the marker that was missed.
TEST(Diagnose, PutsTheLikeliestMissedFirst) {
  test::KnownFrame frame = Secded();
  frame.scene.background.kind = BackgroundKind::kChess;
  const Image image = frame.Draw();
  DetectorOptions options;
  options.families = {Family({8, 8}, Variant::kGolay)};
  Detector detector(options);
  std::vector<MarkerPose> markers;
  DetectTrace trace;
  detector.Detect(image.view(), markers, &trace);
  Explanation explanation{"frame.png", image.view(), markers, &trace, detector.stats(), {0, 0, 640, 480}};
  explanation.findings = Diagnose(image.view(), options, markers, trace);
  const std::vector<std::size_t> told = ToldCandidates(explanation);
  ASSERT_FALSE(told.empty());
  EXPECT_LT((explanation.candidate(told[0]).center_px - frame.Truth()[0].center_px).norm(), 20);
  EXPECT_THAT(DescribeExplanation(explanation), HasSubstr("what is wrong, and what would help:"));
}

}  // namespace
}  // namespace chequer
