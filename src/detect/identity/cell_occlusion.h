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

/// Finds the cells of a board that something lies over, beside those that no corner shows.
class CellOcclusion {
 public:
  /// Begins a board: adds to what the fit has found the cells that do not stand out from their neighbours.
  void Find(const FittedBoard& board, MarkerSize size, std::span<const Eigen::Vector3f> light);
  /// Adds cells of colours that the board does not have: they belong to what lies over it. Whether there are some.
  /// @param white light of its white cells.
  bool AddOffColour(const ShownCells& cells, const Eigen::Vector3f& white);
  /// Finds cells that show but may be covered in part. Each lies beside a hidden cell or has a hidden corner. Its light
  /// is uneven, or it is a light cell and too dark. @pre all hidden cells are known.
  void FindReached(const BoardInImage& in, std::span<const Eigen::Vector3f> light);
  const Visibility& visibility() const { return found_->visibility; }
  /// Whether a cell is one of these. @pre FindReached().
  bool MayReach(std::size_t cell) const { return found_->reached[cell] != 0; }

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
  /// How far the hue of a cell lies from that of the nearer ink.
  float OffInks(const OfClass& of_class, std::size_t cell) const;

  /// What is known of one board, by cell where nothing else is said.
  struct Found {
    Visibility visibility;
    std::vector<std::uint8_t> wrong;  ///< by cell: those that do not look like the board's, and what lies between them
    std::vector<std::uint8_t> reached;  ///< by cell: whether it may be covered in part
    // What single steps need.
    /// Of a light cell, the shares of the three channels in its light; of a dark one, how much more of white's light
    /// each of them has than the least.
    std::vector<Eigen::Vector3f> hues;
    std::vector<float> values;
    std::array<OfClass, 2> classes;  ///< light, dark
    std::vector<std::uint8_t> seen;
    NeighbourLead neighbours;
  };

  Scratch<Found> found_;
};

}  // namespace chequer
