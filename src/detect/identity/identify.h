#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "detect/common/cell_unmixer.h"
#include "detect/common/colours.h"
#include "detect/common/light.h"
#include "detect/common/neighbours.h"
#include "detect/common/scratch.h"
#include "detect/fit/fitted_board.h"

namespace chequer {

/// What the colours of a fitted board say.
struct Identity {
  int family = -1;  ///< index of the family whose code was read; of the first one of that size where none was
  std::optional<Decoded> decoded;
  bool id_decided = false;
  bool saturation_told = false;  ///< the border's inks stand apart, so that the kernel was read
  double margin = -1;            ///< log-likelihood ratio of the best word over the second best; −1: no word is near
  double least_margin = 0;       ///< that decides
  int cells_off = 0;             ///< of the word nearest to the kernel where none is near enough, …
  int cells_corrected = 0;       ///< … and how many the code corrects
  double luminance_overlap = 0;
  double saturation_overlap = 0;
  int cells_hidden = 0;
  std::size_t mixed_pixels = 0;  ///< of cells that had to be read together
  bool plausible = true;         ///< enough of the board shows that it lies as it was taken to lie
};

/// Reads the identity of boards.
/// An id is given only where its likelihood is e⁶ times that of the next one (e⁹ where light or white balance are
/// warned of) and its word within the code's guaranteed radius: below one wrong id in 400 boards at the very limit,
/// none seen in the tests' frames. Cells that do not stand out from their neighbours say nothing either way. 2.3 µs a 6
/// × 6 board, half of it the decoder.
class Identifier {
 public:
  /// @param options must outlive it.
  explicit Identifier(const DetectorOptions& options);

  /// @param board a fit of a board of that size, its axes turned as the border says.
  Identity Identify(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);

  /// How a cell of the last board was read.
  struct Reading {
    CellColour colour;
    bool occluded = true;
    std::optional<bool> saturated;  ///< nothing where the inks of its class cannot be told
    float log_likelihood = 0;       ///< of kernel cells
  };
  /// For traces. @pre the last Identity::saturation_told.
  Reading ReadingOf(MarkerSize size, Cell cell) const;

 private:
  /// Of light or dark cells: means of unsaturated and saturated border cells, and the spread about them.
  struct Class {
    double plain = 0, inked = 0, deviation = 0;
    bool usable = false;

    /// Of one cell, as a share of the means' distance. @pre usable.
    double spread() const { return deviation / (inked - plain); }
  };

  void ReadCells(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);
  /// Where windows within the cells would be too small: reads them all at once. False where that fails.
  bool ReadSmallCells(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);
  /// Mean light of a cell's middle, which its neighbours do not blur into.
  Eigen::Vector3f MiddleLight(const FittedBoard& board, MarkerSize size, int cell, const LightReader& reader,
                              const Lens& lens) const;
  /// The level of an overexposed cell is known by the mixed pixels at its edges alone, and takes those of its
  /// neighbours with it: where there is one, reads the cells' middles instead. White stays white there, and yellow is
  /// short of blue.
  void ReadOverexposed(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);
  /// Where shadows' edges cross the board: as if it were lit alike all over.
  void EvenOutCells(const FittedBoard& board, MarkerSize size);
  void FindOccluded(const FittedBoard& board, MarkerSize size);
  /// Hides what lies over the board: cells that look wrong, and those between them. Whether there are more now.
  bool HideWrong(MarkerSize size);
  bool MeasureSaturation(MarkerSize size, const std::vector<std::uint8_t>& border);
  /// Writes of light cells what tells yellow from white, and what the border says of it: the saturation, or where that
  /// is spread widely, as by a highlight, a difference of light if that is spread less.
  Class MeasureYellow(MarkerSize size, const std::vector<std::uint8_t>& border);
  /// Writes of dark cells what tells blue from black, and what the border says of it.
  Class MeasureBlue(MarkerSize size, const std::vector<std::uint8_t>& border);
  /// Writes by how much what tells blue from black is larger in dark cells under a veil of white light.
  /// @param green its share of green light.
  void MeasureVeils(MarkerSize size, const Class& dark, float green);
  Class ClassOf(MarkerSize size, const std::vector<std::uint8_t>& border, bool dark) const;
  /// Light cells of colours that the board does not have belong to what lies over it. Whether there are some.
  bool HideOffColour(MarkerSize size, const std::vector<std::uint8_t>& border);
  void Decode(MarkerSize size, Identity& identity);
  /// Whether the cells that show would be as right on a board that lies otherwise.
  bool MayLieElsewhere(MarkerSize size, const std::vector<std::uint8_t>& border);
  void MeasureOverlaps(MarkerSize size, Identity& identity) const;

  /// What is known of one board, by cell where nothing else is said.
  struct Cells {
    std::vector<Eigen::Vector3f> light, middles, unmixed;
    std::size_t mixed_pixels = 0;
    std::vector<CellColour> colours;
    std::vector<float> ink;  ///< what tells saturated cells from others
    std::vector<std::uint8_t> occluded;
    std::vector<float> half_lit;  ///< by how much less of its light may have come than was taken for it
    std::vector<float> veil;      ///< by how much less of `ink` may be the cell's own, as a highlight lies on it
    Eigen::Vector3f white = Eigen::Vector3f::Zero();  ///< light of the border's white cells
    std::vector<std::uint8_t> wrong;    ///< those that do not look like the board's, and what lies between them
    std::vector<float> log_likelihood;  ///< of the kernel's
    std::array<Class, 2> classes;       ///< of light (0) and dark (1) ones
    // What single steps need.
    std::vector<Eigen::Vector3f> shares;  ///< of the three channels in a cell's light
    std::vector<std::size_t> known;       ///< those of one ink
    std::vector<float> values;
    std::vector<std::uint8_t> saturated, seen;
    NeighbourLead neighbours;
  };

  const DetectorOptions& options_;
  /// By family: the ids in use, where not all are.
  const std::vector<std::optional<Roster>> rosters_;
  /// By family: saturation of the border's cells, row by row of the whole board.
  const std::vector<std::vector<std::uint8_t>> borders_;
  Scratch<Cells> cells_;
  CellUnmixer unmixer_;  ///< keeps only memory from one board to the next
};

}  // namespace chequer
