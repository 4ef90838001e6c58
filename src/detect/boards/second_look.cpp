#include "detect/boards/second_look.h"

#include <utility>

#include "detect/boards/strong_points.h"

namespace chequer {
namespace {

/// Most pixels this near to a point of a board belong to the board, px (a guess).
constexpr float kSeedPx = 14;
/// Smaller cells do not show even in a view of the largest zoom, where they are 3.5 px high. Such points lie along a
/// line.
constexpr float kLeastCellPx = 3.5f / PlaceView::kMostZoom;
/// The first look finds boards that are less slanted than this and whose cells are wider, px (guesses; cells below 4 px
/// have no ring response).
constexpr float kLeastSlant = 1.8f, kMostCellPx = 4.5f;
/// Fewest points of a place with wide cells. Such a board leaves a point at every corner; chance gathers fewer (a
/// guess).
constexpr int kFewestOfWide = 18;
/// Places that are considered, and among them places with few points, as in images without clutter (guesses).
constexpr int kMostPlaces = 6, kMostSparse = 2;
/// Least ink along a place whose points show ink. Less may be cells of one ink that lie there by chance (a guess).
constexpr float kLeastInkAlong = 0.35f;

/// Places that a trace lists. Most of them are not viewed (a guess).
constexpr std::size_t kMostTold = 12;
/// Half the side of a board of six.
constexpr float kHalfSideCells = 3;

/// Whether the first look may have missed a board there.
bool MayHaveEscaped(const Place& place) {
  return place.cell_px() < kMostCellPx || place.spread[0] > kLeastSlant * place.spread[1];
}

}  // namespace

std::uint64_t SecondLook::MostUnits() const {
  const std::uint64_t instructions = image_->points.MostInstructions(kMostPlaces);
  return instructions == 0 ? 0 : instructions / WorkMeter::kInstructionsPerUnit + kMostLooks * kMostUnitsOfLook;
}

void SecondLook::Start(const LightReader& reader, std::span<const StrongPoint> points, float least,
                       std::span<const PixelBox> boards, std::vector<TracePlace>* trace) {
  image_.Start().trace = trace;
  image_->points.Start(reader.width(), reader.height(), points, least, boards);
}

std::optional<Place> SecondLook::FindPlace() {
  std::optional<Place> place = image_->points.FindPlace(image_->work);
  if (!place || !StrongPoints::IsTooLarge(*place)) return place;
  NotePlace(*place, PlaceFate::kTooLarge);
  place->count = 0;
  return place;
}

PlaceFate SecondLook::Judge(const Place& place) {
  if (place.count < StrongPoints::kFewest) return PlaceFate::kFewPoints;
  if (!MayHaveEscaped(place)) return PlaceFate::kFrontal;
  if (place.cell_px() < kLeastCellPx) return PlaceFate::kLine;
  return place.cell_px() >= kMostCellPx && place.count < kFewestOfWide ? PlaceFate::kSparse : PlaceFate::kViewed;
}

std::optional<Place> SecondLook::FindChange(const Pyramid& pyramid, const LightReader& reader, const Place& points) {
  const std::span<const Eigen::Vector2f> members = image_->points.members();
  InkSigns at_points, along_it;
  image_->work.Add(WorkStep::kInkProbe, members.size() + 5);
  image_->work.Add(WorkStep::kPlace);
  for (const Eigen::Vector2f& point : members) at_points.Add(reader, point);
  if (!at_points.AreThere()) return std::nullopt;
  std::optional<Place> place = PlaceOfChange(pyramid.base.plane, pyramid.FromImage(points.middle, 0), kSeedPx);
  if (!place || !MayHaveEscaped(*place)) return std::nullopt;
  place->middle = pyramid.ToImage(place->middle, 0);
  place->count = points.count;
  for (const float share : {-1.0f, -0.5f, 0.0f, 0.5f, 1.0f})
    along_it.Add(reader, place->middle + share * place->spread[0] * place->axes.col(0));
  return along_it.AreThere(kLeastInkAlong) ? place : std::nullopt;
}

bool SecondLook::LookByChange(const Pyramid& pyramid, const LightReader& reader, const Place& points) {
  const std::optional<Place> place = FindChange(pyramid, reader, points);
  if (!place) return false;
  NotePlace(*place, PlaceFate::kViewed);
  if (noted()) noted()->by_change = true;
  image_->points.Forget(*place, image_->work);
  view_.Straighten(pyramid, *place, image_->work, noted());
  if (!view_.ShowsBoard()) view_.Sharpen(pyramid, *place, image_->work, noted());
  return true;
}

void SecondLook::CountBoard() {
  --image_->looks;
  --image_->places;
}

bool SecondLook::MayGoOn() const {
  return image_->unclear || (image_->looks < kMostLooks && image_->places < kMostPlaces && !image_->points.empty());
}

bool SecondLook::LookAt(const Pyramid& pyramid, const LightReader& reader, const Place& place) {
  const PlaceFate fate = Judge(place);
  const bool frontal = fate == PlaceFate::kFrontal, by_points = frontal || fate == PlaceFate::kViewed;
  if (by_points) NotePlace(place, fate);
  bool viewed = frontal && view_.UndoMotionBlur(pyramid, place, image_->work, noted());
  // No motion, and the first look found no board: without any blur, pixels of slanted cells of some 5 px show some
  // corners twice and others not at all.
  const bool coarse = frontal && !viewed && place.count >= kFewestOfWide;
  if (coarse || fate == PlaceFate::kViewed) {
    view_.Straighten(pyramid, place, image_->work, noted());
    viewed = true;
  }
  if (fate != PlaceFate::kFewPoints) image_->points.Forget(place, image_->work);
  // Where points tell too little of a place, its pixels may tell more.
  if (viewed && !view_.ShowsBoard()) image_->unclear = place;
  if (!viewed && (fate != PlaceFate::kFewPoints || ++image_->sparse <= kMostSparse))
    viewed = LookByChange(pyramid, reader, place);
  if (!by_points && !viewed) NotePlace(place, fate);
  // Where there is print, there are many lines.
  image_->looks += viewed || fate == PlaceFate::kLine;
  return viewed;
}

bool SecondLook::Next(const Pyramid& pyramid, const LightReader& reader) {
  image_->points.ThinOut(reader, image_->work);
  if (image_->unclear && LookByChange(pyramid, reader, *std::exchange(image_->unclear, std::nullopt))) return true;
  while (image_->looks < kMostLooks && image_->places < kMostPlaces) {
    const std::optional<Place> place = FindPlace();
    if (!place) return false;
    ++image_->places;
    if (place->count > 0 && LookAt(pyramid, reader, *place)) return true;
  }
  NoteTheRest();
  return false;
}

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
