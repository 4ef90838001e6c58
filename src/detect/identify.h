#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "detect/colours.h"
#include "detect/fitted_board.h"
#include "detect/light.h"
#include "detect/neighbours.h"

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
  bool plausible = true;  ///< enough of the board shows that it lies as it was taken to lie
};

/// Reads the identity of boards. Keeps its memory.
/// An id is given only where its likelihood is e⁶ times that of the next one (e⁹ where light or white balance are
/// warned of) and its word within the code's guaranteed radius: below one wrong id in 400 boards at the very limit,
/// none seen in the tests' frames. Cells that do not stand out from their neighbours say nothing either way. 2.3 µs a 6
/// × 6 board, half of it the decoder.
class Identifier {
 public:
  explicit Identifier(const DetectorOptions& options);

  /// @param board a fit of a board of that size, its axes turned as the border says.
  Identity Identify(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);

  /// How a cell of the last board was read.
  struct Reading {
    CellColour colour;
    bool hidden = true;
    std::optional<bool> saturated;  ///< nothing where the inks of its class cannot be told
    float log_likelihood = 0;       ///< of kernel cells
  };
  /// For traces. @pre the last Identity::saturation_told.
  Reading ReadingOf(MarkerSize size, Cell cell) const;

 private:
  void ReadCells(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);
  /// Where shadows' edges cross the board: as if it were lit alike all over.
  void EvenOutCells(const FittedBoard& board, MarkerSize size);
  void FindHidden(const FittedBoard& board, MarkerSize size);
  /// Hides what lies over the board: cells that look wrong, and those between them. Whether there are more now.
  bool HideWrong(MarkerSize size);
  bool MeasureSaturation(MarkerSize size, const std::vector<std::uint8_t>& border);
  /// Light cells of colours that the board does not have belong to what lies over it. Whether there are some.
  bool HideOffColour(MarkerSize size, const std::vector<std::uint8_t>& border);
  void Decode(MarkerSize size, Identity& identity);
  /// Whether the cells that show would be as right on a board that lies otherwise.
  bool MayLieElsewhere(MarkerSize size, const std::vector<std::uint8_t>& border);
  void MeasureOverlaps(MarkerSize size, Identity& identity) const;

  const DetectorOptions& options_;
  std::vector<std::optional<Roster>> rosters_;
  /// By family: saturation of the border's cells, row by row of the whole board.
  std::vector<std::vector<std::uint8_t>> borders_;
  std::vector<Eigen::Vector3f> light_;
  std::vector<CellColour> colours_;
  std::vector<float> ink_;  ///< by cell, what tells saturated cells from others: of dark ones BlueOf()
  std::vector<std::uint8_t> hidden_;
  std::vector<float> half_lit_;          ///< by cell: by how much less of its light may have come than was taken for it
  Eigen::Vector3f white_;                ///< light of the border's white cells
  std::vector<Eigen::Vector3f> shares_;  ///< of the three channels in a cell's light, scratch
  std::vector<std::size_t> known_;       ///< cells of one ink, scratch
  std::vector<float> values_;            ///< scratch
  std::vector<std::uint8_t> saturated_;  ///< scratch
  std::vector<std::uint8_t> seen_;       ///< scratch
  NeighbourLead neighbours_;
  std::vector<std::uint8_t> wrong_;  ///< cells that do not look like the board's, and what lies between them
  std::vector<float> log_likelihood_;
  /// Of light (0) and dark (1) cells: means of unsaturated and saturated border cells, and the spread about them.
  struct Class {
    double plain = 0, inked = 0, deviation = 0;
    bool usable = false;
  };
  std::array<Class, 2> classes_;
};

}  // namespace chequer
