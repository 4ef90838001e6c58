#include "detect/region_choice.h"

#include <algorithm>
#include <span>

namespace chequer {
namespace {

/// How far around a lost board is searched, as a share of its side. A robot that brakes or turns as hard as it can
/// moves by a tenth within a frame, one that is pushed by as much again (a guess with a margin).
constexpr float kLostReach = 0.6f;

/// Whether a part of the box lies in one of the regions.
bool AnyReaches(std::span<const SearchRegion> regions, const PixelBox& box) {
  return std::any_of(regions.begin(), regions.end(), [&](const SearchRegion& region) {
    const float left = static_cast<float>(region.x), top = static_cast<float>(region.y);
    return box.right >= left && box.left <= left + static_cast<float>(region.width) && box.bottom >= top &&
           box.top <= top + static_cast<float>(region.height);
  });
}

/// What was read lies there, in the regions: nothing else does.
void MarkKnown(const ImageJob& job, const SearchRegions& regions) {
  ImageState& frame = job.frame;
  if (regions.regions().empty()) return;
  for (std::size_t i = 0; i < frame.outcomes.size(); ++i) {
    const bool known = frame.IsExpected(i) ? frame.WasRead(i) : frame.outcomes[i].is_read();
    if (known && AnyReaches(regions.regions(), frame.boards[i].box))
      frame.known.Add(OutlineOf(frame.boards[i].size, frame.outcomes[i].plane_from_board, job.lens));
  }
}

}  // namespace

void SearchAround(PixelBox box, SearchRegions& regions) {
  box.Widen(kLostReach);
  regions.Add(box);
}

int BandsOf(const DetectorOptions& options) { return std::min(options.search_every, SearchRegions::kMostBands); }

void ChooseRegions(const ImageJob& job, const MemoryState* memory) {
  ImageState& frame = job.frame;
  const std::size_t expected = frame.expected.size();
  // Where most boards are lost, it is another picture: a cut, or a camera that was turned.
  if (!memory || !memory->filled || job.options.search_every == 1 || 2 * frame.stream.lost.size() > expected ||
      2 * frame.stream.missing > expected) {
    frame.regions.AddAll();
  } else {
    const int bands = BandsOf(job.options);
    for (int band = 0; band < bands; ++band)
      if (memory->HasTurn(band, bands, job.options.search_every, frame.stream.frames_on))
        frame.regions.AddBand(band, bands);
    for (const OpenPlace& place : memory->open) SearchAround(place.box, frame.regions);
    frame.regions.Merge();
  }
  MarkKnown(job, frame.regions);
}

bool ChooseGivenUp(const ImageJob& job) {
  ImageState& frame = job.frame;
  frame.given_up.Start(frame.regions.width(), frame.regions.height());
  if (frame.regions.is_all()) return false;
  const std::vector<std::size_t>& lost = frame.stream.lost;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) {
    const BoardOutcome& outcome = frame.outcomes[i];
    // Without an id, and where what shows is not the remembered one's, a fit may have slid along the pattern.
    const bool found = outcome.accepted && (outcome.marker.id || outcome.expected.agrees);
    if (found || outcome.deferred || frame.ReadElsewhere(i) || std::find(lost.begin(), lost.end(), i) != lost.end())
      continue;
    SearchAround(frame.boards[i].box, frame.given_up);
  }
  frame.given_up.Merge();
  MarkKnown(job, frame.given_up);
  return !frame.given_up.regions().empty();
}

}  // namespace chequer
