#include "tools/detection_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tools/canvas.h"

namespace chequer {
namespace {

constexpr double kScreenWidth = 1280, kMostEnlarged = 2;
constexpr Ink kRead{0.1, 0.95, 0.25}, kUnread{1, 0.65, 0}, kIdShade{0, 0, 0, 0.75};

/// BGR8 of another size; areas are averaged where it gets smaller.
Image Resized(const ImageView& image, double scale) {
  const int width = std::max(1, static_cast<int>(std::lround(image.width() * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(image.height() * scale)));
  Image resized(PixelFormat::kBgr8, width, height, image.tone_curve());
  // OpenCV reads it only, but knows no view of constant pixels.
  const cv::Mat from(image.height(), image.width(), CV_8UC3, const_cast<std::uint8_t*>(image.row(0)),
                     static_cast<std::size_t>(image.plane(0).stride_bytes));
  cv::Mat to(height, width, CV_8UC3, resized.bytes().data());
  cv::resize(from, to, to.size(), 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return resized;
}

/// The pixel of a place on the board by the homography of its inner corners.
class BoardPlane {
 public:
  /// False where too few corners were seen.
  bool Fit(const MarkerPose& marker) {
    std::vector<cv::Point2d> cells, pixels;
    for (int i = 0; i < CornerCount(marker.size); ++i) {
      const Eigen::Vector2f& corner = marker.corners[static_cast<std::size_t>(i)];
      if (!corner.allFinite()) continue;
      const int columns = marker.size.cols - 1;
      cells.emplace_back(i % columns + 1, i / columns + 1);
      pixels.emplace_back(corner.x(), corner.y());
    }
    if (cells.size() < 4) return false;
    // The affine part by least squares is enough for an outline.
    cv::Mat equations(static_cast<int>(cells.size()), 3, CV_64F), values(static_cast<int>(cells.size()), 2, CV_64F);
    for (int i = 0; i < equations.rows; ++i) {
      const auto& cell = cells[static_cast<std::size_t>(i)];
      const auto& pixel = pixels[static_cast<std::size_t>(i)];
      equations.at<double>(i, 0) = cell.x, equations.at<double>(i, 1) = cell.y, equations.at<double>(i, 2) = 1;
      values.at<double>(i, 0) = pixel.x, values.at<double>(i, 1) = pixel.y;
    }
    return cv::solve(equations, values, affine_, cv::DECOMP_SVD);
  }
  /// @param col cells from the board's left. @param row from its top.
  Eigen::Vector2d operator()(double col, double row) const {
    const auto at = [&](int axis) {
      return affine_.at<double>(0, axis) * col + affine_.at<double>(1, axis) * row + affine_.at<double>(2, axis);
    };
    return {at(0), at(1)};
  }

 private:
  cv::Mat affine_;
};

void DrawArrow(Canvas& canvas, const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Ink& ink) {
  const Eigen::Vector2d along = to - from, beside(-along.y(), along.x());
  canvas.Line(from.x(), from.y(), to.x(), to.y(), ink, 2.5);
  const std::array<Eigen::Vector2d, 3> head{to + 0.12 * along, to - 0.16 * along + 0.16 * beside,
                                            to - 0.16 * along - 0.16 * beside};
  canvas.FillPolygon(head, ink);
}

void DrawMarker(Canvas& canvas, const MarkerPose& marker, double scale) {
  BoardPlane plane;
  if (!plane.Fit(marker)) return;
  const auto at = [&](double col, double row) {
    const Eigen::Vector2d pixel = plane(col, row);
    return Eigen::Vector2d((pixel.x() + 0.5) * scale, (pixel.y() + 0.5) * scale);
  };
  const double cols = marker.size.cols, rows = marker.size.rows;
  const Ink ink = marker.id ? kRead : kUnread;
  const std::array<Eigen::Vector2d, 4> outline{at(0, 0), at(cols, 0), at(cols, rows), at(0, rows)};
  canvas.Polyline(outline, ink, 2.5, true);
  DrawArrow(canvas, at(cols, rows / 2), at(1.5 * cols, rows / 2), ink);
  const std::string text = marker.id ? std::to_string(*marker.id) : "?";
  const double size = std::clamp(0.4 * (outline[1] - outline[0]).norm(), 13.0, 26.0);
  const double width = canvas.TextWidth(text, size, true);
  const Eigen::Vector2d middle = at(cols / 2, rows / 2);
  canvas.Rectangle(middle.x() - width / 2 - 3, middle.y() - 0.55 * size, width + 6, 1.1 * size, kIdShade);
  canvas.Text(text, middle.x(), middle.y() + 0.36 * size, size, {1, 1, 1}, Align::kMiddle, true);
}

}  // namespace

std::vector<std::uint8_t> DrawDetection(const ImageView& image, std::span<const MarkerPose> markers) {
  const double scale = std::min(kScreenWidth / image.width(), kMostEnlarged);
  const Image screen = Resized(image, scale);
  Canvas canvas = Canvas::Png(screen.view().width(), screen.view().height());
  canvas.Picture(screen.view(), 0, 0, 1);
  for (const MarkerPose& marker : markers) DrawMarker(canvas, marker, scale);
  return canvas.Finish();
}

}  // namespace chequer
