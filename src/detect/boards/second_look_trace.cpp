// What the second look says of the places that it considers; runs only where somebody asks.
#include "detect/boards/second_look.h"

namespace chequer {
namespace {

/// Places that a trace lists. Most of them are not viewed (a guess).
constexpr std::size_t kMostTold = 12;
/// Half the side of a board of six.
constexpr float kHalfSideCells = 3;

}  // namespace

void SecondLook::NotePlace(const Place& place, PlaceFate fate) {
  if (!image_->trace) return;
  TracePlace told;
  told.fate = fate;
  told.center_px = place.middle.cast<double>();
  told.outline_px = OutlineAround(place.middle, place.axes, kHalfSideCells / kSpreadCells * place.spread);
  told.points = place.count;
  told.cell_px = static_cast<double>(place.spread[1] / kSpreadCells);
  told.slant = static_cast<double>(place.spread[0] / place.spread[1]);
  image_->trace->push_back(std::move(told));
}

void SecondLook::NoteTheRest() {
  if (!image_->trace) return;
  while (image_->trace->size() < kMostTold) {
    const std::optional<Place> place = FindPlace();
    if (!place) return;
    if (place->count == 0) continue;
    const PlaceFate fate = Judge(*place);
    NotePlace(*place, fate == PlaceFate::kViewed ? PlaceFate::kTooMany : fate);
    image_->points.Forget(*place, image_->work);
  }
}

}  // namespace chequer
