#include "chequer/camera_model.h"

#include <gtest/gtest.h>

#include <random>

namespace chequer {
namespace {

CameraModel WideLens() {
  CameraModel camera{.width = 640, .height = 480, .fx = 540.5, .fy = 538, .cx = 322.3, .cy = 237.1};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.25, 0.08, 0.001, -0.0005, 0.01};
  return camera;
}

CameraModel FisheyeLens() {
  CameraModel camera{.width = 1280, .height = 960, .fx = 620, .fy = 621, .cx = 640, .cy = 480};
  camera.kind = CameraModel::Kind::kFisheye;
  camera.distortion = {-0.02, 0.003, -0.001, 0.0002, 0};
  return camera;
}

void ExpectRoundTrip(const CameraModel& camera) {
  for (int y = 0; y < camera.height; y += 37)
    for (int x = 0; x < camera.width; x += 41) {
      const Eigen::Vector2d pixel(x, y);
      const auto normalized = camera.Undistort(pixel);
      ASSERT_TRUE(normalized.has_value()) << "at " << pixel.transpose();
      EXPECT_LT((camera.Distort(*normalized) - pixel).norm(), 1e-8) << "at " << pixel.transpose();
    }
}

TEST(CameraModel, UndistortInvertsBrownConrady) { ExpectRoundTrip(WideLens()); }
TEST(CameraModel, UndistortInvertsFisheye) { ExpectRoundTrip(FisheyeLens()); }

TEST(CameraModel, BrownConradyFollowsOpenCvsDefinition) {
  // Worked by hand from OpenCV's formula at x = 0.3, y = -0.2: r2 = 0.13.
  const CameraModel camera = WideLens();
  const double r2 = 0.13, radial = 1 - 0.25 * r2 + 0.08 * r2 * r2 + 0.01 * r2 * r2 * r2;
  const double xd = 0.3 * radial + 2 * 0.001 * 0.3 * -0.2 + -0.0005 * (r2 + 2 * 0.09);
  const double yd = -0.2 * radial + 0.001 * (r2 + 2 * 0.04) + 2 * -0.0005 * 0.3 * -0.2;
  const Eigen::Vector2d pixel = camera.Project({0.6, -0.4, 2});
  EXPECT_NEAR(pixel.x(), 540.5 * xd + 322.3, 1e-10);
  EXPECT_NEAR(pixel.y(), 538 * yd + 237.1, 1e-10);
}

TEST(CameraModel, JacobianIsTheDerivative) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-0.5, 0.5);
  for (const CameraModel& camera : {WideLens(), FisheyeLens()})
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d p(place(random), place(random));
      Eigen::Matrix2d jacobian;
      camera.Distort(p, &jacobian);
      for (int k = 0; k < 2; ++k) {
        const Eigen::Vector2d h = 1e-6 * Eigen::Vector2d::Unit(k);
        const Eigen::Vector2d numeric = (camera.Distort(p + h) - camera.Distort(p - h)) / 2e-6;
        EXPECT_LT((jacobian.col(k) - numeric).norm(), 1e-5) << "at " << p.transpose();
      }
    }
}

TEST(CameraModel, BeyondTheFoldThereIsNoPoint) {
  CameraModel camera = WideLens();
  camera.distortion = {-0.5, 0, 0, 0, 0};  // turns back at r = sqrt(2/3)
  EXPECT_FALSE(camera.Undistort({camera.cx + 3 * camera.fx, camera.cy}).has_value());
}

}  // namespace
}  // namespace chequer
