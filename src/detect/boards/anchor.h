#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "chequer/marker.h"
#include "detect/boards/border_pattern.h"
#include "detect/boards/lattice.h"
#include "detect/common/board_geometry.h"
#include "detect/common/cell_unmixer.h"
#include "detect/common/fixed_vector.h"
#include "detect/common/homography.h"
#include "detect/common/light.h"
#include "detect/common/neighbours.h"
#include "detect/common/scratch.h"
#include "detect/common/work_meter.h"
#include "detect/corners/corners.h"
#include "detect/grids/grids.h"

namespace chequer {

/// A board whose place and orientation are known from its border.
struct AnchoredBoard {
  MarkerSize size;
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  /// Light (R, G, B) and saturation of each cell, row by row, as first seen.
  FixedVector<Eigen::Vector3f, kMaxCells> light;
  FixedVector<std::uint8_t, kMaxCells> saturated;
  FixedVector<std::uint8_t, kMaxCells> covered;  ///< the cell does not show: something lies over it
  float scale = 1;              ///< image pixels per pixel of the coarsest level its corners came from (median)
  PixelBox box;                 ///< where it lies in the image, roughly
  bool motion_blurred = false;  ///< found in a view that undoes motion blur
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
    return work;
  }

 private:
  /// Cells that something lies over: some lines along a side of a footprint.
  struct Cover {
    int side = 0;  ///< top, bottom, left, right
    int lines = 0;

    bool Holds(int row, int col, int rows, int cols) const {
      switch (side) {
        case 0: return row < lines;
        case 1: return row >= rows - lines;
        case 2: return col < lines;
        default: return col >= cols - lines;
      }
    }
  };
  /// Where a board lies in the lattice, and how it is turned.
  struct Placement {
    int pattern = 0;
    Lattice::Window corners;  ///< its inner corners
    int turn = 0;             ///< quarter turns of the board against the lattice
    Cover covered;
    double score = 0;
    int border_seen = 0, border_matches = 0;
    // By what its border was judged.
    Eigen::Vector3f white = Eigen::Vector3f::Ones();
    std::array<double, 2> threshold{};  ///< saturation, of light and dark cells
    bool inks_alike = false;            ///< as they should differ, but by too little
  };
  /// A cell of the lattice.
  struct CellSample {
    Eigen::Vector3f light = Eigen::Vector3f::Zero();
    float blue_share = 0;  ///< of the light
    bool inside = false;   ///< the image, at a place that is known
    bool sampled = false;
  };
  struct Place {
    Eigen::Vector2d center = Eigen::Vector2d::Zero();
    double side = 0;  ///< the shorter one, pixels
  };

  void TryWindows(int pattern, bool turned, const LightReader& reader);
  void TryWindow(int pattern, const Lattice::Window& window, bool turned, const LightReader& reader);
  /// All its corners were found, and all its border shows what it should: by chance, one in a million does.
  bool IsBeyondDoubt(const Placement& placement) const;
  /// Marks the windows of the same size that share cells with one.
  void SpareAround(const Lattice::Window& window);
  /// Whether the footprints around the corners of two windows overlap.
  static bool SharesCells(const Lattice::Window& a, const Lattice::Window& b) {
    return a.x < b.x + b.cols + 1 && b.x < a.x + a.cols + 1 && a.y < b.y + b.rows + 1 && b.y < a.y + a.rows + 1;
  }
  bool FitWindow(const Lattice::Window& window, std::vector<PointPair>* pairs);
  Place PlaceByHomography(int x, int y) const;
  std::optional<Place> PlaceByNeighbours(int x, int y) const;
  const CellSample& CellAt(int x, int y, const LightReader& reader) {
    CellSample& sample = grid_->cells[grid_->Slot(x, y)];
    if (!sample.sampled) {
      grid_->work.Add(WorkStep::kCellSample);
      SampleCell(x, y, reader, sample);
    }
    return sample;
  }
  void SampleCell(int x, int y, const LightReader& reader, CellSample& sample) const;
  /// Of a grid whose cells are smaller than samples of chroma lie apart: the light of all of them at once.
  void UnmixCells(const LightReader& reader);
  void ResampleByHomography(const Lattice::Window& window, const LightReader& reader);
  bool MayBeBorder(const BorderPattern& pattern, const Lattice::Window& window, int turn, const LightReader& reader);
  void MarkVisible(const Lattice::Window& window, const LightReader& reader);
  /// Cells of the window that are not covered.
  static int CellsBesides(const Placement& placement);
  /// Of these, those that show.
  int ShowingBesides(const Placement& placement) const;
  bool ShowsEnough(const Placement& placement);
  bool JudgeBorder(Placement& placement);
  /// Gathers the border cells that show, and white by those of them that are white if this turn is right.
  bool GatherBorder(Placement& placement);
  /// Measures the inks of these cells, light and dark ones apart, as they differ in strength: group means of eq. 4.
  bool MeasureInks(Placement& placement);
  /// Judges a border anew whose inks were alike, by cells that were solved for together, if they are small.
  bool JudgeUnmixed(Placement& placement, const LightReader& reader);
  /// Whether a cell of the footprint, row by row, shows and is not covered.
  bool IsVisible(const Placement& placement, std::size_t cell) const;
  float SaturationOf(const Placement& placement, std::size_t cell, bool dark) const;
  /// Fills in the cells of a board by what its border was judged.
  void DescribeCells(const Placement& placement, AnchoredBoard& board) const;
  /// The same without the cells that something may lie over.
  bool JudgeCovered(Placement& placement);
  /// Whether corners lie along a side of a footprint, where a board only has the ends of its edges.
  bool HasCornersOnItsSides(const Lattice::Window& window) const;
  /// Along how many sides of a placement the checkerboard goes on behind it, boards that were taken left aside: then it
  /// is no board of that size.
  int SidesThatGoOn(const Placement& placement, const LightReader& reader);
  void TakeBest(const LightReader& reader, const Lens& lens, std::vector<AnchoredBoard>& boards);
  bool Build(const Placement& placement, const LightReader& reader, const Lens& lens, AnchoredBoard& board);
  /// Where a point of the lattice lies on the board.
  static Eigen::Vector2d OnBoard(const Placement& placement, const Eigen::Vector2d& lattice);
  /// Fits the board's homography to the plane, by the grid's pairs. False if there is none.
  bool PlaceOnPlane(const Placement& placement, const Lens& lens, AnchoredBoard& board);
  /// Notes which corners are the board's.
  void ClaimCorners(const Placement& placement, AnchoredBoard& board);
  /// Notes, where somebody asks, what an attempt fails by: `measured` instead of `required`. False.
  bool Refuse(const Placement& placement, Refusal why, double measured, double required) {
    if (grid_->attempt) NoteAttempt(placement, why, measured, required);
    return false;
  }
  void NoteAttempt(const Placement& placement, Refusal why, double measured, double required);
  std::array<Eigen::Vector2f, 4> OutlineOf(const Place& place, int x, int y) const;
  void TraceCells(const Placement& placement, TraceCandidate& attempt) const;
  /// Where the footprint lies, before its cells are placed anew.
  const CellSample& SampleOf(const Placement& placement, const Cell& in_footprint) const;
  /// White as the border would have it; as the lightest cell where it has none.
  Eigen::Vector3f WhiteOf(const Placement& placement, MarkerSize size, const std::vector<std::uint8_t>& border) const;

  /// A cell of a border that shows.
  struct BorderCell {
    std::size_t sample = 0;
    bool dark = false, saturated = false;  ///< as it should be
    float saturation = 0;
  };
  /// What is sought: the same for all images.
  struct Sought {
    Sought(std::vector<BorderPattern> patterns, ColorSpace space);
    std::vector<BorderPattern> patterns;
    int most_corners = 0;  ///< along a side of the largest pattern
    ColorSpace space;
  };
  /// The search in one grid.
  struct GridSearch {
    std::size_t Slot(int x, int y) const {
      return static_cast<std::size_t>((y - cell_window.y) * cell_window.cols + x - cell_window.x);
    }

    TraceCandidate* attempt = nullptr;
    WorkMeter work;  ///< but for the lattice's
    GridLimit limit;
    int with_cover = 0;  ///< windows that were tried as boards which something lies over
    bool left_undone = false;
    Lattice lattice;
    std::vector<std::pair<int, Lattice::Window>> windows;  ///< with their corners' count
    std::vector<std::uint8_t> spared;  ///< by the window's first corner: a board that is beyond doubt shares its cells
    std::vector<Placement> placements;
    std::vector<std::size_t> taken;
    std::vector<PointPair> pairs;
    Eigen::Matrix3d image_from_lattice = Eigen::Matrix3d::Identity();
    /// Of a grid that fits into a board, all windows have this homography; else cells are placed by their neighbours.
    bool shared = false;
    bool mixed = false;                   ///< then, whether windows in single cells would hold other cells' chroma
    bool small = false;                   ///< else, whether they may hold so much of it that inks look alike
    std::vector<PointPair> shared_pairs;  ///< its corners
    /// Cells of the lattice, sampled when they are asked for.
    Lattice::Window cell_window;
    std::vector<CellSample> cells;
    std::vector<Eigen::Vector3f> unmixed;  ///< light of the same cells
    /// Of the window's cells, row by row in lattice orientation.
    std::vector<CellSample> samples;
    Lattice::Window marked;             ///< the window of what follows
    std::vector<std::uint8_t> visible;  ///< lighter or darker than its neighbours, as it should be
    int showing = 0;                    ///< of them, all
    NeighbourLead neighbours;
    std::vector<std::uint8_t> inside;  ///< the image
    std::vector<float> value, sorted;
    std::array<std::vector<float>, 2> blue_shares;
    std::vector<BorderCell> border;
  };

  const Sought sought_;
  Scratch<std::vector<std::uint8_t>> claimed_;  ///< by corner of an image: it belongs to a board
  Scratch<GridSearch> grid_;
  CellUnmixer unmixer_;  ///< keeps only memory from one run to the next
};

}  // namespace chequer
