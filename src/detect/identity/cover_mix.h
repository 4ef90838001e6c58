#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "detect/identity/cell_inks.h"

namespace chequer {

/// What covers a part of a board may lie over a part of cells that show, too. Their light is a mix then, in which one
/// ink looks like the other: under a brown cover, half a blue cell is as colourless as a black one, but as light as
/// neither. Reads such cells by all of their light, as the mix of either ink with the cover that it is nearest to.
class CoverMix {
 public:
  /// Measures the light of the inks, by the border's cells that show, as do all around them.
  /// @param cells must outlive it. @param white light of its white cells.
  CoverMix(const ShownCells& cells, const Eigen::Vector3f& white);
  /// Of what a cell may be, what tells least: by its own light alone, or if a part of it is that of any hidden cell of
  /// its row or column. @param lead CellInks::LeadOf(); what is returned is such a one, of the same sign or 0.
  double LeastLead(int row, int col, double lead) const;

 private:
  /// Of white's.
  Eigen::Vector3f LightOf(std::size_t cell) const { return cells_.lights.light[cell].cwiseQuotient(white_); }

  const ShownCells& cells_;
  const Eigen::Vector3f white_{0, 0, 0};
  struct Inks {
    std::array<Eigen::Vector3f, 2> light{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};  ///< plain, saturated
    double apart = 0;  ///< squared distance of the two; 0: they are not told
  };
  std::array<Inks, 2> inks_;  ///< of light cells, of dark ones
};

}  // namespace chequer
