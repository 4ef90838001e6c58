#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "chequer/detector.h"
#include "detect/boards/boards.h"
#include "detect/common/board_geometry.h"
#include "detect/common/light.h"
#include "detect/common/neighbours.h"
#include "detect/identity/marker_description.h"
#include "detect/memory/memory.h"

namespace chequer {

/// Makes of remembered boards what a search would have found of them.
class ExpectedBoards {
 public:
  /// @param options must outlive it.
  explicit ExpectedBoards(const DetectorOptions& options);

  /// Fills `board` as if it had been found at that place; the illumination of its cells is sampled there, and those
  /// outside the image are covered. False where too little of it lies in the image. @param plane_from_board where it is
  /// expected.
  bool Expect(const RememberedBoard& remembered, const Eigen::Matrix3d& plane_from_board, const LightReader& reader,
              const Lens& lens, AnchoredBoard& board);

  /// What the cells of the board that `identifier` has read last say of a remembered identity.
  struct Evidence {
    int border_seen = 0, border_matches = 0;  ///< cells
    double log_likelihood = 0;                ///< of the kernel's cells: for the word over its opposite
    int contradictions = 0;                   ///< kernel cells that are clearly not the word's
  };
  /// @pre the identifier's last Identity::saturation_told.
  Evidence EvidenceOf(const RememberedBoard& remembered, const Identifier& identifier) const;

  /// Marks the cells as covered that do not stand out from their neighbours; where the image is as sharp as it was,
  /// those that stand out much less than they did, and of those that something hid, those that do so much less than
  /// others: next to lighter or darker cells, what lies over a whole line of them may. @pre `board` was expected.
  void HideWhatDoesNotShow(const RememberedBoard& remembered, bool sharp, AnchoredBoard& board);
  /// What RememberedBoard::leads has of a board that nothing lies over.
  void LearnLeads(const AnchoredBoard& board, RememberedBoard& remembered);

 private:
  /// By how much the cells stand out from their neighbours, over the board's contrast; covered cells do not count.
  void MeasureLeads(const AnchoredBoard& board);
  /// Which of its cells are saturated, row by row.
  void TellSaturation(const RememberedBoard& board, std::uint8_t* saturated) const;

  const DetectorOptions& options_;
  /// By family: saturation of the cells of a board without kernel, row by row.
  std::vector<std::vector<std::uint8_t>> borders_;
  // Scratch.
  NeighbourLead neighbours_;
  std::array<float, kMaxCells> leads_{};
};

/// Whether the cells that show are those of the remembered identity, although they are too few to decide it.
bool AgreesWith(const ExpectedBoards::Evidence& evidence);

}  // namespace chequer
