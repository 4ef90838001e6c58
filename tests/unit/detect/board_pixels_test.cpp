#include "detect/fit/board_pixels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>

namespace chequer {
namespace {

constexpr MarkerSize kBoard{6, 6};
constexpr int kImageWidth = 640, kImageHeight = 480;

CameraModel BentCamera() {
  CameraModel camera;
  camera.width = kImageWidth;
  camera.height = kImageHeight;
  camera.fx = 620;
  camera.fy = 615;
  camera.cx = 322;
  camera.cy = 238;
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.32, 0.11, 0.001, -0.0005, 0};
  return camera;
}

/// A board turned and a little tilted, its centre at that pixel.
BoardGeometry BoardAt(const Lens& lens, double x, double y, double cell_px) {
  const Eigen::Vector2d centre = *lens.ToPlane({x, y});
  Eigen::Matrix3d h;
  h << 0.9 * cell_px, -0.4 * cell_px, centre.x(), 0.4 * cell_px, 0.8 * cell_px, centre.y(), 0.002, -0.001, 1;
  return BoardGeometry(h);
}

/// Collects from an image of noise and looks whether every pixel stands where it belongs; returns how many there are.
/// @param most_px how far off it may stand. @param format of single bytes, or of three alike a pixel.
std::size_t CollectAndCheck(double x, double y, double cell_px, double most_px,
                            PixelFormat format = PixelFormat::kBayerRg8) {
  const std::size_t of_pixel = format == PixelFormat::kBgr8 ? 3 : 1;
  std::vector<std::uint8_t> bytes(of_pixel * kImageWidth * kImageHeight);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::uint8_t>((i / of_pixel * 2654435761u) >> 24);
  const Plane plane{bytes.data(), static_cast<int>(of_pixel) * kImageWidth};
  const ImageView image(format, kImageWidth, kImageHeight, {&plane, 1});
  std::array<float, 256> table;
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = static_cast<float>(i) / 255;
  const Lens lens(BentCamera());
  BoardPixels pixels;
  const BoardGeometry board = BoardAt(lens, x, y, cell_px);
  pixels.Collect(LightReader(image, table), lens, kBoard, board, 0.8);
  const Eigen::Matrix3d board_from_lanes = pixels.BoardFromPlane(board);
  const LaneBlock& lanes = pixels.lanes();
  std::set<std::pair<int, int>> seen;
  double farthest = 0;
  for (int lane = 0; lane < lanes.lanes(); ++lane)
    for (int i = 0; i < lanes.count(lane); ++i) {
      const std::size_t at = lanes.Place(lane, i);
      const Eigen::Vector3d in_lane(lanes.u_data()[at], lanes.v_data()[at], 1);
      const Eigen::Vector2d pixel = lens.ToImage(board.ToPlane((board_from_lanes * in_lane).hnormalized()));
      const int px = static_cast<int>(std::lround(pixel.x())), py = static_cast<int>(std::lround(pixel.y()));
      farthest = std::max(farthest, (pixel - Eigen::Vector2d(px, py)).norm());
      EXPECT_EQ((px & 1) + 2 * (py & 1), lane % 4) << "phase of pixel " << px << ", " << py;
      const std::uint8_t code = bytes[of_pixel * static_cast<std::size_t>(py * kImageWidth + px)];
      EXPECT_EQ(lanes.light_data()[at], code >= 254 ? -253.5f / 255 : table[code])
          << "light of pixel " << px << ", " << py;
      seen.emplace(px, py);
    }
  EXPECT_LT(farthest, most_px) << "px off where the lens has the pixel";
  return seen.size();
}

TEST(BoardPixels, LieWhereTheLensHasThem) {
  // Near the image's corner the lens bends most. What a parabola around each corner leaves grows as the cube of a cell.
  EXPECT_GT(CollectAndCheck(90, 80, 8, 1e-3), 1200u);
  EXPECT_GT(CollectAndCheck(320, 240, 8, 1e-3), 1200u);
  EXPECT_GT(CollectAndCheck(500, 400, 14, 4e-3), 3500u);
}

TEST(BoardPixels, OfColoursAreMarkedWhereTheyAreSaturated) {
  EXPECT_GT(CollectAndCheck(320, 240, 8, 1e-3, PixelFormat::kBgr8), 1200u);
}

TEST(BoardPixels, OfABoardOverTheEdgeAreThoseOfTheImage) {
  const std::size_t whole = CollectAndCheck(300, 200, 10, 2e-3), part = CollectAndCheck(8, 200, 10, 2e-3);
  EXPECT_GT(part, whole / 4);
  EXPECT_LT(part, 3 * whole / 4);
}

class ReusedPixels : public testing::Test {
 protected:
  ReusedPixels() {
    for (std::size_t i = 0; i < bytes_.size(); ++i) bytes_[i] = static_cast<std::uint8_t>((i * 2654435761u) >> 24);
    for (std::size_t i = 0; i < table_.size(); ++i) table_[i] = static_cast<float>(i) / 255;
    pixels_.Collect(reader_, lens_, kBoard, board_, 0.8);
  }

  /// Places and light of all pixels.
  std::vector<float> All() const {
    std::vector<float> all;
    const LaneBlock& lanes = pixels_.lanes();
    for (int lane = 0; lane < lanes.lanes(); ++lane)
      for (int i = 0; i < lanes.count(lane); ++i) {
        const std::size_t at = lanes.Place(lane, i);
        for (const float* of : {lanes.u_data(), lanes.v_data(), lanes.light_data()}) all.push_back(of[at]);
      }
    return all;
  }
  void Change() {
    LaneBlock& lanes = pixels_.lanes();
    for (int lane = 0; lane < lanes.lanes(); ++lane)
      for (int i = 0; i < lanes.count(lane); ++i) lanes.light_data()[lanes.Place(lane, i)] *= 0.5f;
    pixels_.SetMove({0.01, 0.02}, Eigen::Matrix2d::Constant(1e-3));
  }
  bool HoldFor(const BoardGeometry& board, double blur_px = 0.8, int of_lane = BoardPixels::kLaneCapacity) const {
    return pixels_.HoldFor(lens_, board, blur_px, of_lane);
  }

  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(kImageWidth * kImageHeight);
  std::array<float, 256> table_;
  const Plane plane_{bytes_.data(), kImageWidth};
  const ImageView image_{PixelFormat::kBayerRg8, kImageWidth, kImageHeight, {&plane_, 1}};
  const LightReader reader_{image_, table_};
  const Lens lens_{BentCamera()};
  const BoardGeometry board_ = BoardAt(lens_, 320, 240, 9);
  BoardPixels pixels_;
};

TEST_F(ReusedPixels, AreAsTheyWereCollected) {
  const std::vector<float> collected = All();
  const Eigen::Matrix3d board_from_plane = pixels_.BoardFromPlane(board_);
  for (int change = 0; change < 2; ++change) {
    for (int times = 0; times < 2; ++times) {
      pixels_.PrepareChange();
      Change();
    }
    ASSERT_NE(All(), collected);
    ASSERT_NE(pixels_.BoardFromPlane(board_), board_from_plane);
    ASSERT_TRUE(HoldFor(board_));
    EXPECT_EQ(pixels_.Reuse(lens_, board_), 25);
    EXPECT_EQ(All(), collected) << "after change " << change;
    EXPECT_EQ(pixels_.BoardFromPlane(board_), board_from_plane);
  }
}

TEST_F(ReusedPixels, AreNoneForABoardElsewhereOrAnotherChoice) {
  const Eigen::Vector2d centre = lens_.ToImage(board_.ToPlane({0, 0}));
  EXPECT_TRUE(HoldFor(BoardAt(lens_, 320.2, 240, 9)));
  EXPECT_FALSE(HoldFor(BoardAt(lens_, 320.5, 240, 9))) << "off " << centre.transpose() << " by half a pixel";
  EXPECT_FALSE(HoldFor(board_, 1.0)) << "chosen for less blur";
  EXPECT_FALSE(HoldFor(board_, 0.6)) << "chosen for more blur";
  EXPECT_FALSE(HoldFor(board_, 0.8, BoardPixels::kFewOfLane)) << "all pixels, not some";
}

}  // namespace
}  // namespace chequer
