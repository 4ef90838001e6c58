#include "simulate/stream.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "simulate/lens.h"
#include "simulate/outline.h"

namespace chequer {
namespace {

Stream StreamOf(const std::string& text) { return Stream(ParseScenario(text, "s.toml")); }

const std::string kSmall = "[camera]\nsize = \"320x240\"\nfocal_px = 400\ndistance = 1.5\nfps = 50\n";
const std::string kFour = "[swarm]\nrobots = 4\nside = 0.15\ngap = 0.01\n";

std::string StreamPhase(const std::string& kind, int frames, const std::string& more = {}) {
  return "[[phase]]\nkind = \"" + kind + "\"\nframes = " + std::to_string(frames) + "\n" + more + "\n";
}

double MeanOf(const Image& image) {
  const auto bytes = image.bytes();
  return std::accumulate(bytes.begin(), bytes.end(), 0.0) / static_cast<double>(bytes.size());
}

SceneMarker OneBoard(double x_m) {
  SceneMarker marker;
  marker.board = MakeBoard(MarkerCode(MarkerSize{}, Variant::kSecded), 5);
  marker.side_m = 0.24;
  marker.camera_from_marker = FacingPose({x_m, 0, 1}, 0.4);
  return marker;
}

/// Light of layers over grey.
LinearImage LightOf(const std::vector<Layer>& layers, const PointSpread& spread) {
  const int rim = spread.reach();
  LinearImage grey(120 + 2 * rim, 100 + 2 * rim);
  std::fill(grey.rgb.begin(), grey.rgb.end(), 0.3f);
  return SeeThroughLens(grey, rim, layers, spread);
}

const CameraModel kSmallCamera{.width = 120, .height = 100, .fx = 300, .fy = 300, .cx = 60, .cy = 50};

TEST(MovingLayers, AreTheMeanOfTheirInstants) {
  const PointSpread spread(0.6);
  MovingMarker moving{OneBoard(0), {}};
  moving.marker.occluders.push_back({.from = {-0.1, -0.1}, .to = {1.1, 0.3}});
  LinearImage mean(120, 100);
  constexpr int kInstants = 9;
  for (int i = 0; i < kInstants; ++i) {
    SceneMarker marker = moving.marker;
    marker.camera_from_marker = FacingPose({0.004 * i, 0.002 * i, 1}, 0.4 + 0.01 * i);
    moving.camera_from_marker.push_back(marker.camera_from_marker);
    const LinearImage one = LightOf(MakeLayers({marker}, kSmallCamera), spread);
    for (std::size_t k = 0; k < mean.rgb.size(); ++k) mean.rgb[k] += one.rgb[k] / kInstants;
  }
  const LinearImage light = LightOf(MakeMovingLayers({moving}, kSmallCamera), spread);
  double worst = 0;
  for (std::size_t k = 0; k < mean.rgb.size(); ++k)
    worst = std::max(worst, static_cast<double>(std::abs(light.rgb[k] - mean.rgb[k])));
  EXPECT_LT(worst, 2e-4);
}

TEST(MovingLayers, BlurAnEdgeAsABoxDoes) {
  // A step from white to black that moves by 8 px across the pixels: the light of a pixel falls linearly.
  SceneMarker marker = OneBoard(0);
  marker.board = {.rows = 1, .cols = 2, .cells = "WK", .uncounted_rim = 0, .id = 0, .variant = {}};
  marker.side_m = 0.3;
  marker.inks = *NamedInks("ideal");
  MovingMarker moving{marker, {}};
  constexpr double kMotionPx = 8;
  constexpr int kInstants = 32;
  for (int i = 0; i < kInstants; ++i)
    moving.camera_from_marker.push_back(FacingPose({((i + 0.5) / kInstants - 0.5) * kMotionPx / 300, 0, 1}, 0));
  const LinearImage light = LightOf(MakeMovingLayers({moving}, kSmallCamera), PointSpread(0));
  for (int x = 50; x <= 70; ++x) {
    // Share of the exposure in which the step, at 60 + s, lies right of the point, averaged over the pixel.
    double share = 0;
    constexpr int kParts = 1000;
    for (int i = 0; i < kParts; ++i)
      share += std::clamp(0.5 - (x - 0.5 + (i + 0.5) / kParts - 60) / kMotionPx, 0.0, 1.0) / kParts;
    EXPECT_NEAR(light.Pixel(x, 50)[1], share, 2e-3) << x;
  }
}

TEST(MovingLayers, AreShearedByARollingShutter) {
  MovingMarker moving{OneBoard(0), {FacingPose({0, 0, 1}, 0)}};
  const Layer still = MakeMovingLayers({moving}, kSmallCamera)[0];
  moving.by_row = {.row = 50, .step = {0.0001, 0, 0}};
  const Layer sheared = MakeMovingLayers({moving}, kSmallCamera)[0];
  ASSERT_EQ(sheared.edges.size(), still.edges.size());
  // 0.1 mm from a row to the next are 0.03 px.
  for (std::size_t i = 0; i < still.edges.size(); ++i) {
    EXPECT_NEAR(sheared.edges[i].from.y(), still.edges[i].from.y(), 1e-9);
    EXPECT_NEAR(sheared.edges[i].from.x(), still.edges[i].from.x() + 0.03 * (still.edges[i].from.y() - 50), 1e-6);
  }
  // One that goes down with the rows by a tenth of one is longer by a ninth.
  moving.by_row = {.row = 50, .step = {0, 0.1 / 300, 0}};
  const Layer longer = MakeMovingLayers({moving}, kSmallCamera)[0];
  EXPECT_NEAR(longer.high.y() - longer.low.y(), (still.high.y() - still.low.y()) / 0.9, 1e-3);
}

TEST(Stream, TruthIsThatOfTheMomentWhenTheRowOfABoardsMiddleIsExposed) {
  const std::string swarm = kFour + "speed = 0.5\n" + StreamPhase("calm", 20);
  const Stream global = StreamOf(kSmall + swarm), rolling = StreamOf(kSmall + "rows_read_ms = 20\n" + swarm);
  constexpr std::size_t kDriving = 15;
  const FrameTruth before = global.Truth(kDriving - 1), now = global.Truth(kDriving),
                   later = global.Truth(kDriving + 1), shown = rolling.Truth(kDriving);
  ASSERT_EQ(shown.markers.size(), now.markers.size());
  double farthest_m = 0;
  for (std::size_t i = 0; i < now.markers.size(); ++i) {
    const auto place = [&](const FrameTruth& truth) { return truth.markers[i].camera_from_marker.translation; };
    const double row = rolling.scenario().camera.render.camera.Project(place(shown)).y();
    const double frames = 0.02 * ((row + 0.5) / 240 - 0.5) * 50;
    const Eigen::Vector3d velocity = 0.5 * (place(later) - place(before)),
                          change = place(later) - 2 * place(now) + place(before);
    const Eigen::Vector3d expected = place(now) + frames * velocity + 0.5 * frames * frames * change;
    EXPECT_LT((place(shown) - expected).norm(), 2e-4) << i;
    farthest_m = std::max(farthest_m, (place(shown) - place(now)).norm());
  }
  EXPECT_GT(farthest_m, 1e-3);
}

TEST(Stream, GivesTheSameBytesInAnyOrder) {
  const std::string text = kSmall + "background = \"wood\"\n" + kFour + StreamPhase("calm", 2) +
                           StreamPhase("knock", 2) + StreamPhase("shadow", 2) + StreamPhase("turn", 2);
  const Stream a = StreamOf(text), b = StreamOf(text);
  std::vector<Image> forwards;
  for (std::size_t i = 0; i < a.size(); ++i) forwards.push_back(a.Draw(i));
  for (std::size_t i = b.size(); i-- > 0;) EXPECT_TRUE(std::ranges::equal(b.Draw(i).bytes(), forwards[i].bytes())) << i;
  EXPECT_FALSE(std::ranges::equal(a.Draw(0, 1).bytes(), forwards[0].bytes())) << "another round, another noise";
  EXPECT_NEAR(MeanOf(a.Draw(0, 1)), MeanOf(forwards[0]), 0.2);
}

TEST(Stream, HandsOutTheLightBeforeTheNoise) {
  const Stream stream = StreamOf(kSmall + kFour + StreamPhase("calm", 1) + StreamPhase("dark", 1, "light = 0.25"));
  for (std::size_t i = 0; i < stream.size(); ++i) {
    RenderOptions camera = stream.CameraOf(i);
    camera.sensor.full_well_electrons = std::numeric_limits<double>::infinity();
    // Noise that would fall below black lifts the mean a little.
    EXPECT_NEAR(MeanOf(Capture(stream.Light(i), camera, 1)), MeanOf(stream.Draw(i)), 0.6) << i;
  }
}

TEST(Stream, ShowsTheLightOfThePhase) {
  const Stream stream =
      StreamOf("[camera]\nsize = \"320x240\"\nfocal_px = 400\ndistance = 1.5\nvignetting = 0\n" + kFour +
               StreamPhase("calm", 1) + StreamPhase("dark", 1, "light = 0.25") + StreamPhase("bright", 1));
  const ToneCurve curve = ToneCurve::Srgb();
  // The grey floor in a corner, in linear light.
  const auto floor = [&](std::size_t i) {
    const Image image = stream.Draw(i);
    double sum = 0;
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 6; ++x) sum += curve.ToLinear(image.view().row(y)[3 * x + 1] / 255.0) / 36;
    return sum;
  };
  const double calm = floor(0);
  EXPECT_NEAR(calm, 0.35, 0.01);
  EXPECT_NEAR(floor(1) / calm, 0.25, 0.01);
  EXPECT_NEAR(floor(2) / calm, 2, 0.05);
}

TEST(Stream, BandsOfFlickerRunOverARollingShutter) {
  const Stream stream = StreamOf(kSmall + "exposure_ms = 1\nrows_read_ms = 20\n" + kFour +
                                 StreamPhase("flicker", 1, "depth = 0.5\nfrequency_hz = 100"));
  const Image image = stream.Draw(0);
  std::vector<double> rows;
  for (int y = 0; y < 240; ++y) rows.push_back(image.view().row(y)[1] + image.view().row(y)[4]);
  // 20 ms are two periods over 240 rows. The middle row is at a maximum, rows a quarter of the image away too.
  EXPECT_GT(rows[120] - rows[60], 40);
  EXPECT_GT(rows[1] - rows[60], 40);
  EXPECT_NEAR(rows[1], rows[120], 12);
}

TEST(Stream, KnowsHowFarAKnockMovesBoards) {
  const Stream stream = StreamOf(kSmall + kFour + "speed = 0\n" + StreamPhase("knock", 30, "max_px = 9"));
  double longest = 0;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const FrameTruth truth = stream.Truth(i);
    EXPECT_EQ(truth.phase, "knock");
    ASSERT_EQ(truth.markers.size(), 4u);
    for (const TrueMarker& marker : truth.markers) {
      longest = std::max(longest, marker.motion_px);
      EXPECT_EQ(marker.inside, 1) << "knocks leave boards in the image";
      EXPECT_EQ(marker.visible, 1);
    }
  }
  EXPECT_GT(longest, 6);
  // Towards the corners, 1 + tan² of the angle as much.
  EXPECT_LT(longest, 9 * (1 + 0.4 * 0.4 + 0.3 * 0.3));
}

TEST(Stream, MeasuresHowMuchOfABoardIsSeen) {
  const Stream stream = StreamOf(kSmall + kFour + StreamPhase("hands", 1, "share = 0.5\noccluded = [0.25, 0.25]"));
  int occluded = 0;
  for (const TrueMarker& marker : stream.Truth(0).markers) {
    EXPECT_EQ(marker.inside, 1);
    occluded += marker.visible < 1;
    if (marker.visible < 1) {
      EXPECT_NEAR(marker.visible, 0.75, 0.03);
    }
  }
  EXPECT_EQ(occluded, 2);
}

TEST(Stream, BoardsThatLeaveAreSeenInPartAndThenNot) {
  const Stream stream = StreamOf(kSmall + kFour + "speed = 1\n" + StreamPhase("traffic", 200, "share = 1.0"));
  bool part = false, gone = false, whole = false;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const FrameTruth truth = stream.Truth(i);
    gone |= truth.markers.size() < 4;
    for (const TrueMarker& marker : truth.markers) {
      EXPECT_GT(marker.inside, 0);
      EXPECT_EQ(marker.visible, marker.inside);
      part |= marker.inside < 0.9 && marker.inside > 0.1;
      whole |= marker.inside == 1;
    }
  }
  EXPECT_TRUE(part);
  EXPECT_TRUE(gone);
  EXPECT_TRUE(whole);
}

}  // namespace
}  // namespace chequer
