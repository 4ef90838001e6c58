#include "detect/grids/corner_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace chequer {
namespace {

constexpr int kSearchWidth = 1280, kSearchHeight = 720;

/// The corners of a chessboard over an area, cells of `cell_px`, somewhat turned.
std::vector<Corner> Chessboard(double cell_px, int width, int height) {
  const Eigen::Vector2d right(std::cos(0.2), std::sin(0.2)), down(-right.y(), right.x());
  const int reach = static_cast<int>(2 * width / cell_px);
  std::vector<Corner> corners;
  for (int row = -reach; row < reach; ++row)
    for (int col = -reach; col < reach; ++col) {
      const Eigen::Vector2d at = cell_px * (col * right + row * down);
      if (!(at.x() >= 0 && at.y() >= 0 && at.x() < width && at.y() < height)) continue;
      const bool odd = (row + col) & 1;
      Corner corner;
      corner.position = at.cast<float>();
      // Neighbours swap light and dark: the edge between them leaves one as a rising ray, the other as a falling one.
      corner.rays = {(odd ? down : right).cast<float>(), (odd ? -right : down).eval().cast<float>(),
                     (odd ? -down : -right).eval().cast<float>(), (odd ? right : -down).eval().cast<float>()};
      corner.contrast = 100;
      corners.push_back(corner);
    }
  return corners;
}

struct Found {
  int inside = 0;     ///< corners that are not at the rim
  int linked = 0;     ///< of them, those with a neighbour a cell away along every ray
  double groups = 0;  ///< looked at, a corner
};

Found Search(std::vector<Corner> corners, double cell_px) {
  CornerSearch search;
  search.Build(kSearchWidth, kSearchHeight, corners);
  std::vector<NearestCorners> nearest(corners.size());
  search.ForEach([&](int i) -> NearestCorners& { return nearest[static_cast<std::size_t>(i)]; });
  Found found;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2f& at = corners[i].position;
    const double rim = std::min({at.x(), at.y(), kSearchWidth - 1 - at.x(), kSearchHeight - 1 - at.y()});
    if (rim < 2 * cell_px) continue;
    ++found.inside;
    bool all = true;
    for (std::size_t ray = 0; ray < 4; ++ray) {
      const int other = nearest[i].corner[ray];
      all &= other >= 0 && (corners[static_cast<std::size_t>(other)].position - at -
                            static_cast<float>(cell_px) * corners[i].rays[ray])
                                   .norm() < 0.01 * cell_px;
    }
    found.linked += all;
  }
  found.groups = static_cast<double>(search.groups_looked_at()) / static_cast<double>(corners.size());
  return found;
}

TEST(CornerSearch, FindsTheNeighboursOnAChessboardOfAnySize) {
  for (const double cell_px : {4.0, 6.0, 10.0, 25.0, 60.0, 90.0}) {
    const Found found = Search(Chessboard(cell_px, kSearchWidth, kSearchHeight), cell_px);
    EXPECT_EQ(found.linked, found.inside) << "cells of " << cell_px << " px";
    EXPECT_GT(found.inside, 20) << cell_px;
  }
}

TEST(CornerSearch, LooksAtFewOthersHoweverCloseTheyStand) {
  // In buckets of 32 px, each of 58,000 corners would be held against 75 groups.
  for (const double cell_px : {4.0, 6.0, 10.0})
    EXPECT_LT(Search(Chessboard(cell_px, kSearchWidth, kSearchHeight), cell_px).groups, 20) << "cells of " << cell_px << " px";
}

TEST(CornerSearch, FindsWideCellsBesideADenseTexture) {
  // Neighbours of the wide ones lie many of the narrow buckets away.
  std::vector<Corner> corners = Chessboard(4, kSearchWidth / 2, kSearchHeight);
  for (Corner& corner : Chessboard(80, kSearchWidth, kSearchHeight))
    if (corner.position.x() > kSearchWidth / 2 + 60) corners.push_back(corner);
  CornerSearch search;
  search.Build(kSearchWidth, kSearchHeight, corners);
  std::vector<NearestCorners> nearest(corners.size());
  search.ForEach([&](int i) -> NearestCorners& { return nearest[static_cast<std::size_t>(i)]; });
  int wide = 0, linked = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2f& at = corners[i].position;
    if (at.x() < kSearchWidth / 2 + 240 || at.x() > kSearchWidth - 100 || at.y() < 100 || at.y() > kSearchHeight - 100) continue;
    ++wide;
    for (const int other : nearest[i].corner) linked += other >= 0;
  }
  EXPECT_GT(wide, 10);
  EXPECT_EQ(linked, 4 * wide);
}

}  // namespace
}  // namespace chequer
