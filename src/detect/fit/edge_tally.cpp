#include "detect/fit/edge_tally.h"

#include <algorithm>
#include <cmath>

#include "detect/common/widened.h"

namespace chequer {
namespace {

/// Of what may be chance, so many deviations are left out: of boards whose errors are noise, one in 20 would have more
/// (a guess).
constexpr double kDeviationsOfChance = 2;

/// The variance of such errors over what fits leave of it in the residuals: where a board has its own alone, and that
/// of others (measured: JPEG of quality 50 to 90; JPEG of 75 to 95, sharpening, demosaicing). With the first, boards
/// whose corners lie alike have squared errors of .2 to 1.6 where images are sharpened, demosaiced or median filtered,
/// .7 to 1.2 where they are enlarged.
constexpr double kOfOwnLeft = 2, kOfOthersLeft = 1.2;

/// A covariance that changes by a smaller share, summed over all directions, is not told anew: standard deviations
/// change by less than half of that (a guess).
constexpr double kLeastChange = 0.1;

}  // namespace

void EdgeTally::Add(const AlikeEdges& edges, double pixel_variance) {
  for (const AlikeEdges::Group& group : edges.errors)
    for (const EdgeErrors& errors : group) {
      scores += double{errors.score} * double{errors.score} / pixel_variance;
      information += double{errors.information};
      squares += double{errors.information} * double{errors.information};
    }
}

void EdgeTally::Add(const EdgeTally& other) {
  scores += other.scores;
  information += other.information;
  squares += other.squares;
}

void EdgeTally::Forget(double share_left) {
  scores *= share_left;
  information *= share_left;
  squares *= share_left * share_left;
}

double EdgeTally::More() const {
  const double more = scores / std::max(information, 1e-300) - 1;
  if (!(more > 0)) return 0;
  // The square of a normal deviate has a variance of 2.
  const double of_chance = kDeviationsOfChance * kDeviationsOfChance * 2 * squares / (information * information);
  // What pixels share grows with their number.
  return AlikeEdges::kStride * std::max(more - of_chance / more, 0.0);
}

double EdgeTally::MoreOf(const EdgeTally& own) const {
  const double own_share = own.information / std::max(information, 1e-300);
  return (kOfOthersLeft + own_share * (kOfOwnLeft - kOfOthersLeft)) * More();
}

std::optional<BoardGeometry::Information> SharedEdgeErrors::Recounted(const BoardGeometry::Information& information,
                                                                      const EdgeTally& all) const {
  const double changed = all.MoreOf(own) - counted;
  if (!(std::abs(changed) * information.cwiseProduct(covariance).sum() > kLeastChange)) return std::nullopt;
  return WidenedBy(information, changed * covariance);
}

}  // namespace chequer
