#include "lens/tone_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/tone_distance.h"
#include "lens/lens_target.h"
#include "simulate/render.h"

namespace chequer {
namespace {

/// As boards do: by how far light is off, on top of noise.
ToneCost DistanceFrom(const ToneCurve& truth, int* calls = nullptr) {
  return [truth, calls](const ToneCurve& curve) {
    if (calls != nullptr) ++*calls;
    return std::hypot(0.005, ToneDistance(curve, truth));
  };
}

TEST(ToneSearch, FindsAGammaWithinFewCalls) {
  for (const double gamma : {0.8, 1.0, 1.4, 1.95, 2.6}) {
    int calls = 0;
    const auto found = SearchToneCurve(ToneCurve::Srgb(), DistanceFrom(ToneCurve::Gamma(gamma), &calls));
    ASSERT_TRUE(found);
    EXPECT_NEAR(std::log(found->gamma() / gamma), 0, 0.02) << gamma;
    EXPECT_LT(calls, 40);
  }
}

TEST(ToneSearch, FindsAKnee) {
  const ToneCurve truth = *ToneCurve::Gamma(2.2).WithBends({-0.025f, -0.05f, -0.075f, -0.1f, -0.125f, -0.15f, -0.075f});
  int calls = 0;
  const auto found = SearchToneCurve(ToneCurve::Srgb(), DistanceFrom(truth, &calls));
  ASSERT_TRUE(found);
  EXPECT_LT(ToneDistance(*found, truth), 0.015);
  EXPECT_TRUE(found->is_bent());
  EXPECT_LE(calls, 160);
}

TEST(ToneSearch, LeavesTheStatedCurveWhereItFits) {
  EXPECT_FALSE(SearchToneCurve(ToneCurve::Srgb(), DistanceFrom(ToneCurve::Srgb())));
  EXPECT_FALSE(SearchToneCurve(ToneCurve::Gamma(1.4), DistanceFrom(ToneCurve::Gamma(1.4))));
}

TEST(MarkerTarget, BoardsAreFlatWithTheRightCurveAlone) {
  RenderOptions options;
  options.camera = {.width = 320, .height = 240, .fx = 400, .fy = 400, .cx = 159.5, .cy = 119.5};
  options.processing.curve = {CameraCurve::Kind::kGamma, 1.4};
  MarkerFamily family;
  family.code = MarkerCode({6, 6}, Variant::kSecded);
  family.side_m = 0.1;
  SceneMarker marker;
  marker.camera_from_marker = FacingPose({0, 0, 0.4}, 0.4, 30 * std::numbers::pi / 180);
  marker.board = MakeBoard(family.code, 12);
  marker.side_m = family.side_m;
  Scene scene;
  scene.markers = {marker};
  const Image image = Render(scene, options, 3);
  const auto target = MakeMarkerTarget({family}, false);
  const double stated = target->Read(image.view()).flat_rms_px;
  CameraModel camera = options.camera;
  camera.tone_curve = ToneCurve::Gamma(1.4);
  target->SetCamera(camera);
  const double measured = target->Read(image.view()).flat_rms_px;
  EXPECT_GT(measured, 0);
  EXPECT_LT(measured, 0.6 * stated);
}

}  // namespace
}  // namespace chequer
