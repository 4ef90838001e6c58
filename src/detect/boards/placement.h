#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "chequer/marker.h"
#include "detect/boards/lattice_cells.h"

namespace chequer {

struct AnchoredBoard;

/// The border's saturation at one size, precomputed.
struct BorderPattern {
  explicit BorderPattern(MarkerSize marker_size);
  MarkerSize size;
  std::vector<Cell> cells;
  std::vector<std::uint8_t> saturated;
  /// The light cells and their saturation, by turn, in rows and columns of the footprint.
  std::array<std::vector<std::pair<Cell, std::uint8_t>>, 4> light_cells;
  /// For each cell of the board, row by row, its place in the footprint, row by row as well; by turn.
  std::array<std::vector<std::size_t>, 4> in_footprint;
};

/// Cell (row, col) of the board in the footprint's own rows and columns, for a board turned by quarter turns.
Cell InFootprint(MarkerSize size, int row, int col, int turn);

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

/// Where a board lies in a lattice, and how it is turned.
struct Placement {
  const BorderPattern* pattern = nullptr;
  Lattice::Window corners;  ///< its inner corners
  int turn = 0;             ///< quarter turns of the board against the lattice
  Cover covered;
  double score = 0;
  int border_seen = 0, border_matches = 0;
  // By what its border was judged.
  Eigen::Vector3f white = Eigen::Vector3f::Ones();
  std::array<double, 2> threshold{};  ///< saturation, of light and dark cells
  bool inks_alike = false;            ///< as they should differ, but by too little

  /// Of the footprint.
  int rows() const { return corners.rows + 1; }
  int cols() const { return corners.cols + 1; }
  /// Whether a cell of the footprint shows and is not covered.
  bool Shows(const Footprint& footprint, std::size_t cell) const {
    if (!footprint.visible[cell] || covered.lines == 0) return footprint.visible[cell];
    const int at = static_cast<int>(cell);
    return !covered.Holds(at / cols(), at % cols(), rows(), cols());
  }
  /// Whether the footprints overlap.
  bool SharesCells(const Placement& other) const {
    const Lattice::Window &a = corners, &b = other.corners;
    return a.x < b.x + b.cols + 1 && b.x < a.x + a.cols + 1 && a.y < b.y + b.rows + 1 && b.y < a.y + a.rows + 1;
  }
};

/// What a placement fails by, `measured` instead of `required`; or nothing.
struct Verdict {
  Refusal why = Refusal::kNone;
  double measured = 0, required = 0;

  bool passed() const { return why == Refusal::kNone; }
};

/// Whether enough cells of a placement stand out from their neighbours.
Verdict ShowsEnough(const Placement& placement, const Footprint& footprint);
/// Of the cells that are not covered, how many do not stand out.
int NotShowing(const Placement& placement, const Footprint& footprint);

/// Judges whether borders show the saturations they should. Keeps only memory from one to the next.
class BorderJudge {
 public:
  explicit BorderJudge(ColorSpace space) : space_(space) {}

  /// Whether the light cells of a border that should be yellow return less blue than the others. Whatever the white is,
  /// so no colours need be computed: refuses nearly every window of a wall of tiles at once.
  bool MayBeBorder(const Placement& placement, LatticeCells& cells);
  /// Fills in by what the border was judged.
  Verdict Judge(const Footprint& footprint, Placement& placement, WorkMeter& work);
  /// Fills in the cells of a board by what its border was judged.
  void Describe(const Placement& placement, const Footprint& footprint, AnchoredBoard& board) const;

 private:
  /// A cell of a border that shows.
  struct BorderCell {
    std::size_t sample = 0;
    bool dark = false, saturated = false;  ///< as it should be
    float saturation = 0;
  };
  /// Gathers the border cells that show, and white by those of them that are white if this turn is right.
  Verdict Gather(const Footprint& footprint, Placement& placement, WorkMeter& work);
  /// Measures the inks of these cells, light and dark ones apart, as they differ in strength: group means of eq. 4.
  Verdict MeasureInks(const Footprint& footprint, Placement& placement);

  ColorSpace space_;
  std::vector<BorderCell> border_;
  std::array<std::vector<float>, 2> blue_shares_;  ///< by saturation
};

/// Which of some placements may be boards, by their indices.
struct PlacementChoice {
  std::vector<std::size_t> taken, rivalled;

  /// Those that clearly explain more than all that they share cells with. Sorts the placements.
  void Choose(std::vector<Placement>& placements, WorkMeter& work);
};

/// Whether corners lie along a side of a footprint, where a board only has the ends of its edges.
bool HasCornersOnItsSides(const Lattice& lattice, const Lattice::Window& window);
/// Whether the checkerboard goes on beyond several sides of a placement, the others taken left aside: then it is no
/// board of that size.
bool GoesOn(const Placement& placement, const std::vector<Placement>& placements, const PlacementChoice& choice,
            LatticeCells& cells);

/// Notes what an attempt fails by, if it came farther than the best by now. @param footprint that was looked at last.
void NoteAttempt(const Placement& placement, const Verdict& verdict, const LatticeCells& cells,
                 const Footprint& footprint, ColorSpace space, TraceCandidate& best);

}  // namespace chequer
