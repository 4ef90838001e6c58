#pragma once

#include <Eigen/Core>

#include "detect/board_fit.h"
#include "detect/fitted_board.h"
#include "detect/light.h"

namespace chequer {

/// Fits a board by as many joint fits (board_fit.h) as it takes to tell what is in its way: things on it, shadows
/// across it, spread ink, motion. Keeps its memory.
/// A fit is given up where a corner moves by more than 3 px in a step, but in the first one only if those that were
/// found do; a result's last step moved no corner by more than 0.05 px, so that what is left is of second order, or was
/// the eighth.
/// The pose that it leads to is near the Cramér–Rao bound, 0.0025 px for the centre of a board of 8 px cells:
/// side_by_side prints how near, case by case. What no model of a plane knows (bent paper, what is left of the lens)
/// widens the information instead. 24 µs a board of 7.8 px cells, growing with its pixels.
/// Where the light is bent, or cells are small against the blur, the pixels' light is corrected between the steps
/// (shading.h, far_cells.h): up to 0.5 ms; where ink has spread, so are their places: 2 to 10 ms.
/// Where corners turn out to be hidden it is fitted anew without them: two to six times the time. Where lights on it
/// differ, it is fitted with levels for each corner's quadrants, and then with the edge of the shadow that these tell
/// of (shadow_edge.h): 2 to 10 ms, 5 to 30 ms where light of cells beyond is taken out, too.
class PhotometricFit {
 public:
  struct Start {
    BoardFit::Start board;
    /// It was found where the image is smeared; or, if it seems blurred, that may be tried: about 20 ms where it is so.
    bool smeared = false, may_be_smeared = false;
  };

  /// Nothing if the board lies outside the image for the most part, does not look like the model, or the fit runs away.
  /// The result is valid until the next call.
  const FittedBoard* Fit(const LightReader& reader, const Lens& lens, const Start& start);

 private:
  /// What all fits of a board have in common.
  struct Task {
    const LightReader& reader;
    const Lens& lens;
    const BoardFit::Start& start;
  };

  const FittedBoard* FitAsItIs(const Task& task, const Eigen::Vector2d& smear_px);
  /// By choice_, from where the result has the board.
  bool FitAnew(const Task& task);

  // Without corners that something hides: fit_hidden.cpp.
  /// What hides corners has told the light, the levels and the noise before it was known to: fits anew without them.
  void LeaveOutHidden(const Task& task);
  /// Of the corners that were found hidden, those that fit worst. False if none was.
  bool LeaveOutWorstHidden();
  /// What covers a whole side may pull the board until all corners are off, and none so much more than the others that
  /// it is found hidden. Whether it was so.
  bool LeaveOutSide(const Task& task);

  // With lights of their own: fit_uneven.cpp.
  /// Whether some corner fits so badly, or corners lie so far off where light cells differ, that the edge of a shadow
  /// may cross the board.
  bool MayBeUnevenlyLit(const Task& task) const;
  /// Where it crosses cells, they have no one level: fits anew with levels for each corner's quadrants, and by these
  /// with the shadow's edge, if that explains the board better. Whether it does.
  bool FitUnevenlyLit(const Task& task);
  /// The same with the edge of one shadow, as the quadrants' levels tell it. @pre those were fitted. Whether it is one.
  bool FitShadow(const Task& task);

  BoardFit fit_;
  BoardFit::Choice choice_;
  FittedBoard before_, evenly_lit_, own_levels_, best_;  ///< what a fit is compared with
};

}  // namespace chequer
