// Real photographs of a chessboard (tests/data/chessboard), and what OpenCV makes of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/image_file.h"
#include "lens/calibrate_lens.h"
#include "lens/lens_picture.h"
#include "lens/lens_target.h"

namespace chequer {
namespace {

constexpr Chessboard kBoard{.rows = 6, .cols = 9, .square_m = 0.025};

std::vector<Image> Photographs() {
  std::vector<Image> images;
  for (int number = 1; number <= 14; ++number) {
    const std::string digits = (number < 10 ? "0" : "") + std::to_string(number);
    const std::filesystem::path path =
        std::filesystem::path(CHEQUER_TEST_DATA) / "data/chessboard" / ("left" + digits + ".jpg");
    if (std::filesystem::exists(path)) images.push_back(LoadImage(path));
  }
  return images;
}

/// RMS of OpenCV's own way: its corners, its refinement as its examples have it, its solver.
double OpenCvRms(const std::vector<Image>& images) {
  std::vector<std::vector<cv::Point2f>> pixels;
  std::vector<std::vector<cv::Point3f>> points;
  for (const Image& image : images) {
    Image copy = image;
    const cv::Mat grey(image.height(), image.width(), CV_8UC1, copy.bytes().data());
    std::vector<cv::Point2f> corners;
    if (!cv::findChessboardCorners(grey, {kBoard.cols, kBoard.rows}, corners)) continue;
    cv::cornerSubPix(grey, corners, {11, 11}, {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 30, 0.001});
    pixels.push_back(corners);
    auto& board = points.emplace_back();
    for (int i = 0; i < kBoard.rows * kBoard.cols; ++i)
      board.emplace_back(static_cast<float>(i % kBoard.cols * kBoard.square_m),
                         static_cast<float>(i / kBoard.cols * kBoard.square_m), 0.0f);
  }
  EXPECT_EQ(pixels.size(), images.size());
  cv::Mat camera, distortion, rotations, translations;
  return cv::calibrateCamera(points, pixels, {images[0].width(), images[0].height()}, camera, distortion, rotations,
                             translations);
}

TEST(ChessboardPhotographs, AreFittedAtLeastAsWellAsByOpenCv) {
  const std::vector<Image> images = Photographs();
  ASSERT_EQ(images.size(), 13u);
  const auto target = MakeChessboardTarget(kBoard);
  std::vector<LensView> views;
  for (const Image& image : images) {
    views.push_back(target->Read(image.view()));
    EXPECT_EQ(views.back().points.size(), 54u);
    EXPECT_GT(views.back().edge_px, 1);
    EXPECT_LT(views.back().edge_px, 6);
  }
  const LensCalibration found = CalibrateLens(views, {640, 480, CameraModel::Kind::kBrownConrady});
  // No view is left out to make it look better.
  EXPECT_EQ(found.record.views, 13);
  EXPECT_EQ(found.residuals.size(), 13u * 54u);
  const double theirs = OpenCvRms(images);
  EXPECT_LE(found.record.rms_px, theirs);
  RecordProperty("rms_px", std::to_string(found.record.rms_px));
  RecordProperty("opencv_rms_px", std::to_string(theirs));
  EXPECT_NEAR(found.camera.fx, 535, 5);
  EXPECT_NEAR(found.camera.fy, 535, 5);
}

TEST(ChessboardPhotographs, GiveAPicture) {
  const auto target = MakeChessboardTarget(kBoard);
  std::vector<LensView> views;
  for (const Image& image : Photographs()) views.push_back(target->Read(image.view()));
  const LensCalibration found = CalibrateLens(views, {640, 480, CameraModel::Kind::kBrownConrady});
  const Image picture = DecodeImage(DrawLensPicture(found));
  EXPECT_GT(picture.width(), 1000);
  // Points are drawn: something blue or red where the map is.
  std::size_t coloured = 0;
  for (std::size_t i = 0; i + 2 < picture.bytes().size(); i += 3)
    coloured += std::abs(picture.bytes()[i] - picture.bytes()[i + 2]) > 60;
  EXPECT_GT(coloured, 13u * 54u * 4u);
}

TEST(ChessboardTarget, SeesNothingWhereThereIsNone) {
  const auto target = MakeChessboardTarget(kBoard);
  EXPECT_TRUE(target->Read(Image(PixelFormat::kMono8, 640, 480).view()).points.empty());
  EXPECT_TRUE(target->Read(Image(PixelFormat::kMono8, 3, 3).view()).points.empty());
}

}  // namespace
}  // namespace chequer
