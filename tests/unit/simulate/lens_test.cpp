#include "simulate/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "simulate/layouts.h"
#include "simulate/render.h"

namespace chequer {
namespace {

CameraModel Pinhole(int width = 64, int height = 48) {
  return {.width = width, .height = height, .fx = 100, .fy = 100, .cx = width / 2.0, .cy = height / 2.0};
}

/// A plain white square of light 1 on black.
SceneMarker WhiteSquare(const RigidTransform& pose, double side_m) {
  SceneMarker marker;
  marker.board = {.rows = 1, .cols = 1, .cells = "W", .uncounted_rim = 0, .id = 0, .variant = {}};
  marker.side_m = side_m;
  marker.inks = *NamedInks("ideal");
  marker.camera_from_marker = pose;
  return marker;
}

RenderOptions Options(const CameraModel& camera, double sigma_px) {
  RenderOptions options;
  options.camera = camera;
  options.blur_sigma_px = sigma_px;
  return options;
}

LinearImage LightOf(const SceneMarker& marker, const RenderOptions& options) {
  Scene scene;
  scene.markers = {marker};
  scene.background.colour.setZero();
  return RenderLight(scene, options);
}

struct Centroid {
  double sum = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
};

Centroid Measure(const LinearImage& light) {
  Centroid c;
  for (int y = 0; y < light.height; ++y)
    for (int x = 0; x < light.width; ++x) {
      const double value = static_cast<double>(light.Pixel(x, y)[1]);
      c.sum += value;
      c.x += value * x;
      c.y += value * y;
      c.xx += value * x * x;
      c.yy += value * y * y;
      c.xy += value * x * y;
    }
  c.x /= c.sum;
  c.y /= c.sum;
  c.xx = c.xx / c.sum - c.x * c.x;
  c.yy = c.yy / c.sum - c.y * c.y;
  c.xy = c.xy / c.sum - c.x * c.y;
  return c;
}

double Phi(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

/// The mean over the pixel (x, y) of a half-plane's light behind a Gaussian: lit where n · p > offset.
double EdgeLight(int x, int y, const Eigen::Vector2d& n, double offset, double sigma) {
  constexpr int kSteps = 40;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const Eigen::Vector2d p(x - 0.5 + (i + 0.5) / kSteps, y - 0.5 + (j + 0.5) / kSteps);
      sum += Phi((n.dot(p) - offset) / sigma);
    }
  return sum / (kSteps * kSteps);
}

TEST(PointSpread, WeightsSumToOneAndAreSymmetric) {
  for (const double sigma : {0.0, 0.3, 0.6, 1.3, 4.0}) {
    const PointSpread spread(sigma);
    for (const auto& weights : {spread.fine(), spread.coarse()}) {
      EXPECT_NEAR(std::accumulate(weights.begin(), weights.end(), 0.0f), 1, 1e-5) << sigma;
      for (std::size_t i = 0; i < weights.size(); ++i) EXPECT_NEAR(weights[i], weights[weights.size() - 1 - i], 1e-7f);
    }
    EXPECT_EQ(spread.coarse().size(), static_cast<std::size_t>(2 * spread.reach() + 1));
  }
}

TEST(SeeThroughLens, SharpEdgesFollowTheIntegral) {
  for (const double sigma : {0.3, 0.5, 0.7, 1.0, 2.0})
    for (const double angle : {0.0, 0.1, 0.5, M_PI / 4, 2.0})
      for (const double phase : {0.0, 0.25, 0.5, 0.8}) {
        // A square so large that its right side is a half-plane's edge through the middle of the frame.
        const Eigen::Vector2d n(-std::cos(angle), -std::sin(angle));
        const CameraModel camera = Pinhole(24, 24);
        const Eigen::Vector2d at(12 + phase, 12.3);
        const double side = 8.0;
        const Eigen::Vector2d centre_px = at + n * side * 50;
        const Eigen::Vector3d position((centre_px.x() - camera.cx) / 100, (centre_px.y() - camera.cy) / 100, 1);
        const LinearImage light = LightOf(WhiteSquare(FacingPose(position, angle), side), Options(camera, sigma));
        double worst = 0;
        for (int y = 0; y < 24; ++y)
          for (int x = 0; x < 24; ++x)
            worst = std::max(
                worst, std::abs(static_cast<double>(light.Pixel(x, y)[0]) - EdgeLight(x, y, n, n.dot(at), sigma)));
        EXPECT_LT(worst, 1e-3) << "sigma " << sigma << ", angle " << angle << ", phase " << phase;
      }
}

TEST(SeeThroughLens, KeepsEnergyAndPlace) {
  for (const double sigma : {0.0, 0.4, 0.8, 1.7, 3.0})
    for (const double heading : {0.0, 0.3, 1.1}) {
      const Eigen::Vector3d position(0.0137, -0.0211, 1);
      const CameraModel camera = Pinhole();
      const SceneMarker square = WhiteSquare(FacingPose(position, heading), 0.1537);
      const Centroid c = Measure(LightOf(square, Options(camera, sigma)));
      const double side_px = 15.37;
      EXPECT_NEAR(c.sum, side_px * side_px, 1e-3 * side_px * side_px) << sigma;
      const Eigen::Vector2d expected = CenterPx(square, camera);
      // Without blur, taking a partly covered pixel's middle for its part's is off by up to 0.005 px.
      const double tolerance = sigma == 0 ? 5e-3 : 2e-3;
      EXPECT_NEAR(c.x, expected.x(), tolerance) << "sigma " << sigma << ", heading " << heading;
      EXPECT_NEAR(c.y, expected.y(), tolerance) << "sigma " << sigma << ", heading " << heading;
      // A square's variance, the lens' and the pixel's.
      EXPECT_NEAR(c.xx, side_px * side_px / 12 + sigma * sigma + 1 / 12.0, 0.05) << sigma;
    }
}

TEST(SeeThroughLens, EdgesLieWhereTheDistortedCameraPutsThem) {
  // Off the middle of a strongly distorting lens; each row's light gives the mean place of the left side in that row.
  const CameraModel camera = PublicationCamera();
  const Eigen::Vector3d position(-0.25, 0.12, 0.6);
  const SceneMarker square = WhiteSquare(FacingPose(position, 0.05, 0.3, 1.0), 0.12);
  for (const double sigma : {0.0, 0.7}) {
    const LinearImage light = LightOf(square, Options(camera, sigma));
    const auto edge_x = [&](double y) {
      double low = 0, high = 1;
      const auto at = [&](double row) { return camera.Project(square.camera_from_marker * square.PointAt(0, row)); };
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (at(middle).y() < y ? low : high) = middle;
      }
      return at(low).x();
    };
    const Eigen::Vector2d centre = CenterPx(square, camera);
    const int inside = static_cast<int>(centre.x());
    for (int y = static_cast<int>(centre.y()) - 25; y <= centre.y() + 25; ++y) {
      double lit = 0, expected = 0;
      for (int x = inside - 80; x <= inside; ++x) lit += static_cast<double>(light.Pixel(x, y)[0]);
      for (int i = 0; i < 20; ++i) expected += edge_x(y - 0.5 + (i + 0.5) / 20) / 20;
      EXPECT_NEAR(inside + 0.5 - lit, expected, 2e-3) << "row " << y << ", sigma " << sigma;
    }
  }
}

TEST(SeeThroughLens, BackgroundIsBlurredAlikeWithAndWithoutMarkersNear) {
  // A marker of the background's own colour must not be seen.
  Background background;
  background.kind = BackgroundKind::kPlain;
  background.colour = {0.85f, 0.85f, 0.84f};
  Scene scene;
  scene.background = background;
  SceneMarker marker = WhiteSquare(FacingPose({0, 0, 1}, 0.4), 0.2);
  marker.inks = InkSet{};
  scene.markers = {marker};
  const LinearImage light = RenderLight(scene, Options(Pinhole(), 0.8));
  for (int y = 0; y < light.height; ++y)
    for (int x = 0; x < light.width; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.Pixel(x, y)[c], background.colour[c], 1e-4f);
}

TEST(SeeThroughLens, TexturedBackgroundHasNoSeamWhereMarkersAreDrawn) {
  LinearImage background(70, 60);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 70; ++x)
      for (int c = 0; c < 3; ++c) background.Pixel(x, y)[c] = static_cast<float>((7 * x + 13 * y + c) % 11) / 11;
  const PointSpread spread(0.7);
  // A layer without area forces the fine way of rendering.
  Layer empty;
  empty.low = {5, 5};
  empty.high = {40, 30};
  const LinearImage plain = SeeThroughLens(background, spread.reach(), {}, spread);
  const LinearImage fine = SeeThroughLens(background, spread.reach(), {empty}, spread);
  for (std::size_t i = 0; i < plain.rgb.size(); ++i) ASSERT_NEAR(plain.rgb[i], fine.rgb[i], 1e-5f) << i;
}

TEST(Smear, KeepsEnergyAndPlaceAndWidensAlongItsDirection) {
  const CameraModel camera = Pinhole();
  const SceneMarker square = WhiteSquare(FacingPose({0.01, 0.02, 1}, 0), 0.1);
  const LinearImage sharp = LightOf(square, Options(camera, 0.7));
  const Centroid before = Measure(sharp);
  for (const double length : {1.0, 3.0, 7.3})
    for (const double angle : {0.0, 0.6, M_PI / 2, 2.5}) {
      const Centroid after = Measure(Smear(sharp, length, angle));
      EXPECT_NEAR(after.sum, before.sum, 1e-3 * before.sum);
      EXPECT_NEAR(after.x, before.x, 1e-3);
      EXPECT_NEAR(after.y, before.y, 1e-3);
      // Of a line: length² / 12 along it; up to 1/4 px² from spreading over pixels.
      const double along = length * length / 12;
      EXPECT_NEAR(after.xx - before.xx, along * std::cos(angle) * std::cos(angle), 0.26);
      EXPECT_NEAR(after.yy - before.yy, along * std::sin(angle) * std::sin(angle), 0.26);
      EXPECT_NEAR(after.xy - before.xy, along * std::cos(angle) * std::sin(angle), 0.05);
    }
}

}  // namespace
}  // namespace chequer
