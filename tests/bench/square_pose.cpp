#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "bench/contestants.h"
#include "bench/grey.h"

namespace chequer::bench {

void ConvertToGrey(const Image& colour, cv::Mat& grey) {
  const ImageView view = colour.view();
  // OpenCV's header takes no const pixels; it only reads them.
  const cv::Mat bgr(view.height(), view.width(), CV_8UC3, const_cast<std::uint8_t*>(view.row(0)),
                    static_cast<std::size_t>(view.plane(0).stride_bytes));
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
}

RigidTransform PoseOfSquare(std::span<const Eigen::Vector2d> corners_px, double side_m, const CameraModel& camera) {
  const double half = side_m / 2;
  const std::vector<cv::Point3d> in_marker{{-half, half, 0}, {half, half, 0}, {half, -half, 0}, {-half, -half, 0}};
  std::vector<cv::Point2d> in_image;
  for (const Eigen::Vector2d& corner : corners_px) in_image.emplace_back(corner.x(), corner.y());
  const cv::Matx33d intrinsics(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
  cv::Vec3d rotation;
  cv::Vec3d translation;
  // The closed form picks the better of the two poses of a square, the iteration then fits the corners best.
  cv::solvePnP(in_marker, in_image, intrinsics, distortion, rotation, translation, false, cv::SOLVEPNP_IPPE_SQUARE);
  cv::solvePnP(in_marker, in_image, intrinsics, distortion, rotation, translation, true, cv::SOLVEPNP_ITERATIVE);
  return {RotationFromVector({rotation[0], rotation[1], rotation[2]}),
          {translation[0], translation[1], translation[2]}};
}

}  // namespace chequer::bench
