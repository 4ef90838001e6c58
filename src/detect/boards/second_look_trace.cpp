// What the second look says of the places that it considers; runs only where somebody asks.
#include "detect/boards/second_look.h"

namespace chequer {
namespace {

/// Places are told on to that many where no more are viewed.
constexpr std::size_t kMostTold = 12;
/// Half the side of a board of six.
constexpr float kHalfSideCells = 3;

/// Round what lies up to `reach` away from a middle along two axes.
std::array<Eigen::Vector2f, 4> Around(const Eigen::Vector2f& middle, const Eigen::Matrix2f& axes,
                                      const Eigen::Vector2f& reach) {
  const Eigen::Vector2f along = axes.col(0) * reach[0], across = axes.col(1) * reach[1];
  return {middle - along - across, middle + along - across, middle + along + across, middle - along + across};
}

}  // namespace

void SecondLook::NotePlace(const Place& place, PlaceFate fate) {
  TracePlace told;
  told.fate = fate;
  told.center_px = place.middle.cast<double>();
  told.outline_px = Around(place.middle, place.axes, kHalfSideCells / kSpreadCells * place.spread);
  told.points = place.count;
  told.cell_px = static_cast<double>(place.spread[1] / kSpreadCells);
  told.slant = static_cast<double>(place.spread[0] / place.spread[1]);
  image_->trace->push_back(std::move(told));
}

void SecondLook::NoteView(const Place& place, const Eigen::Matrix2f& image_by_view) {
  TracePlace& told = image_->trace->back();
  const BytePlane& plane = shown_->view.plane;
  told.center_px = place.middle.cast<double>();
  told.side = plane.width();
  ++told.views;
  told.view.clear();
  for (int y = 0; y < plane.height(); ++y) told.view.insert(told.view.end(), plane.row(y), plane.row(y) + told.side);
  const Eigen::Vector2f half = Eigen::Vector2f::Constant(0.5f * static_cast<float>(told.side - 1));
  told.image_from_view << image_by_view, place.middle - image_by_view * half;
  told.outline_px = Around(place.middle, image_by_view, half + Eigen::Vector2f::Constant(0.5f));
}

void SecondLook::NoteTheRest() {
  while (image_->trace->size() < kMostTold) {
    const std::optional<Place> place = FindPlace();
    if (!place) return;
    if (place->count == 0) continue;
    const PlaceFate fate = Judge(*place);
    NotePlace(*place, fate == PlaceFate::kViewed ? PlaceFate::kTooMany : fate);
    Forget(*place);
  }
}

}  // namespace chequer
