#include "daemon/hints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "support/scenes.h"

namespace chequer {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

MarkerFamily Family(Variant variant, std::vector<std::uint64_t> roster = {}) {
  return {.code = MarkerCode({6, 6}, variant), .side_m = 0, .roster = std::move(roster)};
}

FrameLook Look(const ImageView& image, const MarkerFamily& family) {
  DetectorOptions options;
  options.families = {family};
  Detector detector(options);
  std::vector<MarkerPose> markers;
  DetectTrace trace;
  detector.Detect(image, markers, &trace);
  return LookAt(image, options.families, markers, trace);
}

std::map<std::string, std::uint64_t> Counts(Hints& hints) {
  std::map<std::string, std::uint64_t> counts;
  for (const NamedCount& count : hints.TakeCounts()) counts[count.name] = count.count;
  return counts;
}

std::map<std::string, std::uint64_t> HintsOf(const ImageView& image, const MarkerFamily& family) {
  Hints hints({family});
  hints.Take(Look(image, family));
  return Counts(hints);
}

test::KnownFrame Marker(std::uint64_t id, std::uint64_t seed = 5) {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), id, 14, seed);
  frame.scene.background.kind = BackgroundKind::kWood;
  return frame;
}

TEST(Hints, AreSilentWhereMarkersAreRead) {
  EXPECT_THAT(HintsOf(Marker(7).Draw().view(), Family(Variant::kSecded)), IsEmpty());
}

TEST(Hints, NameWhatIsWrongWithThePicture) {
  const MarkerFamily family = Family(Variant::kSecded);
  EXPECT_THAT(HintsOf(Image(PixelFormat::kBgr8, 640, 480).view(), family), ElementsAre(Pair("hint_black", 1)));
  test::KnownFrame soft = Marker(7);
  soft.scene.background.kind = BackgroundKind::kTiles;
  soft.options.blur_sigma_px = 9;
  EXPECT_THAT(HintsOf(soft.Draw().view(), family), ElementsAre(Pair("hint_blurred", 1)));
  test::KnownFrame empty = Marker(7);
  empty.scene.markers.clear();
  EXPECT_THAT(HintsOf(empty.Draw().view(), family), ElementsAre(Pair("hint_no_board", 1)));
  test::KnownFrame mirrored = Marker(7);
  for (SceneMarker& marker : mirrored.scene.markers) marker.mirrored = true;
  EXPECT_THAT(HintsOf(mirrored.Draw().view(), family), ElementsAre(Pair("hint_mirrored", 1)));
}

TEST(Hints, TellARosterThatLeavesAnIdOut) {
  EXPECT_THAT(HintsOf(Marker(77).Draw().view(), Family(Variant::kSecded, {1, 2})),
              ElementsAre(Pair("hint_outside_roster", 1)));
}

TEST(Hints, TellTheVariantOverSomeFrames) {
  const MarkerFamily sought = Family(Variant::kUnconstrained);
  Hints hints({sought});
  const auto show = [&](std::uint64_t id) { hints.Take(Look(Marker(id, id).Draw().view(), sought)); };
  show(1000);
  EXPECT_THAT(Counts(hints), IsEmpty()) << "one board may be of any";
  for (std::uint64_t id = 1001; id < 1005; ++id) show(id);
  EXPECT_THAT(Counts(hints), ElementsAre(Pair("hint_looks_like_secded", 5)));
  EXPECT_THAT(Counts(hints), ElementsAre(Pair("hint_looks_like_secded", 5))) << "as long as it is so";
}

TEST(Hints, ForgetPrintsThatWereChanged) {
  const MarkerFamily sought = Family(Variant::kUnconstrained);
  Hints hints({sought});
  FrameLook look;
  for (std::uint64_t id = 1000; id < 1006; ++id)
    look.kernels.push_back({0, MarkerCode({6, 6}, Variant::kSecded).Encode(id), true});
  hints.Take(look);
  EXPECT_FALSE(Counts(hints).empty());
  for (int i = 0; i < 100; ++i) hints.Take({});
  EXPECT_THAT(Counts(hints), IsEmpty());
}

TEST(Hints, SayNothingOfAFrameThatWasNotLookedAt) {
  Hints hints({Family(Variant::kSecded)});
  hints.Take({});
  EXPECT_THAT(Counts(hints), IsEmpty());
}

}  // namespace
}  // namespace chequer
