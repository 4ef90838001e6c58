#include "tools/undistort.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "chequer/check.h"
#include "core/convert.h"

namespace chequer {

/// Where each pixel is to be fetched from.
struct Undistorter::Maps {
  cv::Mat first;
  cv::Mat second;
};

Undistorter::Undistorter(const CameraModel& camera) : pinhole_(camera), maps_(std::make_unique<Maps>()) {
  pinhole_.kind = CameraModel::Kind::kPinhole;
  pinhole_.distortion = {};
  cv::Mat from(camera.height, camera.width, CV_32FC2);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d pixel = camera.Distort({(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy});
      from.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
    }
  cv::convertMaps(from, cv::noArray(), maps_->first, maps_->second, CV_16SC2);
}

Undistorter::~Undistorter() = default;

Image Undistorter::Undistort(const ImageView& image) const {
  CHEQUER_CHECK(image.width() == pinhole_.width && image.height() == pinhole_.height, "not the camera's size");
  Image bgr = ToBgr(image);
  Image straight(PixelFormat::kBgr8, image.width(), image.height(), image.tone_curve());
  const cv::Mat from(image.height(), image.width(), CV_8UC3, bgr.bytes().data());
  cv::Mat to(image.height(), image.width(), CV_8UC3, straight.bytes().data());
  cv::remap(from, to, maps_->first, maps_->second, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return straight;
}

}  // namespace chequer
