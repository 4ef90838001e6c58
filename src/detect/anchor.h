#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "chequer/detector.h"
#include "chequer/marker.h"
#include "detect/board_geometry.h"
#include "detect/corners.h"
#include "detect/grids.h"
#include "detect/homography.h"
#include "detect/light.h"

namespace chequer {

/// A board whose place and turn the border has told.
struct AnchoredBoard {
  MarkerSize size;
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  /// Corners that were found: board coordinates (cells) and plane coordinates.
  std::vector<PointPair> pairs;
  /// Light (R, G, B) and saturation of each cell, row by row, as first seen.
  std::vector<Eigen::Vector3f> light;
  std::vector<std::uint8_t> saturated;
  int border_seen = 0;     ///< border cells that could be judged
  int border_matches = 0;  ///< of them, those of the expected saturation
  float scale = 1;         ///< image pixels per pixel of the coarsest level its corners came from (median)
};

/// The border's saturation at one size, precomputed.
struct BorderPattern {
  explicit BorderPattern(MarkerSize marker_size);
  MarkerSize size;
  std::vector<Cell> cells;
  std::vector<std::uint8_t> saturated;
};

/// Finds the boards in grids: tries every placement and turn of every size that the light and dark cells allow and
/// takes the one whose border shows the saturations it should, by the group means of the publication (eq. 4). Keeps its
/// memory.
class BoardFinder {
 public:
  BoardFinder(std::vector<BorderPattern> patterns, ColorSpace space);

  /// Appends the boards of a grid to `boards`. Returns whether one was found.
  bool Find(const Grid& grid, std::span<const LatticeCorner> lattice, const std::vector<Corner>& corners,
            const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards);

 private:
  /// Where a board's first inner corner lies in the lattice, and how it is turned.
  struct Placement {
    int pattern = 0;
    int x = 0, y = 0;  ///< least lattice coordinates of its inner corners
    int turn = 0;      ///< quarter turns of the board against the lattice
    double score = 0;
    int border_seen = 0, border_matches = 0;
  };
  struct CellSample {
    Eigen::Vector3f light = Eigen::Vector3f::Zero();
    bool inside = false;  ///< the image
    bool visible = false;
  };

  bool MapLattice(const Grid& grid, std::span<const LatticeCorner> lattice, const std::vector<Corner>& corners,
                  const Lens& lens);
  void TryFootprint(int pattern, int x, int y, bool turned, const LightReader& reader, const Lens& lens);
  bool FitFootprint(int x, int y, int cols, int rows);
  bool FitPairs(int cols, int rows);
  void SampleCells(int x, int y, int cols, int rows, const LightReader& reader, const Lens& lens);
  void MarkVisible(int cols, int rows);
  bool JudgeBorder(Placement& placement, AnchoredBoard* board) const;
  void TakeBest(const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards);
  AnchoredBoard Build(const Placement& placement, const LightReader& reader, const Lens& lens);

  /// Index of the found corner at a lattice point, or −1.
  int At(int x, int y) const {
    x -= min_x_;
    y -= min_y_;
    return x < 0 || y < 0 || x >= width_ || y >= height_ ? -1 : map_[static_cast<std::size_t>(y * width_ + x)];
  }

  std::vector<BorderPattern> patterns_;
  ColorSpace space_;
  int min_x_ = 0, min_y_ = 0, width_ = 0, height_ = 0;
  std::vector<int> map_;                    ///< into positions_
  std::vector<Eigen::Vector2d> positions_;  ///< on the plane
  std::vector<float> scales_;
  std::vector<Placement> placements_;
  std::vector<CellSample> samples_;  ///< of the footprint, row by row in lattice orientation
  std::vector<float> lead_;          ///< of each, how much lighter it is than its neighbours
  std::vector<PointPair> pairs_;
  /// Footprints that hold all corners of a grid share their homography, over the lattice, and their cells.
  bool shared_ = false, shared_fits_ = false;
  Eigen::Matrix3d plane_from_shared_ = Eigen::Matrix3d::Identity();
  std::vector<PointPair> shared_pairs_;
  std::vector<CellSample> cache_;
  std::vector<std::uint8_t> cached_;
  int cache_x_ = 0, cache_y_ = 0, cache_cols_ = 0, cache_rows_ = 0;
  Eigen::Matrix3d plane_from_lattice_ = Eigen::Matrix3d::Identity();
};

}  // namespace chequer
