#pragma once

#include <span>
#include <vector>

#include "chequer/detect_trace.h"
#include "detect/boards/boards.h"
#include "detect/fit/fit.h"
#include "detect/grids/grids.h"
#include "detect/identity/marker_description.h"

namespace chequer {

/// Writes down what the stages saw; does nothing, at the cost of a comparison, where nobody asked. The detector's
/// threads may trace different boards at once.
class Tracer {
 public:
  /// @param trace may be null.
  explicit Tracer(DetectTrace* trace);
  explicit operator bool() const { return trace_ != nullptr; }

  /// Where the corner stage puts the peaks that it refuses; null if nobody asked.
  std::vector<Eigen::Vector2f>* refused_peaks() { return trace_ ? &trace_->refused_peaks_px : nullptr; }
  /// What follows is seen in the image itself, not in a second look.
  void StartSearch() { place_ = -1; }
  /// Corners, links, and the groups that are too small to be grids.
  void Linked(const std::vector<Corner>& corners, const GridLinker& linker, const Grids& grids);
  /// Where the search for boards in the next grid puts the attempt that comes farthest; null if nobody asked.
  TraceCandidate* StartGrid();
  /// The search has ended. Grids with boards are told by their boards.
  void EndGrid(std::span<const LatticeCorner> members, bool found);
  /// Where the second look puts the places that it considers; null if nobody asked.
  std::vector<TracePlace>* places() { return trace_ ? &trace_->places : nullptr; }
  /// The place that was told last has been viewed: its corners, links and small groups. @param boards known before.
  void StartLook(const SecondLook& look, std::size_t boards);
  /// The look that was started last shows a known board better.
  void Replace(std::size_t board);
  /// @param boards known by now.
  void EndLook(std::size_t boards);
  /// These boards are all that are anchored by now; those that were anchored before come first.
  void Anchored(std::span<const AnchoredBoard> boards, const Lens& lens, ColorSpace space);
  /// What became of the boards that were expected, and by how much all lay elsewhere.
  void Expected(std::vector<TraceExpected> expected, const Eigen::Vector2d& shift_px);
  /// The search is over: what is no board follows the boards.
  void EndSearch();

  /// A board is refused.
  void Refuse(std::size_t board, Refusal why, double measured = 0, double required = 0);
  /// A board has been read: replaces its cells.
  void Read(std::size_t board, const FittedBoard& fitted, const Identity& identity, const Identifier& identifier,
            const Lens& lens);
  void Accept(std::size_t board, int marker);

 private:
  DetectTrace* trace_;
  TraceCandidate attempt_;
  std::vector<TraceCandidate> groups_;  ///< that are no boards
  int place_ = -1;                      ///< that is looked at; -1 in the first look
  int first_corner_ = 0;                ///< of this look, in the trace
  std::vector<int> place_of_board_;
};

}  // namespace chequer
