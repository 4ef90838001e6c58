#include "daemon/hints.h"

#include <algorithm>
#include <string>
#include <utility>

namespace chequer {
namespace {

/// After so many frames kernels are gathered anew: the prints may have been changed. About a minute.
constexpr int kForgetAfter = 60;

}  // namespace

Hints::Hints(const std::vector<MarkerFamily>& families) {
  for (const MarkerFamily& family : families) families_.push_back({family, VariantGuess(family.code)});
}

void Hints::Count(std::string_view name, std::uint64_t more) {
  if (more == 0) return;
  const std::string full = std::string(kHintPrefix).append(name);
  const auto known =
      std::find_if(counts_.begin(), counts_.end(), [&](const NamedCount& count) { return count.name == full; });
  if (known != counts_.end())
    known->count += more;
  else
    counts_.push_back({full, more});
}

void Hints::TakePicture(const FrameLook& look) {
  if (look.mirrored > 0) Count("mirrored", static_cast<std::uint64_t>(look.mirrored));
  if (!look.picture || look.mirrored > 0) return;
  if (look.picture->IsBlack()) return Count("black");
  if (look.picture->IsWhite()) return Count("white");
  if (look.picture->IsBlank()) return Count("no_contrast");
  if (look.picture->Blur()) return Count("blurred");
  Count(look.borderless > 0 ? "no_border" : "no_board");
}

void Hints::Take(const FrameLook& look) {
  if (++looks_ > kForgetAfter) {
    looks_ = 1;
    for (Family& family : families_) family.guess.Clear();
  }
  TakePicture(look);
  for (const FrameLook::Kernel& seen : look.kernels) {
    Family& family = families_.at(static_cast<std::size_t>(seen.family));
    family.guess.Add(seen.kernel);
    if (seen.has_id || family.sought.roster.empty()) continue;
    const auto word = family.sought.code.DecodeHard(seen.kernel);
    const std::vector<std::uint64_t>& roster = family.sought.roster;
    if (word && word->bits_corrected == 0 && std::find(roster.begin(), roster.end(), word->id) == roster.end())
      Count("outside_roster");
  }
}

std::vector<NamedCount> Hints::TakeCounts() {
  for (const Family& family : families_)
    if (const auto other = family.guess.LooksLike())
      Count(std::string("looks_like_").append(VariantName(*other)), family.guess.count());
  return std::exchange(counts_, {});
}

}  // namespace chequer
