// How far a knocked camera has shifted all boards, and how far one board has moved by itself.
#include "detect/memory/common_shift.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "chequer/image.h"

namespace chequer {
namespace {

const std::array<float, 256> kLightOfTones = ToneCurve::Srgb().LinearTable();
constexpr double kCellPx = 10;

/// Boards of 6 × 6 cells that lie turned, one of them at the image's rim.
std::vector<Eigen::Matrix3d> Places(double cell_px = kCellPx) {
  std::vector<Eigen::Matrix3d> places;
  for (const auto& [x, y, angle] : {std::array{60.3, 70.8, 0.2},
                                    {200.6, 80.1, 0.9},
                                    {330.0, 60.5, 1.4},
                                    {90.2, 210.4, -0.5},
                                    {371.0, 215.0, 0.0}}) {
    Eigen::Matrix3d place = Eigen::Matrix3d::Identity();
    place.topLeftCorner<2, 2>() = cell_px * Eigen::Rotation2Dd(angle).toRotationMatrix();
    place.topRightCorner<2, 1>() << x, y;
    places.push_back(place);
  }
  return places;
}

/// An image of boards that lie `shift` farther on, blurred by a motion along x.
Image Draw(PixelFormat format, const std::vector<Eigen::Matrix3d>& places, const Eigen::Vector2d& shift,
           int motion_px) {
  constexpr int kWidth = 400, kHeight = 280;
  std::vector<double> sharp(kWidth * kHeight, 110);
  for (const Eigen::Matrix3d& place : places) {
    const Eigen::Matrix3d board_from_image = place.inverse();
    const int left = static_cast<int>(place(0, 2) + shift.x()), top = static_cast<int>(place(1, 2) + shift.y());
    constexpr int kReach = static_cast<int>(4.3 * kCellPx);
    for (int y = std::max(top - kReach, 0); y < std::min(top + kReach, kHeight); ++y)
      for (int x = std::max(left - kReach, 0); x < std::min(left + kReach, kWidth); ++x) {
        const Eigen::Vector3d cell = board_from_image * Eigen::Vector3d(x - shift.x(), y - shift.y(), 1);
        if (std::max(std::abs(cell.x()), std::abs(cell.y())) > 3) continue;
        const int row = static_cast<int>(cell.y() + 3), col = static_cast<int>(cell.x() + 3);
        sharp[static_cast<std::size_t>(y * kWidth + x)] = IsDark(row, col) ? 40 : 220;
      }
  }
  Image image(format, kWidth, kHeight);
  const int channels = format == PixelFormat::kBgr8 ? 3 : 1;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      double light = 0;
      for (int part = -motion_px / 2; part <= motion_px / 2; ++part)
        light += sharp[static_cast<std::size_t>(y * kWidth + std::clamp(x + part, 0, kWidth - 1))];
      const std::size_t at = static_cast<std::size_t>(channels * (y * kWidth + x));
      std::fill_n(image.bytes().begin() + static_cast<std::ptrdiff_t>(at), channels,
                  static_cast<std::uint8_t>(light / (2 * (motion_px / 2) + 1)));
    }
  return image;
}

AnchoredBoard BoardAt(const Eigen::Matrix3d& place) {
  AnchoredBoard board;
  board.size = {6, 6};
  board.plane_from_board = place;
  return board;
}

Eigen::Vector2d ShiftOf(const Image& image, const std::vector<Eigen::Matrix3d>& expected, std::size_t asked) {
  std::vector<AnchoredBoard> boards;
  for (const Eigen::Matrix3d& place : expected) boards.push_back(BoardAt(place));
  std::vector<float> row(3, 7.0f);  // left by others
  return FindCommonShift(boards, asked, LightReader(image.view(), kLightOfTones), Lens(), row);
}

Eigen::Vector2d OwnShiftOf(const Image& image, const Eigen::Matrix3d& expected) {
  std::vector<float> row(3, 7.0f);  // left by others
  return FindOwnShift(BoardAt(expected), LightReader(image.view(), kLightOfTones), Lens(), row);
}

TEST(CommonShift, IsFoundToAPixelWithMotionBlurAndAtTheRim) {
  const std::vector<Eigen::Matrix3d> places = Places();
  for (const PixelFormat format : {PixelFormat::kMono8, PixelFormat::kBgr8, PixelFormat::kBayerRg8})
    for (const Eigen::Vector2d& shift : {Eigen::Vector2d(7, -5), {-14, 3}, {4.4, 11.7}, {16, -16}, {2.5, -1}})
      for (const int motion_px : {0, 6}) {
        const Image image = Draw(format, places, shift, motion_px);
        for (const std::size_t asked : {kFewestAskedForShift, kMostAskedForShift}) {
          const Eigen::Vector2d found = ShiftOf(image, places, asked);
          EXPECT_LT((found - shift).norm(), 1.2)
              << PixelFormatName(format) << ", shift " << shift.transpose() << ", motion " << motion_px << " px, asked "
              << asked << ", found " << found.transpose();
        }
      }
}

TEST(CommonShift, IsNoneWhereBoardsLieAsExpectedOrNowhere) {
  const std::vector<Eigen::Matrix3d> places = Places();
  EXPECT_TRUE(ShiftOf(Draw(PixelFormat::kMono8, places, {0.2, -0.1}, 0), places, kMostAskedForShift).isZero());
  EXPECT_TRUE(ShiftOf(Draw(PixelFormat::kMono8, {}, {0, 0}, 0), places, kMostAskedForShift).isZero());
}

TEST(CommonShift, AsksNoPixelBeyondTheImage) {
  // The address sanitizer would tell.
  std::vector<Eigen::Matrix3d> far;
  for (const auto& [x, y] : {std::array{-70.0, 20.0}, {0.0, 0.0}, {399.0, 279.0}, {1e12, -1e12}, {200.0, 400.0}}) {
    Eigen::Matrix3d place = Places()[0];
    place.topRightCorner<2, 1>() << x, y;
    far.push_back(place);
  }
  for (const PixelFormat format : {PixelFormat::kMono8, PixelFormat::kBgr8, PixelFormat::kBayerRg8})
    EXPECT_TRUE(ShiftOf(Draw(format, {}, {0, 0}, 0), far, kMostAskedForShift).allFinite());
}

/// Shifts of boards of such cells are found to `most_px`, sharp and blurred by a motion, in all kinds of images.
void ExpectOwnShifts(double cell_px, const std::vector<Eigen::Vector2d>& shifts, int blurred_px, double most_px) {
  const std::vector<Eigen::Matrix3d> places = Places(cell_px);
  for (const PixelFormat format : {PixelFormat::kMono8, PixelFormat::kBgr8, PixelFormat::kBayerRg8})
    for (const Eigen::Vector2d& shift : shifts)
      for (const int motion_px : {0, blurred_px}) {
        const Image image = Draw(format, places, shift, motion_px);
        for (const Eigen::Matrix3d& place : places) {
          const Eigen::Vector2d found = OwnShiftOf(image, place);
          EXPECT_LT((found - shift).norm(), most_px)
              << PixelFormatName(format) << ", shift " << shift.transpose() << ", motion " << motion_px << " px, at "
              << place.col(2).transpose() << ", found " << found.transpose();
        }
      }
}

TEST(OwnShift, IsFoundToTwoFifthsOfAPixelOfSmallCells) {
  ExpectOwnShifts(4, {{1.6, -0.8}, {-2.3, 1.4}, {0.3, 2.7}}, 2, 0.4);
}

TEST(OwnShift, IsFoundFartherOffOfLargeCells) {
  ExpectOwnShifts(kCellPx, {{1.6, -0.8}, {-5.3, 3.4}, {0.3, 5.7}}, 4, 2);
}

TEST(OwnShift, IsNoneWhereTheBoardLiesAsExpectedOrTooFarOff) {
  const std::vector<Eigen::Matrix3d> places = Places(4);
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0.2, -0.1), {40, 40}})
    for (const Eigen::Matrix3d& place : places)
      EXPECT_TRUE(OwnShiftOf(Draw(PixelFormat::kMono8, places, shift, 0), place).isZero()) << shift.transpose();
}

}  // namespace
}  // namespace chequer
