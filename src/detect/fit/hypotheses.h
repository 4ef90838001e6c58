#pragma once

#include <cstddef>
#include <span>

#include "detect/fit/board_fit.h"

namespace chequer {

/// How a fit of a board is made.
struct Trial {
  BoardFit::Start start;
  BoardFit::Choice choice;

  /// Begins where the last fit has the board.
  void BeginAt(const BoardGeometry& geometry, double dot_gain) {
    start.predicted = false;
    start.geometry = geometry;
    choice.terms.dot_gain = dot_gain;
  }
  void LeaveOut(const CornerFlags& corners, Hidden why) {
    for (int corner = 0; corner < CornerCount(start.size); ++corner)
      if (corners[static_cast<std::size_t>(corner)]) start.visibility.Set(corner, why);
  }
  bool LeavesOut() const { return !start.visibility.ShowsAllCorners(); }
};

/// Something that a board may have, or that may lie in its way, with all that belongs to it. PhotometricFit tries each
/// from the best fit so far.
struct Hypothesis {
  enum class Path {
    kDirect,   ///< It is kept where it is better than the best fit so far.
    kDetour,   ///< Others go on from it, and only what comes of these is compared with the best fit so far.
    kArrival,  ///< It goes on from a detour, and ends it where it is better than both fits.
  };
  struct From {
    const LightReader& reader;
    const Lens& lens;
    const BoardFit::Start& first;  ///< where the board's first fit began
    BoardFit& fit;                 ///< the best so far; it may be changed, as it is kept elsewhere
    const BoardRun& kept;          ///< there, until the trial's fit is done
    ImageTraits& traits;           ///< memory for what the board itself tells of the image
  };

  Path path;
  /// By how much the score must be better: more than other boards gain. 0: only the unknowns count against it. Below 0:
  /// what calls for it tells more of it than the score does.
  double most_by_chance;
  /// Whether the residuals of the best fit so far call for it. @param made how that fit was made.
  bool (*calls)(const BoardFit& fit, const Trial& made);
  /// @param trial how to fit it roughly; comes as the best fit so far was made, from where that has the board. False if
  /// there is nothing to start from.
  bool (*start)(const From& from, Trial& trial);
  /// Whether its fit has what it was begun for; of a detour, asked where it leads no further.
  bool (*holds)(const BoardFit& fit);
};

inline constexpr std::size_t kMostHypotheses = 32;
/// In the order in which they are tried.
std::span<const Hypothesis> Hypotheses();

}  // namespace chequer
