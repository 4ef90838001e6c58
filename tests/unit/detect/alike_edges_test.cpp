// Which edges and corners of a board lie alike between the image's pixels.
#include "detect/fit/alike_edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace chequer {
namespace {

constexpr MarkerSize kOfSix{6, 6};
constexpr int kPlaneWidth = 320, kPlaneHeight = 240;

/// A board in an image, its corners where its geometry has them.
struct PlacedBoard {
  /// @param turn against the image's rows, rad.
  PlacedBoard(double cell_px, double turn, const Eigen::Vector2d& centre = {150.25, 110.5}) {
    const std::vector<std::uint8_t> bytes(kPlaneWidth * kPlaneHeight, 100);
    const Plane plane{bytes.data(), kPlaneWidth};
    const ImageView image(PixelFormat::kMono8, kPlaneWidth, kPlaneHeight, {&plane, 1});
    const std::array<float, 256> table{};
    const double along = cell_px * std::cos(turn), across = cell_px * std::sin(turn);
    Eigen::Matrix3d h;
    h << along, -across, centre.x(), across, along, centre.y(), 0, 0, 1;
    pixels.Collect(LightReader(image, table), Lens(), kOfSix, BoardGeometry(h), 0.8);
  }
  UsedCorners corners() const { return {pixels, visibility}; }

  BoardPixels pixels;
  Visibility visibility{kOfSix};
};

TEST(AlikePhases, AreThoseOfCellsOfWholePixels) {
  const auto alike = FindAlikePhases(PlacedBoard(8, 0).corners(), 1);
  ASSERT_TRUE(alike);
  EXPECT_NEAR(alike->alike, 1, 1e-9);
  // An odd number of corners: one lies in the middle.
  EXPECT_NEAR(alike->middle_px.x(), 0.25, 1e-9);
  EXPECT_NEAR(std::abs(alike->middle_px.y()), 0.5, 1e-9);
  EXPECT_FALSE(FindAlikePhases(PlacedBoard(8.5, 0).corners(), 1));
  EXPECT_FALSE(FindAlikePhases(PlacedBoard(8, 0.3).corners(), 1));
}

TEST(AlikePhases, FallAsTheBoardTurns) {
  const auto turned = FindAlikePhases(PlacedBoard(8, 0.01).corners(), 1);
  ASSERT_TRUE(turned);
  EXPECT_LT(turned->alike, 0.95);
  EXPECT_GT(turned->alike, 0.5);
}

TEST(AlikePhases, HaveThePeriodThatIsAskedFor) {
  // Of cells of seven pixels, every second corner lies elsewhere in squares of two.
  EXPECT_TRUE(FindAlikePhases(PlacedBoard(7, 0).corners(), 1));
  EXPECT_FALSE(FindAlikePhases(PlacedBoard(7, 0).corners(), 2));
  EXPECT_TRUE(FindAlikePhases(PlacedBoard(8, 0).corners(), 2));
}

TEST(EdgeGroups, OfEdgesThatFollowThePixels) {
  EXPECT_TRUE(GroupEdgesAlongPixels(PlacedBoard(8, 0.02).corners()));
  EXPECT_FALSE(GroupEdgesAlongPixels(PlacedBoard(8, 0.2).corners())) << "leave their row by 1.6 px along a cell";
  // Cells of eight pixels have all edges at one place of JPEG's blocks.
  PlacedBoard placed(8, 0);
  placed.visibility.Set(7, Hidden::kLeftOut);
  const auto groups = GroupEdgesAlongPixels(placed.corners());
  ASSERT_TRUE(groups);
  for (int corner = 0; corner < placed.pixels.corners(); ++corner) {
    const std::array<int, 2> expected = corner == 7 ? std::array{-1, -1} : std::array{150 % 8, 110 % 8};
    EXPECT_EQ((*groups)[static_cast<std::size_t>(corner)], expected) << "corner " << corner;
  }
}

// Where one error is shared by all, the covariance is that of all corners moving together by a corner's deviation, over
// the root of how many there are.
TEST(EdgeGroups, ShareOneError) {
  constexpr double kInformation = 400;  // of a corner's coordinate, 1 / cells²
  const int corners = CornerCount(kOfSix);
  std::vector<ShiftedCorner> shifted;
  std::vector<CornerDerivative> derivatives;
  BoardGeometry::Information information = BoardGeometry::Information::Zero();
  for (int corner = 0; corner < corners; ++corner) {
    const Eigen::Vector2d board = CornerOnBoard(kOfSix, corner / 5, corner % 5);
    shifted.push_back({corner, board, Eigen::Vector2d::Zero(), kInformation * Eigen::Matrix2d::Identity()});
    derivatives.push_back({BoardGeometry::MoveByParameters(board, 0), BoardGeometry::MoveByParameters(board, 1)});
    const CornerDerivative& by = derivatives.back();
    information += kInformation * (by.x * by.x.transpose() + by.y * by.y.transpose());
  }
  const BoardGeometry::Information covariance = CovarianceOfGroups(information, 1, shifted, derivatives, EdgeGroups{});
  const double variance = 1 / (kInformation * corners);
  BoardGeometry::Information expected = BoardGeometry::Information::Zero();
  expected(0, 0) = expected(3, 3) = variance;
  EXPECT_LT((covariance - expected).norm(), 1e-9 * variance);
  const BoardGeometry::Information by_line =
      CovarianceOfGroups(information, 1, shifted, derivatives, GroupEdgesByLine(kOfSix));
  EXPECT_GT(by_line.trace(), covariance.trace()) << "lines move apart from each other, too";
}

}  // namespace
}  // namespace chequer
