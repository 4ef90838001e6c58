#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "detect/common/colours.h"
#include "detect/common/scratch.h"
#include "detect/common/visibility.h"
#include "detect/identity/cell_sampler.h"

namespace chequer {

/// Of light or dark cells: the means of unsaturated and saturated border cells, and the spread about them.
struct InkClass {
  double plain = 0, inked = 0, deviation = 0;
  bool usable = false;

  /// Of one cell, as a share of the means' distance. @pre usable.
  double spread() const { return deviation / (inked - plain); }
};

/// Of two leads (CellInks::LeadOf()) the one that tells less: 0 if they disagree.
double WeakerLead(double lead, double other);

/// What a board's cells show, and its border's cells: where they lie, how they are printed, what lies over them.
struct ShownCells {
  MarkerSize size;
  const std::vector<std::uint8_t>& border;  ///< saturation of the border's cells
  const CellLights& lights;
  const Visibility& visibility;
};

/// Measures how much ink each cell of a board has, and by the border's cells how much that is of a saturated one.
class CellInks {
 public:
  explicit CellInks(ColorSpace space) : space_(space) {}

  /// A board begins.
  void Start() { board_.Start(); }
  /// False if the border tells the inks of neither class.
  bool Measure(const ShownCells& cells);

  /// Of the cells of that class.
  const InkClass& Of(bool dark) const { return board_->classes[dark]; }
  /// Nearer to the saturated border cells of its class. @pre that class is usable.
  bool IsSaturated(std::size_t cell, bool dark) const {
    return board_->ink[cell] > (Of(dark).plain + Of(dark).inked) / 2;
  }
  const CellColour& ColourOf(std::size_t cell) const { return board_->colours[cell]; }
  /// Light of the border's white cells.
  const Eigen::Vector3f& white() const { return board_->white; }
  /// Where between its class's means a cell lies, from −½, unsaturated, to ½. Of what it may be, what tells least.
  /// @pre the class is usable.
  double LeadOf(std::size_t cell, bool dark, float half_lit) const;

 private:
  bool MeasureWhite(const ShownCells& cells);
  /// Measures the light cells: by their saturation, or where that is spread widely by a difference of light if that is
  /// spread less, or where a veil lies over some, as that leaves it as it is.
  InkClass MeasureYellow(const ShownCells& cells, bool veiled);
  /// Measures the dark cells, and by which share of green light.
  InkClass MeasureBlue(const ShownCells& cells);
  /// Finds white light that lies over dark cells, such as the mirror image of a lamp. Whether there is some. @pre
  /// MeasureBlue() has found the class usable.
  bool FindVeils(const ShownCells& cells);
  /// The most that lies over the dark cells beside a light one.
  float VeilBeside(MarkerSize size, int row, int col) const;
  /// What cells may be without veils.
  void TakeVeilsOff(const ShownCells& cells);
  InkClass ClassOf(const ShownCells& cells, bool dark) const;
  /// How far the kernel's cells lie from the nearer mean, root mean square; 0 if they are too few.
  double KernelDeviation(const ShownCells& cells, bool dark, const InkClass& by_border) const;

  /// What is known of one board, by cell where nothing else is said.
  struct Board {
    Eigen::Vector3f white = Eigen::Vector3f::Zero();
    std::vector<CellColour> colours;
    std::vector<float> ink;           ///< what tells saturated cells from others
    float green = 0;                  ///< share of green light in what tells blue from black
    std::vector<float> veil;          ///< white light that lies over dark cells, as a share of white's
    std::vector<float> bare;          ///< what its `ink` may be without such light
    std::array<InkClass, 2> classes;  ///< of light (0) and dark (1) ones
    std::vector<float> values;        ///< for a single step
  };

  ColorSpace space_;
  Scratch<Board> board_;
};

}  // namespace chequer
