#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "detect/colours.h"
#include "detect/fit.h"
#include "detect/light.h"

namespace chequer {

/// What the colours of a fitted board say.
struct Identity {
  int family = -1;  ///< index of the family whose code was read; of the first one of that size where none was
  std::optional<Decoded> decoded;
  bool id_decided = false;
  double luminance_overlap = 0;
  double saturation_overlap = 0;
  int cells_hidden = 0;
  bool plausible = true;  ///< dark cells are darker than light ones
};

/// Reads the identity of boards. Keeps its memory.
class Identifier {
 public:
  explicit Identifier(const DetectorOptions& options);

  /// @param board a fit of a board of that size, its axes turned as the border says.
  Identity Identify(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);

 private:
  void ReadCells(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);
  void FindHidden(const FittedBoard& board, MarkerSize size);
  bool MeasureSaturation(MarkerSize size, const std::vector<std::uint8_t>& border);
  /// Light cells of colours that the board does not have belong to what lies over it. Whether there are some.
  bool HideOffColour(MarkerSize size, const std::vector<std::uint8_t>& border);
  void Decode(MarkerSize size, Identity& identity);
  void MeasureOverlaps(MarkerSize size, Identity& identity) const;

  const DetectorOptions& options_;
  std::vector<std::optional<Roster>> rosters_;
  /// By family: saturation of the border's cells, row by row of the whole board.
  std::vector<std::vector<std::uint8_t>> borders_;
  std::vector<Eigen::Vector3f> light_;
  std::vector<CellColour> colours_;
  std::vector<std::uint8_t> hidden_;
  Eigen::Vector3f white_;      ///< light of the border's white cells
  std::vector<float> values_;  ///< scratch
  std::vector<int> doubtful_;  ///< cells, scratch
  std::vector<float> log_likelihood_;
  /// Of light (0) and dark (1) cells: means of unsaturated and saturated border cells, and the spread about them.
  struct Class {
    double plain = 0, inked = 0, deviation = 0;
    bool usable = false;
  };
  std::array<Class, 2> classes_;
};

}  // namespace chequer
