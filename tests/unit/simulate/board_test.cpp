#include "simulate/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <vector>

#include "simulate/render.h"

#ifdef CHEQUER_HAVE_APRILTAG
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <memory>
#endif
#ifdef CHEQUER_HAVE_ARUCO
#include <opencv2/aruco.hpp>
#endif

namespace chequer {
namespace {

TEST(MakeBoard, HasTheCodesCells) {
  const MarkerCode code(MarkerSize{8, 8}, Variant::kGolay);
  const Board board = MakeBoard(code, 77);
  EXPECT_EQ(board.cells, CellColours({8, 8}, code.Encode(77)));
  EXPECT_EQ(board.variant, "golay");
  EXPECT_DOUBLE_EQ(board.CellSize(0.4), 0.05);
}

TEST(Board, SideIsTheLongerOne) {
  const Board board = MakeBoard(MarkerCode(MarkerSize{4, 6}, Variant::kUnconstrained), 1);
  EXPECT_DOUBLE_EQ(board.CellSize(0.3), 0.05);
}

TEST(AprilTag, IsABlackRingOnAWhiteRim) {
  if (!HasAprilTag()) {
    EXPECT_THROW(AprilTag36h11(0), std::runtime_error);
    GTEST_SKIP() << "built without libapriltag";
  }
  const Board board = AprilTag36h11(3);
  ASSERT_EQ(board.rows, 10);
  ASSERT_EQ(board.cells.size(), 100u);
  EXPECT_EQ(board.cells.substr(0, 10), "WWWWWWWWWW");
  EXPECT_EQ(board.cells.substr(10, 10), "WKKKKKKKKW");
  EXPECT_DOUBLE_EQ(board.CellSize(0.16), 0.02);
  EXPECT_NE(board.cells, AprilTag36h11(4).cells);
  EXPECT_THROW(AprilTag36h11(587), std::runtime_error);
}

TEST(Aruco, IsABlackRingOnAWhiteRim) {
  if (!HasAruco()) {
    EXPECT_THROW(Aruco4x4(0), std::runtime_error);
    GTEST_SKIP() << "built without OpenCV's aruco";
  }
  const Board board = Aruco4x4(3);
  ASSERT_EQ(board.rows, 8);
  EXPECT_EQ(board.cells.substr(8, 8), "WKKKKKKW");
  EXPECT_THROW(Aruco4x4(1000), std::runtime_error);
}

/// A grey frame with that board in a tilted pose, and where the corners of its black square are.
struct PeerFrame {
  Image image;
  std::array<Eigen::Vector2d, 4> corners_px;  ///< clockwise from the top left
};

PeerFrame RenderPeer(const Board& board) {
  RenderOptions options;
  options.format = PixelFormat::kMono8;
  Scene scene;
  scene.background.colour.setConstant(0.8f);
  SceneMarker marker;
  marker.board = board;
  marker.side_m = 0.2;
  marker.camera_from_marker = FacingPose({0.03, 0.02, 0.8}, 0.6, 0.3);
  scene.markers = {marker};
  const double far = board.cols - 1;
  const double places[4][2] = {{1, 1}, {far, 1}, {far, far}, {1, far}};
  PeerFrame frame{Render(scene, options, 1), {}};
  for (std::size_t i = 0; i < 4; ++i)
    frame.corners_px[i] =
        options.camera.Project(marker.camera_from_marker * marker.PointAt(places[i][0], places[i][1]));
  return frame;
}

#ifdef CHEQUER_HAVE_ARUCO

TEST(Aruco, IsReadByItsOwnDetector) {
  const PeerFrame frame = RenderPeer(Aruco4x4(123));
  const cv::Mat mat(frame.image.height(), frame.image.width(), CV_8U,
                    const_cast<std::uint8_t*>(frame.image.bytes().data()));
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(mat, cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_1000), corners, ids);
  ASSERT_EQ(ids, std::vector<int>{123});
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d seen = Eigen::Vector2f(corners[0][i].x, corners[0][i].y).cast<double>();
    EXPECT_LT((seen - frame.corners_px[i]).norm(), 2) << "corner " << i;
  }
}

#endif

#ifdef CHEQUER_HAVE_APRILTAG

TEST(AprilTag, IsReadByItsOwnDetector) {
  const PeerFrame frame = RenderPeer(AprilTag36h11(42));
  const std::unique_ptr<apriltag_family_t, decltype(&tag36h11_destroy)> family(tag36h11_create(), &tag36h11_destroy);
  const std::unique_ptr<apriltag_detector_t, decltype(&apriltag_detector_destroy)> detector(apriltag_detector_create(),
                                                                                            &apriltag_detector_destroy);
  apriltag_detector_add_family(detector.get(), family.get());
  image_u8_t image{.width = frame.image.width(),
                   .height = frame.image.height(),
                   .stride = frame.image.width(),
                   .buf = const_cast<std::uint8_t*>(frame.image.bytes().data())};
  const std::unique_ptr<zarray_t, decltype(&apriltag_detections_destroy)> found(
      apriltag_detector_detect(detector.get(), &image), &apriltag_detections_destroy);
  ASSERT_EQ(zarray_size(found.get()), 1);
  apriltag_detection_t* detection = nullptr;
  zarray_get(found.get(), 0, &detection);
  EXPECT_EQ(detection->id, 42);
  // Its corners begin at the bottom left and run on to the bottom right.
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((Eigen::Vector2d(detection->p[i][0], detection->p[i][1]) - frame.corners_px[3 - i]).norm(), 2)
        << "corner " << i;
}

#endif

}  // namespace
}  // namespace chequer
