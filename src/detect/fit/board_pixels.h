#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "detect/common/board_geometry.h"
#include "detect/common/light.h"
#include "detect/fit/bent_paper.h"
#include "detect/fit/corner_pixels.h"
#include "detect/fit/photometric_kernel.h"

namespace chequer {

/// Where the pixels that are a corner's end along one axis of the board, in cells from the corner: the root of their
/// weight falls by `slope` a cell towards each of the two ends, where it is zero, from 1 at most.
struct WindowEnds {
  /// Of ends that no pixel comes near.
  static constexpr double kNever = 4;
  double slope = 0, low = -kNever, high = kNever;

  bool any() const { return slope > 0; }
  double middle() const { return (low + high) / 2; }
  /// What it would be in the middle, if it were not 1 at most.
  double peak() const { return any() ? (high - low) / 2 * slope : 1; }
};

/// Where a corner lies, and how the image lies around it.
struct CornerPlace {
  Eigen::Vector2d board = Eigen::Vector2d::Zero();           ///< where it is printed, cells
  Eigen::Vector2d plane = Eigen::Vector2d::Zero();           ///< the same point on the plane
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();           ///< and in the image
  Eigen::Matrix2d plane_by_pixel = Eigen::Matrix2d::Zero();  ///< derivative there
  Eigen::Matrix2d pixel_by_board = Eigen::Matrix2d::Zero(), board_by_pixel = Eigen::Matrix2d::Zero();
  /// Centre of the region whose pixels are the corner's, cells from it: off zero at the board's rim.
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  std::array<WindowEnds, 2> ends;  ///< by axis: of corners at the board's rim
  bool inside = false;             ///< the image
  int pixels = 0;                  ///< that are the corner's

  /// Side of a square as large as a cell.
  double CellPx() const { return std::sqrt(std::abs(pixel_by_board.determinant())); }
};

/// Four corners whose lanes stand side by side: for vectors, in single precision.
struct CornerFour {
  using Values = Eigen::Array4f;
  std::array<int, 4> corner{-1, -1, -1, -1};  ///< −1 where there is none, or none inside the image
  // As CornerPlace has them.
  Values board_x = Values::Zero(), board_y = Values::Zero();
  Values off_x = Values::Zero(), off_y = Values::Zero();  ///< image, from the board's middle
  /// Derivative of the board coordinates x and y by the pixel's.
  Values x_by_x = Values::Ones(), x_by_y = Values::Zero(), y_by_x = Values::Zero(), y_by_y = Values::Ones();
};

/// The pixels of a board, dealt to the corners they are nearest to, in the lanes of the photometric kernel: lane
/// 4 · rank + phase, with phase = parity of x + 2 · parity of y. Saturated ones are marked. Keeps its memory.
class BoardPixels {
 public:
  /// The most pixels of a lane, and those of large cells that do where a pixel costs much (measured: with 40, boards
  /// with ways of 6 px lie .089 mm off, with 56 .077, with 64 less than .07).
  static constexpr int kLaneCapacity = 400, kFewOfLane = 64;

  /// Returns how many corners have pixels. @param blur_px roughly, of the image. @param of_lane about so many pixels of
  /// a lane: more are thinned out, inside cells first. @param paper if it is not flat: pixels are those that show the
  /// bent board, their coordinates those at which flat paper, in its middle's plane, would show the same.
  int Collect(const LightReader& reader, const Lens& lens, MarkerSize size, const BoardGeometry& geometry,
              double blur_px, int of_lane = kLaneCapacity, const std::optional<BentPaper>& paper = std::nullopt);
  /// How softly the pixels of the rim fade out, by the size of the cells: 0 … 1.
  static double RimSoftness(double cell_px);
  /// Where the point of the board is seen that their coordinates have at `board`, and its derivative.
  BoardGeometry::Local SeenAt(const BoardGeometry& geometry, const Eigen::Vector2d& board) const;
  /// Whether the pixels, which are this board's, are as good as collected for that geometry.
  bool HoldFor(const Lens& lens, const BoardGeometry& geometry, double blur_px, int of_lane) const;
  /// Undoes what was done to them since they were collected, and places the corners. Returns as Collect().
  int Reuse(const Lens& lens, const BoardGeometry& geometry);
  /// To be called before their light is changed, so that Reuse() can undo that.
  void PrepareChange();
  /// What they were collected for.
  const BoardGeometry& collected_for() const { return collected_.geometry; }
  double collected_for_blur_px() const { return collected_.blur_px; }
  /// Where the corners lie after the geometry has changed; the pixels stay with their corners.
  void PlaceCorners(const Lens& lens, const BoardGeometry& geometry);

  /// Where a corner is printed, cells.
  Eigen::Vector2d Printed(int corner) const {
    return CornerOnBoard(size_, corner / (size_.cols - 1), corner % (size_.cols - 1));
  }
  MarkerSize size() const { return size_; }
  int corners() const { return corners_; }
  const CornerPlace& place(int corner) const { return places_[static_cast<std::size_t>(corner)]; }
  /// Of the corner in the board's middle.
  const CornerPlace& middle() const { return place(corners_ / 2); }
  bool inside(int corner) const { return place(corner).inside; }
  int pixels(int corner) const { return place(corner).pixels; }
  /// Of all corners.
  int pixels() const { return collected_.pixels; }
  /// The first of the corner's four lanes.
  int Lane(int corner) const { return 4 * rank_[static_cast<std::size_t>(corner)]; }
  static constexpr int kMostFours = (kMaxCorners + 3) / 4;
  /// The corners in the order of their lanes.
  std::span<const CornerFour> fours() const {
    return std::span(fours_).first(static_cast<std::size_t>((corners_ + 3) / 4));
  }
  /// How many lie in the image.
  int inside() const { return collected_.inside; }
  /// Corners of every other row and column, and of the last ones: they have the first lanes. @{
  int spread_corners() const { return spread_; }
  bool is_spread(int corner) const { return rank_[static_cast<std::size_t>(corner)] < spread_; }
  /// @}
  /// Towards −x, −y.
  int Cell(int corner) const { return CellsAround(size_, corner)[0]; }
  /// How far the pixels' plane coordinates are moved from where they were collected: all alike, and by so much more per
  /// unit from the board's middle.
  void SetMove(const Eigen::Vector2d& by, const Eigen::Matrix2d& by_place) {
    origin_ = collected_.origin + by;
    by_lane_ = Eigen::Matrix2d::Identity() + by_place;
  }
  /// The homography from them to the board, its last entry 1.
  Eigen::Matrix3d BoardFromPlane(const BoardGeometry& geometry) const;
  LaneBlock& lanes() { return lanes_; }
  const LaneBlock& lanes() const { return lanes_; }

 private:
  void RankCorners();
  void Place(const Lens& lens, const BoardGeometry& geometry);
  /// act(corner, place, four, set) for each corner in the image; set(values, value) sets the corner's of the four.
  template <class Act>
  void ForFours(Act&& act);
  /// From the places: all that the fours have, or what changes with the geometry.
  void FillFours();
  void MoveFours();
  /// Which corners lie in the image. Returns how many.
  int FindInside(const LightReader& reader);
  void TakeOutBend();
  void CollectCorner(const LightReader& reader, const LightReader::Rows& rows, int corner, const LocalPlane& plane);

  MarkerSize size_;
  int corners_ = 0;
  struct Collected {
    BoardGeometry geometry;
    double blur_px = 0;
    int of_lane = 0, inside = 0, pixels = 0;
    Eigen::Vector2d origin = Eigen::Vector2d::Zero();
    bool originals_kept = false;
    std::optional<BentPaper> paper;  ///< whose bend was taken out
  } collected_;
  std::array<CornerPlace, kMaxCorners> places_;
  std::array<CornerFour, kMostFours> fours_;
  std::array<int, kMaxCorners> rank_{};
  int spread_ = 0;  ///< the first so many ranks are those of corners spread over the board
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();       ///< of the lanes' coordinates, on the plane
  Eigen::Matrix2d by_lane_ = Eigen::Matrix2d::Identity();  ///< the plane's coordinates by the lanes'
  LaneBlock lanes_;
};

}  // namespace chequer
