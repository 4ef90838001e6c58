#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "chequer/hidden.h"
#include "chequer/marker.h"
#include "detect/common/fixed_vector.h"

namespace chequer {

/// What shows of a board, by cell and by inner corner, and why the rest does not. Begun where a board is found or
/// expected, by the contrast of its cells; the fit adds the corners that its model does not explain, and lets cells
/// follow them; the identification adds cells of a wrong contrast or colour.
class Visibility {
 public:
  Visibility() = default;
  /// All of it shows.
  explicit Visibility(MarkerSize size);

  bool Shows(std::size_t cell) const { return cells_[cell] == Hidden::kNot; }
  bool ShowsCorner(int corner) const { return OfCorner(corner) == Hidden::kNot; }
  /// Row by row.
  std::span<const Hidden> cells() const { return {cells_.data(), cells_.size()}; }
  std::span<const Hidden> corners() const { return {corners_.data(), corners_.size()}; }
  Hidden OfCorner(int corner) const { return corners_[static_cast<std::size_t>(corner)]; }
  int hidden_cells() const { return hidden_cells_; }
  int CountCorners() const { return CornerCount(size_) - hidden_corners_; }  ///< that show
  bool ShowsAll() const { return hidden_cells_ == 0; }
  bool ShowsAllCorners() const { return hidden_corners_ == 0; }

  /// A cell keeps the first reason.
  void Hide(std::size_t cell, Hidden why) {
    if (Shows(cell)) cells_[cell] = why, ++hidden_cells_;
  }
  void Set(int corner, Hidden why) {
    hidden_corners_ += int{why != Hidden::kNot} - int{!ShowsCorner(corner)};
    corners_[static_cast<std::size_t>(corner)] = why;
  }
  /// Cells that hidden ones enclose (neighbours.h).
  void HideEnclosed();
  void HideCellsBeside(int corner);
  /// Whether the cells beside a cell show, and the corners around it.
  bool ShowsAround(int row, int col) const;
  /// Whether a cell around a corner is hidden: what hides it may lie over the corner's pixels, too.
  bool LiesBesideHidden(int corner) const;
  /// Cells follow what was found of the corners around them: one shows if all of them do, so that nothing else shines
  /// into it, … Whether one shows now that was hidden, or the reverse.
  bool ShowCellsByAllCorners();
  /// … or if one of them does, so that it is seen at all.
  bool ShowCellsByAnyCorner();
  /// As an earlier fit of the board had them.
  void TakeCellsOf(const Visibility& earlier) {
    cells_ = earlier.cells_;
    hidden_cells_ = earlier.hidden_cells_;
  }

 private:
  /// @param follows whether a cell shows, by how many of the corners around it do, and how many there are.
  template <class Follows>
  bool ShowCells(const Follows& follows);
  void Show(std::size_t cell) {
    hidden_cells_ -= int{!Shows(cell)};
    cells_[cell] = Hidden::kNot;
  }

  MarkerSize size_;
  FixedVector<Hidden, kMaxCells> cells_;
  FixedVector<Hidden, kMaxCorners> corners_;
  int hidden_cells_ = 0, hidden_corners_ = 0;
};

}  // namespace chequer
