// `chequer explain`: what it tells and draws.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <numbers>

#include "capture/image_file.h"
#include "capture/png.h"
#include "core/convert.h"
#include "core/file.h"
#include "support/scenes.h"
#include "support/temporary_directory.h"
#include "tools/commands.h"
#include "tools/detection_picture.h"
#include "tools/explanation.h"
#include "tools/explanation_place.h"
#include "tools/label_layout.h"
#include "tools/plot.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class ExplainTest : public ::testing::Test {
 protected:
  explicit ExplainTest(test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1234, 14, 3))
      : image_(frame.Draw()) {
    Detector detector{DetectorOptions{}};
    detector.Detect(image_.view(), markers_, &trace_);
    explanation_ = {"frame.png", image_.view(),    markers_,
                    &trace_,     detector.stats(), {0, 0, image_.width(), image_.height()}};
  }

  /// How many pixels of a picture are of about that colour, B G R.
  static int Count(const std::vector<std::uint8_t>& png, std::array<int, 3> colour) {
    const Image picture = ImageFromPng(png);
    int count = 0;
    for (std::size_t i = 0; i + 2 < picture.bytes().size(); i += 3) {
      bool alike = true;
      for (std::size_t c = 0; c < 3; ++c) alike &= std::abs(picture.bytes()[i + c] - colour[c]) < 12;
      count += alike;
    }
    return count;
  }

  static void Run(std::vector<std::string> arguments) {
    CLI::App app;
    AddExplainCommand(app);
    arguments.insert(arguments.begin(), "explain");
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
  }

  Image image_;
  std::vector<MarkerPose> markers_;
  DetectTrace trace_;
  Explanation explanation_;
};

TEST_F(ExplainTest, TellsWhatWasRead) {
  EXPECT_THAT(DescribeExplanation(explanation_), HasSubstr("id 1234"));
  EXPECT_THAT(DescribeExplanation(explanation_), HasSubstr("1 boards > 1 markers"));
}

TEST_F(ExplainTest, CountsWhatIsHiddenByReason) {
  EXPECT_THAT(DescribeExplanation(explanation_), Not(HasSubstr("hidden")));
  ASSERT_FALSE(trace_.candidates.empty());
  TraceCandidate& candidate = trace_.candidates[0];
  ASSERT_EQ(candidate.inner_corners.size(), 25u);
  candidate.inner_corners[0] = candidate.inner_corners[1] = Hidden::kMisfit;
  candidate.inner_corners[2] = Hidden::kOutside;
  EXPECT_THAT(DescribeExplanation(explanation_), HasSubstr("; hidden: 3 corners (1 outside, 2 misfit)"));
  candidate.cells[0].hidden = Hidden::kOffColour;
  EXPECT_THAT(DescribeExplanation(explanation_), HasSubstr("; hidden: 1 cells (1 off_colour), 3 corners"));
}

TEST_F(ExplainTest, ContactSheetFitsAScreenAndShowsTheTroubledFirst) {
  const std::vector<std::uint8_t> read = DrawContactSheet(explanation_);
  const Image sheet = ImageFromPng(read);
  EXPECT_EQ(sheet.width(), kSheetWidth);
  EXPECT_LE(sheet.height(), kSheetHeight);
  // The stripe of the tile: green where it was read, red where it was refused.
  EXPECT_GT(Count(read, {51, 158, 0}), 600);
  ASSERT_FALSE(trace_.candidates.empty());
  trace_.candidates[0].refusal = chequer::Refusal::kBorderDiffers;
  trace_.candidates[0].marker = -1;
  EXPECT_GT(Count(DrawContactSheet(explanation_), {26, 13, 230}), 600);
}

TEST_F(ExplainTest, DetectionsAreDrawnWithTheirIdsOverAnEnlargedImage) {
  const std::vector<std::uint8_t> png = DrawDetection(image_.view(), markers_);
  const Image picture = ImageFromPng(png);
  EXPECT_EQ(picture.width(), std::min(1280, 2 * image_.width()));
  EXPECT_GT(Count(png, {64, 242, 26}), 200);  // the outline
  markers_[0].id.reset();
  EXPECT_EQ(Count(DrawDetection(image_.view(), markers_), {64, 242, 26}), 0);
  EXPECT_GT(Count(DrawDetection(image_.view(), markers_), {0, 166, 255}), 200);
}

// A cell far from all corners that were found has no place. It was drawn wherever the memory said.
TEST_F(ExplainTest, DrawsNothingForCellsWithoutAPlace) {
  ASSERT_FALSE(trace_.candidates.empty());
  TraceCandidate& candidate = trace_.candidates[0];
  candidate.refusal = Refusal::kBorderDiffers;
  // Of the picture, the image's corner below the legend, where nothing is.
  const auto corner = [&] {
    const Image picture = ImageFromPng(DrawExplanation(explanation_, 1, 10));
    std::vector<std::uint8_t> pixels;
    for (int y = 90; y < 120; ++y) {
      const std::uint8_t* row = picture.view().row(y);
      pixels.insert(pixels.end(), row, row + 3 * 60);
    }
    return pixels;
  };
  const auto before = corner();
  alignas(TraceCell) std::array<unsigned char, sizeof(TraceCell)> garbage;
  garbage.fill(0x4e);  // as floats 8.7e8
  const TraceCell* unplaced = new (garbage.data()) TraceCell{};
  EXPECT_FALSE(unplaced->HasPlace());
  for (const std::size_t i : {std::size_t{0}, std::size_t{5}, candidate.cells.size() - 1}) {
    candidate.cells[i].outline_px = unplaced->outline_px;
    candidate.cells[i].center_px = unplaced->center_px;
  }
  EXPECT_EQ(corner(), before);
}

TEST_F(ExplainTest, DrawsStagesAndPanels) {
  const auto png = DrawExplanation(explanation_, 2, 10);
  const Image picture = ImageFromPng(png);
  EXPECT_GE(picture.width(), 2 * 640);
  EXPECT_GT(picture.height(), 2 * 480 + 200) << "a panel below";
  // More than the legend has, which is all that a corner of the image without anything shows.
  const auto large = DrawExplanation(explanation_, 4, 10);
  Explanation nothing = explanation_;
  nothing.region = {0, 0, 40, 30};
  const auto legend = DrawExplanation(nothing, 4, 10);
  EXPECT_GT(Count(large, {255, 217, 0}), Count(legend, {255, 217, 0}) + 100) << "corners";
  EXPECT_GT(Count(large, {77, 242, 26}), Count(legend, {77, 242, 26}) + 100) << "links of squares";
  EXPECT_GT(Count(large, {51, 158, 0}), Count(legend, {51, 158, 0}) + 200) << "the outline of what was read";
  EXPECT_EQ(ImageFromPng(DrawExplanation(explanation_, 2, 0)).height(), picture.height() - 290);
}

TEST_F(ExplainTest, RefusedOnesComeFirstAndSayWhy) {
  TraceCandidate refused;
  refused.refusal = Refusal::kBorderDiffers;
  refused.measured = 12;
  refused.required = 17;
  refused.size = {6, 6};
  refused.cells = trace_.candidates[0].cells;
  refused.center_px = {50, 60};
  trace_.candidates.push_back(refused);
  ASSERT_EQ(ToldCandidates(explanation_), (std::vector<std::size_t>{1, 0}));
  const std::string text = DescribeExplanation(explanation_);
  EXPECT_THAT(text, HasSubstr("1 at (50, 60) px: refused: border_differs; 12 border cells"));
  EXPECT_GT(Count(DrawExplanation(explanation_, 4, 10), {26, 13, 230}), 200) << "in red";
}

/// A marker so steep that only the second look sees it.
class SteepExplainTest : public ExplainTest {
 protected:
  SteepExplainTest()
      : ExplainTest(test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 1234, 15, 2, 77 * std::numbers::pi / 180)) {}
};

TEST_F(SteepExplainTest, TellsPlacesThatWereViewedAgain) {
  const std::string text = DescribeExplanation(explanation_);
  EXPECT_THAT(text, HasSubstr(", by a second look"));
  EXPECT_THAT(text, HasSubstr("P1 at ("));
  EXPECT_THAT(text, HasSubstr("found 1 board"));
  ASSERT_FALSE(ToldPlaces(explanation_).empty());
  explanation_.region = {0, 0, 40, 30};
  EXPECT_TRUE(ToldPlaces(explanation_).empty()) << "they lie elsewhere";
}

TEST_F(SteepExplainTest, DrawsPlacesThatWereViewedAgain) {
  const auto drawn = DrawExplanation(explanation_, 4, 0);
  Explanation nothing = explanation_;
  nothing.region = {0, 0, 40, 30};
  const auto legend = DrawExplanation(nothing, 4, 0);
  constexpr std::array kLook{179, 77, 255};
  EXPECT_GT(Count(drawn, kLook), Count(legend, kLook) + 500) << "the outline, and corners as far as cells leave them";
  const auto with_panels = DrawExplanation(explanation_, 4, 10);
  EXPECT_GT(Count(with_panels, kLook), Count(drawn, kLook) + 200) << "and in the view that was searched";
  EXPECT_GT(ImageFromPng(with_panels).height(), ImageFromPng(drawn).height() + 200);
}

TEST_F(SteepExplainTest, PlacesNearToBeingViewedComeFirst) {
  for (int i = 0; i < 6; ++i)
    for (const PlaceFate fate : {PlaceFate::kFewPoints, PlaceFate::kTooMany}) {
      TracePlace place;
      place.fate = fate;
      place.center_px = {5, 5};
      trace_.places.push_back(place);
    }
  const auto told = ToldPlaces(explanation_);
  ASSERT_GE(told.size(), 5u);
  EXPECT_EQ(trace_.places[told[0]].fate, PlaceFate::kViewed);
  EXPECT_EQ(trace_.places[told.back()].fate, PlaceFate::kTooMany) << "of those that were not, only the nearest to it";
}

TEST(LabelLayout, KeepsLabelsApartAndInside) {
  LabelLayout layout({0, 0, 200, 100});
  std::vector<LabelLayout::Box> boxes;
  for (int i = 0; i < 5; ++i) boxes.push_back(layout.Take({190, 90, 50, 17}));
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    EXPECT_LE(boxes[i].left + boxes[i].width, 200);
    EXPECT_LE(boxes[i].top + boxes[i].height, 100);
    EXPECT_GE(boxes[i].top, 0);
    for (std::size_t k = 0; k < i; ++k)
      EXPECT_GE(std::abs(boxes[i].top - boxes[k].top), 17) << "label " << i << " covers label " << k;
  }
  EXPECT_EQ(layout.Take({20, 30, 50, 17}).top, 30) << "where it is wanted, if that is free";
}

TEST_F(ExplainTest, OnlyTheLargestOfManyGroupsAreTold) {
  for (int i = 0; i < 100; ++i) {
    TraceCandidate group;
    group.refusal = Refusal::kFewLinked;
    group.corners.assign(static_cast<std::size_t>(4 + i % 2), 0);
    group.center_px = {5, 5};
    trace_.candidates.push_back(group);
  }
  const auto told = ToldCandidates(explanation_);
  EXPECT_EQ(told.size(), 31u);
  EXPECT_EQ(trace_.candidates[told[0]].corners.size(), 5u);
  EXPECT_EQ(told.back(), 0u) << "what was read is told in any case";
  EXPECT_THAT(DescribeExplanation(explanation_), HasSubstr("70 more groups"));
}

TEST_F(ExplainTest, ARegionLeavesOutTheRest) {
  explanation_.region = {0, 0, 40, 30};
  EXPECT_TRUE(ToldCandidates(explanation_).empty());
  EXPECT_THAT(DescribeExplanation(explanation_), HasSubstr("no group of corners"));
  EXPECT_GT(DrawExplanation(explanation_, 16, 10).size(), 100u);
}

TEST_F(ExplainTest, TellsWhatTheFramesBeforeLedToExpect) {
  EXPECT_THAT(DescribeExplanation(explanation_), ::testing::Not(HasSubstr("expected by")));
  Detector detector{DetectorOptions{}};
  DetectorMemory memory;
  for (int frame = 1; frame <= 2; ++frame) {
    trace_ = {};
    detector.Detect(image_.view(), std::chrono::milliseconds(20 * frame), memory, markers_, &trace_);
  }
  explanation_.markers = markers_;
  explanation_.stats = detector.stats();
  const std::string text = DescribeExplanation(explanation_);
  EXPECT_THAT(text, HasSubstr("expected by the frames before: 1 boards, 1 of them read there"));
  EXPECT_THAT(text, HasSubstr("id 1234 at ("));
  EXPECT_THAT(text, HasSubstr("px from where it was expected"));
}

TEST_F(ExplainTest, TheCommandTakesAFrameOfARecording) {
  const test::TemporaryDirectory folder;
  for (const char* name : {"0.png", "1.png", "2.png"}) WriteFileAtomically(folder / name, PngFromImage(image_.view()));
  const std::string recording = folder.path().string();
  testing::internal::CaptureStdout();
  Run({"--sequence", recording, "--frame", "1"});
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("1 boards, 1 of them read there"));
  EXPECT_THROW(Run({"--sequence", recording, "--frame", "3"}), CLI::ValidationError);
  EXPECT_THROW(Run({}), CLI::ValidationError);
}

TEST_F(ExplainTest, TooLargeAPictureIsRefused) {
  const Image wide(PixelFormat::kBgr8, 16000, 32);
  explanation_.image = wide.view();
  explanation_.region = {0, 0, 16000, 32};
  EXPECT_THROW(DrawExplanation(explanation_, 4, 10), std::runtime_error);
}

TEST_F(ExplainTest, TheCommandWritesThePicture) {
  const test::TemporaryDirectory folder;
  WriteFileAtomically(folder / "frame.png", PngFromImage(image_.view()));
  const std::string in = (folder / "frame.png").string(), out = (folder / "why.png").string();
  Run({in, "--out", out, "--scale", "1"});
  EXPECT_EQ(LoadImage(out).width(), 1410);
  Run({in, "--region", "300,200,40,40"});
  EXPECT_THROW(Run({in, "--region", "600,200,80,40"}), CLI::ValidationError);
  EXPECT_THROW(Run({in, "--region", "600,200"}), CLI::ParseError);
  EXPECT_THROW(Run({in, "--scale", "0"}), CLI::ParseError);
  EXPECT_THROW(Run({(folder / "missing.png").string()}), std::runtime_error);
  EXPECT_THROW(Run({in, "--out", (folder / "no/such/why.png").string()}), std::runtime_error);
}

TEST(RoundSteps, AreRoundAndWithin) {
  const auto near = [](double value) { return ::testing::DoubleNear(value, 1e-12); };
  EXPECT_THAT(RoundSteps(0, 1, 5),
              ::testing::ElementsAre(near(0), near(0.2), near(0.4), near(0.6), near(0.8), near(1)));
  EXPECT_THAT(RoundSteps(-0.3, 0.7, 2), ::testing::ElementsAre(near(0), near(0.5)));
  EXPECT_TRUE(RoundSteps(1, 1, 5).empty());
}

}  // namespace
}  // namespace chequer
