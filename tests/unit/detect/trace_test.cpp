// What the stages write down, and by what constructed frames are refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "support/scenes.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

struct Traced {
  std::vector<MarkerPose> markers;
  DetectTrace trace;
};

Traced Look(const test::KnownFrame& frame, const MarkerCode& sought) {
  DetectorOptions options;
  options.families = {MarkerFamily{sought, 0.12, {}}};
  options.camera = frame.options.camera;
  Traced traced;
  Detector(options).Detect(frame.Draw().view(), traced.markers, &traced.trace);
  return traced;
}

MarkerCode Secded() { return MarkerCode({6, 6}, Variant::kSecded); }
test::KnownFrame Frame(double cell_px = 14) { return test::OneMarker(Secded(), 1234, cell_px, 3); }

/// The candidate nearest to the frame's marker.
const TraceCandidate& TheMarker(const Traced& traced, const test::KnownFrame& frame) {
  const Eigen::Vector2d center = CenterPx(frame.scene.markers[0], frame.options.camera);
  return *std::min_element(traced.trace.candidates.begin(), traced.trace.candidates.end(),
                           [&](const TraceCandidate& a, const TraceCandidate& b) {
                             return (a.center_px - center).norm() < (b.center_px - center).norm();
                           });
}

TEST(Trace, EveryStageLeavesIts) {
  const test::KnownFrame frame = Frame();
  const Traced traced = Look(frame, Secded());
  ASSERT_EQ(traced.markers.size(), 1u);
  const std::vector<Eigen::Vector2d> truth = test::InnerCorners(frame.scene.markers[0], frame.options.camera);
  std::vector<int> found;
  for (const Eigen::Vector2d& corner : truth)
    for (std::size_t i = 0; i < traced.trace.corners.size(); ++i)
      if ((traced.trace.corners[i].position_px.cast<double>() - corner).norm() < 1)
        found.push_back(static_cast<int>(i));
  EXPECT_EQ(found.size(), 25u);
  const auto on_board = [&](int i) { return std::find(found.begin(), found.end(), i) != found.end(); };
  const auto sides = std::count_if(traced.trace.links.begin(), traced.trace.links.end(), [&](const auto& link) {
    return link.in_square && on_board(link.from) && on_board(link.to);
  });
  EXPECT_EQ(sides, 40) << "5 rows and 5 columns of 4 links";

  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_EQ(candidate.refusal, Refusal::kNone);
  EXPECT_EQ(candidate.marker, 0);
  ASSERT_EQ(candidate.cells.size(), 36u);
  const std::vector<std::uint8_t> saturation = CellSaturation({6, 6}, Secded().Encode(1234));
  for (std::size_t i = 0; i < 36; ++i) {
    const TraceCell& cell = candidate.cells[i];
    EXPECT_TRUE(cell.seen) << i;
    ASSERT_TRUE(cell.saturated.has_value()) << i;
    EXPECT_EQ(*cell.saturated, saturation[i] != 0) << i;
    EXPECT_EQ(cell.expected.has_value(), IsBorder({6, 6}, cell.at.row, cell.at.col)) << i;
    EXPECT_TRUE(cell.expected || (cell.log_likelihood > 0) == *cell.saturated) << i;
    const Eigen::Vector2d middle =
        (cell.outline_px[0] + cell.outline_px[1] + cell.outline_px[2] + cell.outline_px[3]).cast<double>() / 4;
    EXPECT_LT((middle - cell.center_px).norm(), 0.3) << i;
  }
  // Where the truth has them: between the inner corners.
  EXPECT_LT((candidate.cells[7].center_px - (truth[0] + truth[1] + truth[5] + truth[6]) / 4).norm(), 0.3);
}

TEST(Stages, CornersLieToThePixelsThatTheHeadersSay) {
  double square = 0;
  int count = 0;
  for (const double cell_px : {4.5, 6.0, 9.0, 14.0, 25.0})
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const test::KnownFrame frame = test::OneMarker(Secded(), 100 * seed, cell_px, seed);
      const Traced traced = Look(frame, Secded());
      ASSERT_EQ(traced.markers.size(), 1u) << frame.name << " at " << cell_px << " px";
      for (const Eigen::Vector2d& truth : test::InnerCorners(frame.scene.markers[0], frame.options.camera)) {
        double nearest = 1e9;
        for (const auto& corner : traced.trace.corners)
          nearest = std::min(nearest, (corner.position_px.cast<double>() - truth).norm());
        if (nearest > 1.5) continue;
        square += nearest * nearest;
        ++count;
      }
    }
  EXPECT_GT(count, 0.95 * 20 * 25) << "nearly all are found";
  EXPECT_LT(std::sqrt(square / count), 0.3 * std::numbers::sqrt2) << "0.3 px along each axis";
}

TEST(Trace, ChangesNothing) {
  const test::KnownFrame frame = Frame(8);
  DetectorOptions options;
  options.families[0].side_m = 0.12;
  options.camera = frame.options.camera;
  Detector detector(options);
  const Image image = frame.Draw();
  DetectTrace trace;
  std::vector<MarkerPose> traced, plain, again;
  detector.Detect(image.view(), plain);
  detector.Detect(image.view(), traced, &trace);
  detector.Detect(image.view(), again);
  ASSERT_EQ(plain.size(), 1u);
  for (const auto& other : {traced, again}) {
    ASSERT_EQ(other.size(), 1u);
    EXPECT_EQ(other[0].id, plain[0].id);
    EXPECT_EQ(other[0].camera_from_marker.translation, plain[0].camera_from_marker.translation);
  }
}

TEST(Trace, ForgetsTheImageBefore) {
  DetectTrace trace;
  std::vector<MarkerPose> markers;
  Detector detector{DetectorOptions{}};
  detector.Detect(Frame().Draw().view(), markers, &trace);
  EXPECT_FALSE(trace.corners.empty());
  detector.Detect(Image(PixelFormat::kBgr8, 64, 64).view(), markers, &trace);
  EXPECT_TRUE(trace.corners.empty());
  EXPECT_TRUE(trace.candidates.empty());
  // Too small to look at.
  detector.Detect(Frame().Draw().view(), markers, &trace);
  detector.Detect(Image(PixelFormat::kBgr8, 8, 8).view(), markers, &trace);
  EXPECT_TRUE(trace.candidates.empty());
}

TEST(Trace, PeaksThatAreNoCornersAreTold) {
  test::KnownFrame frame = Frame();
  frame.scene.background = {.kind = BackgroundKind::kText, .seed = 4};
  EXPECT_FALSE(Look(frame, Secded()).trace.refused_peaks_px.empty());
}

/// So steep that the first look sees no board in it.
test::KnownFrame SteepFrame() { return test::OneMarker(Secded(), 1234, 15, 2, 77 * std::numbers::pi / 180); }

TEST(Trace, ASecondLookLeavesIts) {
  const test::KnownFrame frame = SteepFrame();
  const Traced traced = Look(frame, Secded());
  ASSERT_EQ(traced.markers.size(), 1u);
  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_EQ(candidate.marker, 0);
  ASSERT_GE(candidate.place, 0) << "found in plain view: not steep enough for this test";
  const TracePlace& place = traced.trace.places[static_cast<std::size_t>(candidate.place)];
  EXPECT_EQ(place.fate, PlaceFate::kViewed);
  EXPECT_EQ(place.boards, 1);
  EXPECT_GE(place.points, 6);
  EXPECT_GT(place.slant, 1.8);
  EXPECT_GE(place.views, 1);
  ASSERT_GT(place.side, 16);
  EXPECT_EQ(place.view.size(), static_cast<std::size_t>(place.side * place.side));
  EXPECT_GT(*std::max_element(place.view.begin(), place.view.end()),
            *std::min_element(place.view.begin(), place.view.end()) + 50)
      << "what it shows is told";
  EXPECT_THAT(Explain(place), HasSubstr("found 1 board"));

  // Its corners are told where they lie in the image, and that they are its.
  int found = 0;
  for (const Eigen::Vector2d& truth : test::InnerCorners(frame.scene.markers[0], frame.options.camera))
    found +=
        std::any_of(traced.trace.corners.begin(), traced.trace.corners.end(), [&](const DetectTrace::Corner& corner) {
          return corner.place == candidate.place && (corner.position_px.cast<double>() - truth).norm() < 1.5;
        });
  EXPECT_GE(found, 20);
  EXPECT_GE(place.corners, found);
  EXPECT_GE(place.most_linked, 10);
  // Links join corners of the same look, and those of the view make squares.
  int in_square = 0;
  for (const DetectTrace::Link& link : traced.trace.links) {
    const int from = traced.trace.corners[static_cast<std::size_t>(link.from)].place;
    ASSERT_EQ(from, traced.trace.corners[static_cast<std::size_t>(link.to)].place);
    in_square += from == candidate.place && link.in_square;
  }
  EXPECT_GE(in_square, 16);
  // The view's middle is the place's, and the marker lies in the outline.
  const float half = 0.5f * static_cast<float>(place.side - 1);
  EXPECT_LT((place.image_from_view * Eigen::Vector3f(half, half, 1) - place.center_px.cast<float>()).norm(), 0.01f);
  EXPECT_LT((CenterPx(frame.scene.markers[0], frame.options.camera) - place.center_px).norm(), 10);
}

TEST(Trace, WhatASecondLookRefusesSaysWhy) {
  test::KnownFrame frame = SteepFrame();
  InkSet& inks = frame.scene.markers[0].inks;
  inks.blue = inks.black;
  inks.yellow = inks.white;
  const Traced traced = Look(frame, Secded());
  EXPECT_TRUE(traced.markers.empty());
  ASSERT_FALSE(traced.trace.places.empty());
  EXPECT_EQ(traced.trace.places[0].fate, PlaceFate::kViewed);
  EXPECT_EQ(traced.trace.places[0].boards, 0);
  EXPECT_THAT(Explain(traced.trace.places[0]), HasSubstr("its groups say what refused them"));
  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_EQ(candidate.place, 0);
  EXPECT_EQ(candidate.refusal, Refusal::kNoYellow) << Explain(candidate);
  ASSERT_FALSE(candidate.corners.empty());
  for (const int corner : candidate.corners)
    EXPECT_EQ(traced.trace.corners[static_cast<std::size_t>(corner)].place, 0) << "a corner of the view";
}

TEST(Trace, PlacesThatAreNotViewedSayWhy) {
  test::KnownFrame frame = SteepFrame();
  // Of a marker's inks, and yet none.
  frame.scene.markers[0].mirrored = true;
  // Seven of them, well apart; an image has two second looks.
  const SceneMarker first = frame.scene.markers[0];
  for (const double up : {-0.15, 0.15})
    for (const double right : {-0.25, 0.0, 0.25}) {
      frame.scene.markers.push_back(first);
      frame.scene.markers.back().camera_from_marker.translation += Eigen::Vector3d(right, up, 0);
    }
  const Traced traced = Look(frame, Secded());
  std::string told;
  for (const TracePlace& place : traced.trace.places) told += Explain(place) + "\n";
  const auto count = [&](PlaceFate fate) {
    return std::count_if(traced.trace.places.begin(), traced.trace.places.end(),
                         [&](const TracePlace& place) { return place.fate == fate; });
  };
  EXPECT_EQ(count(PlaceFate::kViewed), 2) << told;
  EXPECT_GE(count(PlaceFate::kTooMany), 1) << told;
}

TEST(Trace, IsOverWithItsImage) {
  // What a traced image leaves behind must not be written to by the next, which nobody traces: its one board is the
  // second look's.
  Detector detector{DetectorOptions{}};
  std::vector<MarkerPose> markers;
  {
    DetectTrace trace;
    detector.Detect(Frame().Draw().view(), markers, &trace);
  }
  detector.Detect(SteepFrame().Draw().view(), markers);
  EXPECT_EQ(markers.size(), 1u);
}

TEST(Places, HaveASentenceOfTheirOwn) {
  std::set<std::string> sentences;
  for (const PlaceFate fate : {PlaceFate::kViewed, PlaceFate::kTooMany, PlaceFate::kSparse, PlaceFate::kLine,
                               PlaceFate::kFrontal, PlaceFate::kTooLarge, PlaceFate::kFewPoints}) {
    TracePlace place;
    place.fate = fate;
    place.points = 17;
    EXPECT_THAT(Explain(place), HasSubstr("17 strong contrasts"));
    sentences.insert(Explain(place));
  }
  EXPECT_EQ(sentences.size(), 7u);
}

TEST(Refusal, OfTooFewCornersInAGroup) {
  test::KnownFrame frame = Frame();
  // Three cells by three are left: four corners.
  frame.scene.markers[0].occluders = {{.from = {0.49, -0.2}, .to = {1.2, 1.2}},
                                      {.from = {-0.2, 0.49}, .to = {1.2, 1.2}}};
  const Traced traced = Look(frame, Secded());
  EXPECT_TRUE(traced.markers.empty());
  ASSERT_FALSE(traced.trace.candidates.empty());
  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_EQ(candidate.refusal, Refusal::kFewLinked) << Explain(candidate);
  EXPECT_EQ(candidate.measured, 4);
  EXPECT_EQ(candidate.required, 6);
  EXPECT_THAT(Explain(candidate), HasSubstr("only 4 corners"));
}

TEST(Refusal, OfASizeThatIsNotSought) {
  const test::KnownFrame frame = Frame();
  const TraceCandidate candidate = TheMarker(Look(frame, MarkerCode({10, 10}, Variant::kSecded)), frame);
  EXPECT_EQ(candidate.refusal, Refusal::kFewCorners) << Explain(candidate);
  EXPECT_EQ(candidate.measured, 25);
  EXPECT_EQ(candidate.corners.size(), 25u);
}

TEST(Refusal, OfPrintsInBlackAndWhite) {
  test::KnownFrame frame = Frame();
  InkSet& inks = frame.scene.markers[0].inks;
  inks.blue = inks.black;
  inks.yellow = inks.white;
  const TraceCandidate candidate = TheMarker(Look(frame, Secded()), frame);
  EXPECT_EQ(candidate.refusal, Refusal::kNoYellow) << Explain(candidate);
  EXPECT_EQ(candidate.cells.size(), 36u) << "what was sampled is told all the same";
}

TEST(Refusal, OfMirrorImages) {
  test::KnownFrame frame = Frame();
  frame.scene.markers[0].mirrored = true;
  const Traced traced = Look(frame, Secded());
  EXPECT_TRUE(traced.markers.empty());
  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_GE(candidate.refusal, Refusal::kNoYellow) << Explain(candidate);
  EXPECT_LE(candidate.refusal, Refusal::kBorderDiffers) << Explain(candidate);
}

TEST(Refusal, OfKernelsThatAreNoWord) {
  const MarkerCode code({6, 6}, Variant::kUnconstrained);
  // 0x1234 is four cells or more from every word of Reed and Muller's code.
  const test::KnownFrame frame = test::OneMarker(code, 0x1234, 14, 3);
  const Traced traced = Look(frame, MarkerCode({6, 6}, Variant::kReedMuller));
  ASSERT_EQ(traced.markers.size(), 1u) << "the board is certain";
  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_EQ(candidate.refusal, Refusal::kNoWord) << Explain(candidate);
  EXPECT_EQ(candidate.marker, 0);
  EXPECT_EQ(candidate.required, 3);
  EXPECT_GT(candidate.measured, 3);
}

TEST(Refusal, OfIdsThatOccludedCellsLeaveOpen) {
  const MarkerCode code({6, 6}, Variant::kUnconstrained);
  test::KnownFrame frame = test::OneMarker(code, 0x1234, 14, 3);
  // Of the second row and the border above it nothing is seen.
  frame.scene.markers[0].occluders = {{.from = {-0.1, -0.1}, .to = {1.1, 0.32}}};
  const Traced traced = Look(frame, code);
  ASSERT_EQ(traced.markers.size(), 1u);
  EXPECT_FALSE(traced.markers[0].id.has_value());
  const TraceCandidate& candidate = TheMarker(traced, frame);
  EXPECT_EQ(candidate.refusal, Refusal::kTwoWords) << Explain(candidate);
  EXPECT_LT(candidate.measured, candidate.required);
  EXPECT_FALSE(candidate.cells[8].seen);
}

TEST(Refusal, OfChessboardsThatGoOn) {
  test::KnownFrame frame = Frame();
  frame.scene.markers.clear();
  frame.scene.background = {.kind = BackgroundKind::kChess, .seed = 7};
  const Traced traced = Look(frame, Secded());
  EXPECT_TRUE(traced.markers.empty());
  ASSERT_FALSE(traced.trace.candidates.empty());
  for (const TraceCandidate& candidate : traced.trace.candidates) EXPECT_NE(candidate.refusal, Refusal::kNone);
}

TEST(Refusal, HasANameAndASentenceOfItsOwn) {
  std::set<std::string> names, sentences;
  for (int i = 0; i < kRefusals; ++i) {
    TraceCandidate candidate;
    candidate.refusal = static_cast<Refusal>(i);
    EXPECT_FALSE(RefusalName(candidate.refusal).empty());
    EXPECT_FALSE(Explain(candidate).empty());
    names.emplace(RefusalName(candidate.refusal));
    sentences.insert(Explain(candidate));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kRefusals));
  EXPECT_EQ(sentences.size(), static_cast<std::size_t>(kRefusals));
}

}  // namespace
}  // namespace chequer
