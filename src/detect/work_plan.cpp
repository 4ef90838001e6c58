#include "detect/work_plan.h"

#include <algorithm>
#include <limits>

#include "detect/common/work_meter.h"

namespace chequer {
namespace {

/// Share of the budget that may be spent when a step ends. In good illumination, all steps before the fits take a
/// tenth; the shares matter where endless textures would leave nothing for fits (guesses).
constexpr double kPeaksShare = 0.4, kBoardsShare = 0.6, kSecondLookShare = 0.75, kOneFitShare = 0.25;
/// The share of the budget that a fit may go beyond what is left, once it is begun: to cut it off for less would waste
/// what it has taken (a guess).
constexpr double kBeyondShare = 0.05;
/// Of the first search, if a second look has waited (a guess).
constexpr double kLeastBoardsShare = 0.4;
/// Instructions that a peak leads to, until it is linked, if every other is a corner (a guess).
constexpr double kInstructionsPerPeak = 2000;
/// One peak for so many pixels is always looked at, however small the budget: frames of boards have fewer (a guess).
constexpr double kPixelsPerPeak = 250;

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

}  // namespace

std::size_t WorkPlan::MostPeaks(double pixels) const {
  if (!limited()) return std::numeric_limits<std::size_t>::max();
  const double instructions = kPeaksShare * static_cast<double>(budget_) * WorkMeter::kInstructionsPerUnit -
                              pixels * WorkMeter::Instructions(WorkStep::kPixel);
  return static_cast<std::size_t>(std::max(instructions / kInstructionsPerPeak, pixels / kPixelsPerPeak));
}

std::uint64_t WorkPlan::MostForBoards(std::uint64_t reserved) const {
  if (!limited()) return kNoLimit;
  const std::uint64_t before = std::min(before_search_, budget_);
  const auto share = [&](double of_rest) {
    return before + static_cast<std::uint64_t>(of_rest * static_cast<double>(budget_ - before));
  };
  const std::uint64_t with_reserve = budget_ - std::min(reserved, budget_);
  return std::clamp(with_reserve, share(kLeastBoardsShare), share(kBoardsShare));
}

bool WorkPlan::MayLookAgain(std::uint64_t spent, std::uint64_t most, bool waited) const {
  const double share = waited ? 1 : kSecondLookShare;
  return !limited() || most == 0 || static_cast<double>(spent + most) <= share * static_cast<double>(budget_);
}

std::uint64_t WorkPlan::Left(std::uint64_t spent) const {
  return limited() ? budget_ - std::min(spent, budget_) : kNoLimit;
}

std::uint64_t WorkPlan::MostForFit(std::uint64_t plain, bool in_full, std::uint64_t left) const {
  if (!limited()) return kNoLimit;
  const auto share = [&](double of_budget) {
    return static_cast<std::uint64_t>(of_budget * static_cast<double>(budget_));
  };
  return std::min({in_full ? kMostOfPlain * plain : plain, share(kOneFitShare), left + share(kBeyondShare)});
}

}  // namespace chequer
