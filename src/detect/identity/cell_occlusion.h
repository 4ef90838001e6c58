#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
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
  kOver,    ///< what has mixed its colour with the cell's, or runs along the cell's row or column
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
  /// that are too dark; on boards that are hidden in part, those that look mixed; in line with a border cell that
  /// something narrow lies over, such as a wire, which may hide no corner, those whose light is uneven, or, where more
  /// tells of it, all of the row or column. @pre all hidden cells are known.
  void FindReached(const BoardInImage& in, std::span<const Eigen::Vector3f> light);
  const Visibility& visibility() const { return found_->visibility; }
  /// @pre FindReached().
  Reach ReachOf(std::size_t cell) const { return found_->reached[cell]; }
  /// Whether an ink of the border reflects less than nothing: the light that the fit took it to be in is not its own,
  /// but what a cover makes of it. @pre AddOffColour().
  bool BelowBlack() const { return found_->below_black; }

 private:
  /// Marks the cells that do not stand out from their neighbours as their class should.
  void MarkFlat(MarkerSize size, std::span<const Eigen::Vector3f> light);
  /// Hides the cells that look wrong, and those between them. Whether there are more hidden ones now.
  bool HideWrong(MarkerSize size, Hidden why);

  static constexpr float kAnyLight = std::numeric_limits<float>::max();
  /// Of one ink.
  struct LightRange {
    float least = -kAnyLight, most = kAnyLight;
  };
  /// The hues of dark or of light cells, and their light.
  struct OfClass {
    std::array<std::vector<std::size_t>, 2> told_by;  ///< border cells that show, of the plain and of the saturated ink
    std::array<Eigen::Vector3f, 2> inks{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};  ///< their median hues
    float most_off = 0;    ///< a cell whose hue lies farther from both is none of the board's
    float least_tint = 0;  ///< one whose hue lies as far from both looks mixed with another colour
    bool told = false;     ///< both inks show
    /// Of the plain and of the saturated ink: cells beyond it have something over them.
    std::array<LightRange, 2> lightness;
  };

  /// Measures the hues of all cells, and sorts the border's cells by ink.
  void MeasureHues(const ShownCells& cells, const Eigen::Vector3f& white);
  /// Measures the hues of a class's inks. @pre MeasureHues().
  void MeasureInkHues(OfClass& of_class);
  /// How far the hue of a cell lies from its ink's, if that is known as the border's, else from the nearer one's; of an
  /// overexposed cell, from what lies between that and white.
  float OffInks(const ShownCells& cells, std::size_t cell, int row, int col) const;
  /// Measures by the border how light light cells must be at least, and dark ones at most. @pre MeasureHues().
  /// @param white as AddOffColour() has it.
  void MeasureLightness(const ShownCells& cells, const Eigen::Vector3f& white);
  /// Whether a cell is too dark or too light for its ink, or in the kernel for both of its class, or has another hue;
  /// in sharp images, whether it is a light one of the border that is too dark. @param off_inks OffInks().
  bool LooksMixed(const ShownCells& cells, std::size_t cell, int row, int col, float off_inks) const;
  /// The evidence that something narrow runs along a kernel cell's row or its column, the stronger of the two. 0: none.
  /// 1: the border cell at one end is hidden or looks mixed, and its neighbours in the border are clear. 2: so is the
  /// other end, or its light is uneven; in blurred images also if a cell between the ends is hidden or looks mixed, and
  /// those on either side of the line are clear.
  template <class Uneven>
  int ToldOfLine(MarkerSize size, int row, int col, const Uneven& uneven) const;

  /// What is known of one board, by cell where nothing else is said.
  struct Found {
    Visibility visibility;
    std::vector<std::uint8_t> wrong;  ///< by cell: those that do not look like the board's, and what lies between them
    std::vector<std::uint8_t> mixed;  ///< by cell: those that look mixed with the colour of something over them
    std::vector<Reach> reached;
    // What single steps need.
    /// Of a light cell, the shares of the three channels in its light; of a dark one, how much more of white's light
    /// each of them has than the least.
    std::vector<Eigen::Vector3f> hues;
    std::vector<float> values;
    std::array<OfClass, 2> classes;  ///< light, dark
    std::vector<std::uint8_t> seen;
    NeighbourLead neighbours;
    bool below_black = false;  ///< BelowBlack()
    bool blurred = false;      ///< so widely that the light of a cell that is covered in part is hardly uneven
  };

  Scratch<Found> found_;
};

}  // namespace chequer
