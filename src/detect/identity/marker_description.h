#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/detector.h"
#include "chequer/hidden.h"
#include "detect/common/colours.h"
#include "detect/common/light.h"
#include "detect/common/scratch.h"
#include "detect/fit/fit.h"
#include "detect/identity/cell_inks.h"
#include "detect/identity/cell_occlusion.h"
#include "detect/identity/cell_sampler.h"
#include "detect/pose/plane_pose.h"

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

/// Instead of whether a cell is saturated, where that cannot be told.
inline constexpr std::uint8_t kInkUntold = 2;

/// Whether what shows of a board agrees with the border just as well where the board lies turned, shifted, or both.
/// That is so of one 6 × 6 board in sixteen of which two lines are occluded: turned by half and shifted by two lines,
/// its sides are the same, and the line that becomes the border may be like it. @param hidden, saturated as seen (or
/// kInkUntold), border as it should be: by cell, row by row.
bool AgreesElsewhere(MarkerSize size, std::span<const Hidden> hidden, std::span<const std::uint8_t> saturated,
                     std::span<const std::uint8_t> border);

/// Reads the identity of boards.
/// An id is given only where its likelihood is e⁶ times that of the next one (e⁹ where light or white balance are
/// warned of) and its word within the code's guaranteed radius: below one wrong id in 400 boards at the very limit,
/// none seen in the tests' frames. Cells that do not stand out from their neighbours say nothing either way. 2.3 µs a 6
/// × 6 board, half of it the decoder.
class Identifier {
 public:
  /// @param options must outlive it.
  explicit Identifier(const DetectorOptions& options);

  /// @param board a fit of a board of that size, its axes turned as the border says. @param size of one of the
  /// families.
  Identity Identify(const FittedBoard& board, MarkerSize size, const LightReader& reader, const Lens& lens);

  /// How a cell of the last board was read.
  struct Reading {
    CellColour colour;
    Hidden hidden = Hidden::kNot;
    std::optional<bool> saturated;  ///< nothing where the inks of its class cannot be told
    float log_likelihood = 0;       ///< of kernel cells
  };
  /// For traces. @pre the last Identity::saturation_told.
  Reading ReadingOf(MarkerSize size, Cell cell) const;
  /// Of the last board, as its fit has it, less the cells that their colours show to be hidden. @pre as ReadingOf().
  const Visibility& visibility() const { return occlusion_.visibility(); }
  /// The same, less those that something lies over in part. @pre as ReadingOf().
  Visibility WhollyVisible() const;

 private:
  /// Measures the inks by the border and leaves out cells of other colours. False if the inks of neither class differ.
  bool MeasureInks(const ShownCells& shown);
  /// Log likelihood ratio of each kernel cell, saturated to unsaturated; 0 if the cell is hidden.
  void WeighKernel(const ShownCells& shown, Identity& identity);
  /// The likeliest word of all families of that size.
  void Decode(MarkerSize size, Identity& identity);
  /// Whether its margin decides it.
  void Decide(const FittedBoard& board, Identity& identity) const;
  /// Whether nothing would reveal that a cell is misread, and colours overlap so much that one may be.
  bool IsUnchecked(const Identity& identity) const;
  /// Whether the cells that show would be as right on a board that lies otherwise.
  bool MayLieElsewhere(MarkerSize size, const std::vector<std::uint8_t>& border);
  void MeasureOverlaps(MarkerSize size, Identity& identity) const;

  /// What is known of one board.
  struct Cells {
    CellLights lights;
    std::vector<float> log_likelihood;    ///< of the kernel's
    std::vector<std::uint8_t> saturated;  ///< for a single step
  };

  const DetectorOptions& options_;
  /// By family: the ids in use, where not all are.
  const std::vector<std::optional<Roster>> rosters_;
  /// By family: saturation of the border's cells, row by row of the whole board.
  const std::vector<std::vector<std::uint8_t>> borders_;
  Scratch<Cells> cells_;
  CellSampler sampler_;
  CellOcclusion occlusion_;
  CellInks inks_;
};

/// Sets a warning, beside those that are set.
void Set(MarkerPose& marker, Warning warning);

/// Writes what a fit and the colours say of a marker, all but its pose, with the warnings that they call for.
/// @param identity of one of the options' families, whose size the board has.
void Describe(const FittedBoard& fitted, const Identity& identity, const DetectorOptions& options, const Lens& lens,
              MarkerPose& marker);

/// Gives a marker whose identity is not decided that of the board which was followed there.
/// @param family index into DetectorOptions::families.
void CarryIdentity(int family, std::uint64_t id, const DetectorOptions& options, MarkerPose& marker);

/// What a fit says of where a board of that size lies whose cells are that wide and high, with what its print and the
/// lens may be off.
BoardMeasurement MeasurementOf(const FittedBoard& fitted, MarkerSize size, const Eigen::Vector2d& cell_m,
                               const PrintTolerance& tolerance, const Lens& lens);

/// The poses that a measurement leads to.
struct BoardPoses {
  BoardMeasurement measured;
  std::array<PlanePose, 2> poses;  ///< as of PlanePoses
};

/// Nothing for a degenerate or mirrored homography.
std::optional<BoardPoses> PosesOf(const BoardMeasurement& measured);

/// Adds the likelier of a board's two poses, and how likely the other one is, which its covariance allows for. Where
/// even it leaves more unexplained than noise can be, the covariance is widened by as much (the ratio of Birge 1932),
/// and the warning set.
void DescribePose(const BoardPoses& board, MarkerPose& marker);

}  // namespace chequer
