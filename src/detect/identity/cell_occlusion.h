#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "detect/common/neighbours.h"
#include "detect/common/scratch.h"
#include "detect/common/visibility.h"
#include "detect/identity/cell_inks.h"
#include "detect/identity/cell_sampler.h"

namespace chequer {

/// What may lie over a part of a cell that shows.
enum class Reach : std::uint8_t {
  kNone,
  kBeside,  ///< what hides a cell beside it, or one of its corners
  kInLine,  ///< what hides a single border cell at an end of its row or column
};

/// Finds the cells of a board that something lies over, beside those that no corner shows.
class CellOcclusion {
 public:
  /// Begins a board: adds to what the fit has found the cells that do not stand out from their neighbours.
  void Find(const FittedBoard& board, MarkerSize size, std::span<const Eigen::Vector3f> light);
  /// Adds cells of colours that the board does not have, and border cells that have not that of their ink: they belong
  /// to what lies over it. Whether there are some.
  /// @param white light of its white cells.
  bool AddOffColour(const ShownCells& cells, const Eigen::Vector3f& white);
  /// Finds cells that show but may be covered in part: beside hidden ones, those whose light is uneven, and light ones
  /// that are too dark; between two ends that something narrow lies over, such as a wire, which may hide no corner, all
  /// of the row or column; in line with one such end, those whose light is uneven. @pre all hidden cells are known.
  void FindReached(const BoardInImage& in, std::span<const Eigen::Vector3f> light);
  const Visibility& visibility() const { return found_->visibility; }
  /// @pre FindReached().
  Reach ReachOf(std::size_t cell) const { return found_->reached[cell]; }

 private:
  /// Marks the cells that do not stand out from their neighbours as their class should.
  void MarkFlat(MarkerSize size, std::span<const Eigen::Vector3f> light);
  /// Hides the cells that look wrong, and those between them. Whether there are more hidden ones now.
  bool HideWrong(MarkerSize size, Hidden why);

  /// The hues of dark or of light cells.
  struct OfClass {
    std::array<std::vector<std::size_t>, 2> told_by;  ///< border cells that show, of the plain and of the saturated ink
    std::array<Eigen::Vector3f, 2> inks{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};  ///< their median hues
    float most_off = 0;  ///< a cell whose hue lies farther from both is none of the board's
    bool told = false;   ///< both inks show
  };

  /// Measures the hues of all cells, and sorts the border's cells by ink.
  void MeasureHues(const ShownCells& cells, const Eigen::Vector3f& white);
  /// Measures the hues of a class's inks. @pre MeasureHues().
  void MeasureInkHues(OfClass& of_class);
  /// How far the hue of a cell lies from its ink's, if that is known as the border's, else from the nearer one's.
  float OffInks(const ShownCells& cells, std::size_t cell, int row, int col) const;
  /// Measures how light the border's light cells must be at least. @pre MeasureHues().
  void MeasureLightness(const ShownCells& cells);
  /// Whether a cell is one of these and is too dark for its ink.
  bool IsTooDark(const ShownCells& cells, std::size_t cell, int row, int col) const;
  /// Of the border cells at the ends of a cell's row, or of its column, those that something narrow lies over: the more
  /// of the two. One end is hidden or too dark between two that are not, the other one, too, or its light is uneven.
  template <class Uneven>
  int EndsCovered(MarkerSize size, int row, int col, const Uneven& uneven) const;

  /// What is known of one board, by cell where nothing else is said.
  struct Found {
    Visibility visibility;
    std::vector<std::uint8_t> wrong;  ///< by cell: those that do not look like the board's, and what lies between them
    std::vector<std::uint8_t> too_dark;  ///< by cell: light border cells that are, for their ink
    std::vector<Reach> reached;          ///< by cell
    // What single steps need.
    /// Of a light cell, the shares of the three channels in its light; of a dark one, how much more of white's light
    /// each of them has than the least.
    std::vector<Eigen::Vector3f> hues;
    std::vector<float> values;
    std::array<OfClass, 2> classes;      ///< light, dark
    std::array<float, 2> least_light{};  ///< of light border cells, of the plain and of the saturated ink
    std::vector<std::uint8_t> seen;
    NeighbourLead neighbours;
  };

  Scratch<Found> found_;
};

}  // namespace chequer
