#pragma once

#include <cstddef>
#include <cstdint>

namespace chequer {

/// How the budget of an image is dealt out to the detector's steps: each may begin what it has to do while what was
/// spent, by all steps together, is below its share. What a step does not use is left for those that follow.
class WorkPlan {
 public:
  /// @param budget units; 0: no limit.
  explicit WorkPlan(std::uint64_t budget) : budget_(budget) {}

  bool limited() const { return budget_ > 0; }
  /// The search for boards begins, after fits of those that were expected: what it may take is shared out of the rest,
  /// so that many that were expected leave time to find the others.
  void StartSearch(std::uint64_t spent) { before_search_ = spent; }
  /// Peaks that may be looked at, and linked, in an image of so many pixels.
  std::size_t MostPeaks(double pixels) const;
  /// Units that the first search for boards in grids may go on to; those that are not searched by then wait.
  /// @param reserved for what comes after it and has waited since the image before.
  std::uint64_t MostForBoards(std::uint64_t reserved) const;
  /// Whether a second look that takes so many units at most may be begun. @param waited since the image before: then it
  /// goes before the fits.
  bool MayLookAgain(std::uint64_t spent, std::uint64_t most, bool waited) const;
  /// Units that are left for fits.
  std::uint64_t Left(std::uint64_t spent) const;
  /// The most that a single fit may take. @param plain what a plain fit of the board takes. @param left for it; where
  /// it takes more than others did, it may go a little beyond that.
  std::uint64_t MostForFit(std::uint64_t plain, bool in_full, std::uint64_t left) const;

  /// Units of a full fit, over those of a plain fit of the same board: the least that is worth granting (a guess), and
  /// the most that it takes, which PhotometricFit says.
  static constexpr std::uint64_t kLeastOfPlain = 5, kMostOfPlain = 50;

 private:
  std::uint64_t budget_;
  std::uint64_t before_search_ = 0;
};

}  // namespace chequer
