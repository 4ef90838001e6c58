#include "simulate/moving_background.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulate/render.h"

namespace chequer {
namespace {

/// Pixels of a level camera to those of one that is turned, as far as the lens is without distortion: what lies behind
/// the boards need not be more exact.
Eigen::Matrix3d TurnedFromLevel(const CameraModel& camera, const Eigen::Quaterniond& camera_from_level) {
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  return k * camera_from_level.toRotationMatrix() * k.inverse();
}

/// How far a frame's camera moves what it sees, at most, pixels.
double FarthestMove(const CameraModel& camera, const FramePlan& frame) {
  double farthest = 0;
  for (const double share : {0.0, 1.0}) {
    const Eigen::Matrix3d map = TurnedFromLevel(camera, frame.CameraAt(share)).inverse();
    for (const int x : {0, camera.width})
      for (const int y : {0, camera.height}) {
        const Eigen::Vector3d corner(x, y, 1);
        farthest = std::max(farthest, ((map * corner).hnormalized() - corner.head<2>()).norm());
      }
  }
  return farthest;
}

cv::Mat Header(const LinearImage& image) {
  return {image.height, image.width, CV_32FC3, const_cast<float*>(image.rgb.data())};
}

}  // namespace

MovingBackground::MovingBackground(const Background& background, const CameraModel& camera,
                                   const std::vector<FramePlan>& frames, const PointSpread& spread)
    : camera_(camera), spread_(spread), plain_(background.kind == BackgroundKind::kPlain), margin_(spread.reach()) {
  double farthest = 0;
  for (const FramePlan& frame : frames)
    if (!plain_) farthest = std::max(farthest, FarthestMove(camera, frame));
  // Half a turn shows what lies a whole picture away, and no more.
  const double whole = std::hypot(camera.width, camera.height);
  margin_ += farthest > 0 ? static_cast<int>(std::ceil(std::min(farthest, whole))) + 2 : 0;
  floor_ = DrawBackground(background, camera.width + 2 * margin_, camera.height + 2 * margin_);
}

LinearImage MovingBackground::Turned(const FramePlan& frame) const {
  const int rim = spread_.reach();
  LinearImage seen(camera_.width + 2 * rim, camera_.height + 2 * rim);
  Eigen::Matrix3d to_seen = Eigen::Matrix3d::Identity(), from_floor = Eigen::Matrix3d::Identity();
  to_seen.topRightCorner<2, 1>().setConstant(rim);
  from_floor.topRightCorner<2, 1>().setConstant(-margin_);
  const Eigen::Matrix3d map = to_seen * TurnedFromLevel(camera_, frame.camera_from_level) * from_floor;
  cv::Mat matrix(3, 3, CV_64F);
  for (int i = 0; i < 9; ++i) matrix.at<double>(i / 3, i % 3) = map(i / 3, i % 3);
  cv::Mat out = Header(seen);
  cv::warpPerspective(Header(floor_), out, matrix, out.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  const Eigen::Vector2d move_px(frame.swing_rad.y() * camera_.fx, -frame.swing_rad.x() * camera_.fy);
  if (move_px.norm() > 0.1) seen = Smear(seen, move_px.norm(), std::atan2(move_px.y(), move_px.x()));
  return seen;
}

SeenBackground MovingBackground::At(const FramePlan& frame) const {
  const bool same = plain_ || (frame.swing_rad.isZero() && kept_ &&
                               kept_->camera_from_level.coeffs() == frame.camera_from_level.coeffs());
  if (kept_ && same && frame.shadow.takes == 0) return {kept_->drawn, kept_->light};
  const bool level = plain_ || (frame.swing_rad.isZero() &&
                                frame.camera_from_level.coeffs() == Eigen::Quaterniond::Identity().coeffs());
  const int rim = spread_.reach();
  LinearImage seen = level && margin_ == rim ? floor_ : Turned(frame);
  if (frame.shadow.takes > 0) {
    const auto drawn = std::make_shared<const LinearImage>(Shaded(std::move(seen), rim, frame.shadow));
    return {drawn, BlurBackground(*drawn, rim, spread_)};
  }
  const auto drawn = std::make_shared<const LinearImage>(std::move(seen));
  LinearImage light = BlurBackground(*drawn, rim, spread_);
  if (plain_ || frame.swing_rad.isZero()) kept_ = {frame.camera_from_level, drawn, light};
  return {drawn, std::move(light)};
}

}  // namespace chequer
