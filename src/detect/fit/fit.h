#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>

#include "detect/common/light.h"
#include "detect/fit/board_fit.h"
#include "detect/fit/fitted_board.h"
#include "detect/fit/hypotheses.h"
#include "detect/fit/weak_bend.h"  // for those who find poses

namespace chequer {

/// Fits a board by as many joint fits (board_fit.h) as it takes to tell what is in its way: things on it, shadows
/// across it, spread ink, motion. Keeps its memory.
/// A fit is given up where a corner moves by more than 3 px in a step, but in the first one only if those that were
/// found do; a result's last step moved no corner by more than 0.05 px, so that what is left is of second order, or was
/// the eighth.
/// The pose that it leads to is near the Cramér–Rao bound, 0.0025 px for the centre of a board of 8 px cells:
/// side_by_side prints how near, case by case. What no model of a plane knows (bent paper, what is left of the lens)
/// widens the information instead. 24 µs a board of 7.8 px cells, growing with its pixels.
/// Where the light is bent, or cells are small against the blur, or the board moved, the model with all its terms is
/// fitted (model_kernel.h): as many instructions as 5 to 10 sharp boards take, whatever the board's size, as so many of
/// its pixels are looked at at most. Where corners turn out to be occluded it is fitted anew without them: two to six
/// times the time. Where lights on it differ, it is fitted with levels for each corner's quadrants, and then with the
/// edge of the shadow that these tell of (shadow_edge.h): 10 to 20 sharp boards, also where it is blurred and there is
/// dot gain; 50 at most.
class PhotometricFit {
 public:
  struct Start {
    BoardFit::Start board;
    /// It was found where the image is blurred by motion.
    bool motion_blurred = false;
    /// How it moved during the exposure, as others of the image show; zero if they do not.
    BlurShape motion{};
    /// No other fit of the board is begun once so many units (work_meter.h) are spent; what there is by then is
    /// returned. Nor is one begun, in any case, once a board has taken 90,000 for 25 corners.
    std::uint64_t most_units = ~0ull;
    /// Only the plain fit is done: no motion, dot gain, shadow, or occlusion is looked for.
    bool plain_only = false;
    /// It was expected there, and is searched for where the plain model does not come near it.
    bool may_lie_elsewhere = false;
  };

  /// Nothing if the board lies outside the image for the most part, does not look like the model, or the fit runs away.
  /// The result is valid until the next call.
  const FittedBoard* Fit(const LightReader& reader, const Lens& lens, const Start& start);
  /// BoardFit::UseLearntLevels() on what Fit() has returned, where nothing is left undone. Then work() is what that
  /// took.
  bool UseLearntLevels(const FittedBoard& fitted, LearntBoard& learnt);
  /// Another step from what Fit() has returned where the last one was long: more than enough for a pose, but what
  /// corners are off by is that of before it, up to a standard deviation of theirs. Whether it did; then work() is what
  /// that took.
  bool StepOn(const LightReader& reader, const Lens& lens, const FittedBoard& fitted);
  /// Fits the pose of what Fit() has returned again without the corners beside cells that are not the board's, as their
  /// colours showed once they were read, if some are used and Start::most_units are not spent. The cells stay as they
  /// were read. Then work() is what that took. @pre no other call since Fit().
  void FitWithout(const LightReader& reader, const Lens& lens, const FittedBoard& fitted, const Visibility& shows);
  /// Whether the last fit was plain only and left something undone that may change its result.
  bool wants_more() const { return wants_more_; }
  /// Whether the last one was given up for that.
  bool lies_elsewhere() const { return lies_elsewhere_; }
  /// Whether the last one ended before all was tried that might explain the board better, for want of units.
  bool cut_short() const { return cut_short_; }
  /// What the last fit took.
  const WorkMeter& work() const { return fit_.work(); }
  std::uint64_t units() const { return fit_.work().units(); }

 private:
  /// What all fits of a board have in common.
  struct Task {
    const LightReader& reader;
    const Lens& lens;
    const BoardFit::Start& start;
  };
  /// By number.
  using Tried = std::bitset<kMostHypotheses>;
  /// A fit that may be gone back to.
  struct Kept {
    BoardRun run;
    Trial made;
    Tried tried;
    const Hypothesis* left_for = nullptr;
  };
  using Compare = bool (*)(const Explained&, const Explained&, double most_by_chance);

  /// Whether fit_ still has what Fit() has returned, and nothing was left undone.
  bool HasAllOf(const FittedBoard& fitted) const { return &fitted == &fit_.result() && !wants_more_ && !cut_short_; }
  const FittedBoard* FitFully(const Task& task, const Start& start);
  const FittedBoard* FitPlain(const Task& task, bool motion_blurred);
  const FittedBoard* FitFrom(const Task& task, const BlurShape& motion);
  /// Without what only some boards have, but what the image's others taught; roughly, where all terms may be on.
  bool FitFirst(const Task& task, const BlurShape& motion, bool may_move);
  /// As made_ has it. False if it fails, or if the units are spent.
  bool FitOnce(const Task& task);
  /// The one loop: tries what the residuals of the best fit so far call for, until nothing does.
  bool Explain(const Task& task);
  /// The first hypothesis that the fit calls for and that was not tried from it; else their number.
  std::size_t FindNext() const;
  void Try(const Task& task, std::size_t hypothesis);
  /// Whether the fit is better than the last ones that were kept.
  bool Beats(int others, Compare better, double most_by_chance) const;
  /// Whether it is worth to end the detour with it.
  bool Holds() const;
  void GoBack();
  /// Refits the pose; the cells stay as they were read. Whether refit(run before it) did; else all is as it was before.
  template <class Refit>
  bool TryRefit(Kept& before, const Refit& refit);
  bool AnyUsedBesideHidden(const Visibility& shows) const;
  /// Once a board is explained: refits its pose without what pulls it, and tells what that leaves open.
  void Finish(const Task& task);
  /// An occlusion may pull the corners beside it. Refits the pose without them.
  void LeaveOutPulled(const Task& task);
  /// What hides corners may lie on a part of the pixels beside them, too, and take the board along: refits the pose
  /// without these.
  void KeepOffWhatHides(const Task& task);

  bool wants_more_ = false, cut_short_ = false, lies_elsewhere_ = false;
  std::uint64_t most_units_ = 0;
  BoardFit fit_;
  Trial made_;   ///< how
  Tried tried_;  ///< from there
  // Memory: set before they are read. Three detours, each begun on the one before, and a trial.
  std::array<Kept, 4> kept_;
  int kept_count_ = 0;
  ImageTraits traits_;
  FittedBoard best_;
};

}  // namespace chequer
