// Real photographs of a chessboard (tests/data/chessboard), and what OpenCV makes of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
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

cv::Mat Grey(Image& image) { return {image.height(), image.width(), CV_8UC1, image.bytes().data()}; }
const cv::Size kCorners{kBoard.cols, kBoard.rows};

/// OpenCV's ways of finding the corners; empty where it sees none.
std::vector<cv::Point2f> RefinedByGradients(const cv::Mat& grey) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(grey, kCorners, corners)) return {};
  cv::cornerSubPix(grey, corners, {11, 11}, {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 30, 0.001});
  return corners;
}

std::vector<cv::Point2f> BySectors(const cv::Mat& grey) {
  std::vector<cv::Point2f> corners;
  return cv::findChessboardCornersSB(grey, kCorners, corners, cv::CALIB_CB_ACCURACY) ? corners
                                                                                     : std::vector<cv::Point2f>();
}

/// RMS of OpenCV's solver about corners of views that show all of them.
double OpenCvRms(const std::vector<std::vector<cv::Point2f>>& views, cv::Size size) {
  std::vector<cv::Point3f> board;
  for (int i = 0; i < kBoard.rows * kBoard.cols; ++i)
    board.emplace_back(static_cast<float>(i % kBoard.cols * kBoard.square_m),
                       static_cast<float>(i / kBoard.cols * kBoard.square_m), 0.0f);
  cv::Mat camera, distortion, rotations, translations;
  return cv::calibrateCamera(std::vector(views.size(), board), views, size, camera, distortion, rotations,
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
  std::vector<std::vector<cv::Point2f>> refined;
  for (Image image : images) refined.push_back(RefinedByGradients(Grey(image)));
  const double theirs = OpenCvRms(refined, {640, 480});
  EXPECT_LE(found.record.rms_px, 0.5 * theirs);
  RecordProperty("rms_px", std::to_string(found.record.rms_px));
  RecordProperty("opencv_rms_px", std::to_string(theirs));
  EXPECT_NEAR(found.camera.fx, 535, 5);
  EXPECT_NEAR(found.camera.fy, 535, 5);
}

TEST(ChessboardPhotographs, HaveCornersAtLeastAsExactAsSectorBasedOnes) {
  const auto target = MakeChessboardTarget(kBoard);
  std::vector<std::vector<cv::Point2f>> ours, theirs;
  for (Image image : Photographs()) {
    const std::vector<cv::Point2f> corners = BySectors(Grey(image));
    if (corners.empty()) continue;
    theirs.push_back(corners);
    ours.emplace_back();
    for (const SeenPoint& point : target->Read(image.view()).points)
      ours.back().emplace_back(static_cast<float>(point.pixel.x()), static_cast<float>(point.pixel.y()));
    // OpenCV may begin at the other end.
    if (cv::norm(ours.back()[0] - corners[0]) > 5) std::reverse(theirs.back().begin(), theirs.back().end());
    ASSERT_LT(cv::norm(ours.back()[0] - theirs.back()[0]), 5);
  }
  ASSERT_GE(ours.size(), 10u);
  const double our_rms = OpenCvRms(ours, {640, 480}), their_rms = OpenCvRms(theirs, {640, 480});
  EXPECT_LE(our_rms, 0.75 * their_rms);
  RecordProperty("rms_px", std::to_string(our_rms));
  RecordProperty("sectors_rms_px", std::to_string(their_rms));
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
