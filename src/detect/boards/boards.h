#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "chequer/marker.h"
#include "detect/boards/lattice.h"
#include "detect/boards/placement.h"
#include "detect/boards/second_look.h"
#include "detect/common/board_geometry.h"
#include "detect/common/cell_unmixer.h"
#include "detect/common/fixed_vector.h"
#include "detect/common/homography.h"
#include "detect/common/light.h"
#include "detect/common/scratch.h"
#include "detect/common/visibility.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/grids/grids.h"

namespace chequer {

/// How a board that did not show where it was expected was found near there.
enum class FoundNear : std::uint8_t { kNot, kByCells, kByCellsAndEdges };

/// A board whose place and orientation are known from its border.
struct AnchoredBoard {
  MarkerSize size;
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  /// Light (R, G, B) and saturation of each cell, row by row, as first seen.
  FixedVector<Eigen::Vector3f, kMaxCells> light;
  FixedVector<std::uint8_t, kMaxCells> saturated;
  Visibility visibility;        ///< which cells stand out as they should; of corners, nothing yet
  float scale = 1;              ///< image pixels per pixel of the coarsest level its corners came from (median)
  PixelBox box;                 ///< where it lies in the image, roughly
  bool motion_blurred = false;  ///< found in a view that undoes motion blur
  FoundNear found_near = FoundNear::kNot;
  /// Of its inner corners, row by row: those that were found. The others lie where these have them.
  std::array<bool, kMaxCorners> found{};
};

/// How much work the search in a grid may take.
struct GridLimit {
  std::uint64_t units = std::numeric_limits<std::uint64_t>::max();
  /// Images on end in which it took as much and was left undone: it goes on where that ended, roughly.
  int waited = 0;
};

/// Finds the boards in grids: tries every placement and turn of every size that the light and dark cells allow and
/// takes the one whose border shows the saturations it should, by the group means of the publication (eq. 4). Works on
/// the image as it is; the plane comes in when a board is found. Of one image, it knows which corners belong to boards;
/// of one grid, what it has sampled. Guarantees at least 9 judged border cells of which 85 % match, saturated and
/// unsaturated ones 4 standard errors apart, and 3 cells' lead over any rival. Chance saturations match so well at one
/// placement in 400; the fit and the code refuse those. A mirror image differs in at least 8 border cells of a 6 × 6.
/// The board then lies to about 0.1 px, the mean of 25 corners of 0.3 px each. 8 µs a grid, most of it for the colours
/// of its cells; 15 µs where clutter is linked to it.
class BoardFinder {
 public:
  BoardFinder(std::vector<BorderPattern> patterns, ColorSpace space);

  /// From now on, corners are others, none of which belongs to a board. To be called for every image.
  void Start(std::size_t corners) { claimed_.Start().assign(corners, 0); }
  /// Mean contrast of the corners of all boards that were found. @param corners as given to Find(). @pre there are
  /// some.
  float ContrastOf(const std::vector<Corner>& corners) const;
  /// Appends the boards of a grid to `boards`. Returns whether one was found. @param search of the same corners; null:
  /// they are few. @param attempt gets the attempt that comes farthest, for finding out why there is no board; may be
  /// null, which costs a comparison an attempt. @param limit after which no other place is tried.
  bool Find(const Grid& grid, std::span<const LatticeCorner> members, const std::vector<Corner>& corners,
            const CornerSearch* search, const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards,
            TraceCandidate* attempt = nullptr, const GridLimit& limit = {});
  /// Whether places in the last grid were left untried because of the limit.
  bool left_undone() const { return grid_->left_undone; }
  /// What the last grid took.
  WorkMeter work() const {
    WorkMeter work = grid_->work;
    work.Add(grid_->lattice.work());
    work.Add(grid_->cells.work());
    return work;
  }

 private:
  // Placements are enumerated, by windows of the lattice, and judged by what the cells of a window show; then the best
  // are chosen, and built.
  void TryWindows(const BorderPattern& pattern, bool turned);
  /// Fills in the windows that hold enough corners. Returns how many corners the fullest holds.
  int GatherWindows(const BorderPattern& pattern, Lattice::Window window);
  void TryWindow(const BorderPattern& pattern, const Lattice::Window& window, bool turned);
  /// Judges a placement by a border that nothing lies over; if its inks are alike and the cells are small, once more by
  /// cells that were solved for together.
  bool JudgeOpen(Placement& placement);
  /// The same without the cells that something may lie over.
  bool JudgeCovered(Placement& placement);
  /// All its corners were found, and all its border shows what it should: by chance, one in a million does.
  bool IsBeyondDoubt(const Placement& placement) const;
  /// Marks the windows of the same size that share cells with one.
  void SpareAround(const Lattice::Window& window);
  void TakeBest(const Lens& lens, std::vector<AnchoredBoard>& boards);
  bool Build(const Placement& placement, const Lens& lens, AnchoredBoard& board);
  /// Fits the board's homography to the plane, by the grid's pairs. False if there is none.
  bool PlaceOnPlane(const Placement& placement, const Lens& lens, AnchoredBoard& board);
  /// Notes which corners are the board's.
  void ClaimCorners(const Placement& placement, AnchoredBoard& board);
  /// Whether a placement passed; notes, where somebody asks, what it fails by.
  bool Accept(const Placement& placement, const Verdict& verdict) {
    if (!verdict.passed() && grid_->attempt)
      NoteAttempt(placement, verdict, grid_->cells, grid_->footprint, space_, *grid_->attempt);
    return verdict.passed();
  }

  /// The search in one grid.
  struct GridSearch {
    TraceCandidate* attempt = nullptr;
    WorkMeter work;  ///< but for the lattice's and its cells'
    GridLimit limit;
    int with_cover = 0;  ///< windows that were tried as boards which something lies over
    bool left_undone = false;
    Lattice lattice;
    LatticeCells cells;
    std::vector<std::pair<int, Lattice::Window>> windows;  ///< with their corners' count
    std::vector<std::uint8_t> spared;  ///< by the window's first corner: a board that is beyond doubt shares its cells
    Footprint footprint;               ///< of the window that was looked at last
    std::vector<Placement> placements;
    PlacementChoice choice;
    std::vector<PointPair> all_pairs, pairs;  ///< of the whole grid, where it lies on a plane; of the board at hand
    std::vector<float> scales;
  };

  const std::vector<BorderPattern> patterns_;
  const int most_corners_;  ///< along a side of the largest pattern
  const ColorSpace space_;
  Scratch<std::vector<std::uint8_t>> claimed_;  ///< by corner of an image: it belongs to a board
  Scratch<GridSearch> grid_;
  CellUnmixer unmixer_;  ///< keeps only memory from one run to the next
  BorderJudge judge_;    ///< so does this
};

/// A board that was read, and how well.
struct SeenBoard {
  std::size_t index = 0;  ///< whose it is, for those who ask
  Eigen::Vector2d center_px{0, 0};
  PixelBox box;
  MarkerSize size;
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  bool has_id = false;
  int corners_used = 0;
  double rms_px = 0;
};

/// Whether the middle of a board lies on another.
bool LiesOn(const Eigen::Matrix3d& plane_from_board, const Eigen::Matrix3d& plane_from_other, MarkerSize size_of_other);

/// Takes boards out of `seen` that are there twice, by groups of corners that did not hang together or by levels of the
/// image that both showed it, and appends their indices to `worse`: those whose middle lies in the middle of one that
/// is known better, with an id, by more corners, or to less deviation; and, unless both were read, those whose middle
/// lies anywhere on such a one, or the other way round: they are parts of it, some cells off. No board that only
/// touches another lies so. Reorders `seen`; n log n for n of them.
void TakeOutTwins(std::vector<SeenBoard>& seen, std::vector<std::size_t>& worse);

}  // namespace chequer
