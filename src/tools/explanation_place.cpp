#include "tools/explanation_place.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <span>

namespace chequer {
namespace {

/// Places that were not viewed and are told all the same.
constexpr std::size_t kMostIdle = 4;

/// What was searched, as a picture.
Image ViewOf(const TracePlace& place) {
  Image view(PixelFormat::kBgr8, place.side, place.side);
  const std::span<std::uint8_t> bytes = view.bytes();
  for (std::size_t i = 0; i < place.view.size(); ++i)
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, place.view[i]);
  return view;
}

/// Corners and links of one place. @param to from the image to the canvas.
template <typename ToCanvas>
void DrawLook(Canvas& canvas, const DetectTrace& trace, std::size_t index, const ToCanvas& to) {
  const auto place_of = [&](int corner) { return trace.corners[static_cast<std::size_t>(corner)].place; };
  const auto at = [&](int corner) { return to(trace.corners[static_cast<std::size_t>(corner)].position_px); };
  for (const DetectTrace::Link& link : trace.links) {
    if (place_of(link.from) != static_cast<int>(index)) continue;
    const Eigen::Vector2d from = at(link.from), end = at(link.to);
    canvas.Line(from.x(), from.y(), end.x(), end.y(), link.in_square ? kSquareLinkInk : kOpenLinkInk, 1.5);
  }
  for (int corner = 0; corner < static_cast<int>(trace.corners.size()); ++corner) {
    if (place_of(corner) != static_cast<int>(index)) continue;
    canvas.Circle(at(corner).x(), at(corner).y(), 4, kLookInk, 1.5);
  }
}

}  // namespace

std::vector<std::size_t> ToldPlaces(const Explanation& explanation) {
  const std::vector<TracePlace>& places = explanation.trace->places;
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (explanation.region.Holds(places[i].center_px)) told.push_back(i);
  std::stable_sort(told.begin(), told.end(),
                   [&](std::size_t a, std::size_t b) { return places[a].fate < places[b].fate; });
  const auto viewed =
      std::count_if(told.begin(), told.end(), [&](std::size_t i) { return places[i].fate == PlaceFate::kViewed; });
  told.resize(std::min(told.size(), static_cast<std::size_t>(viewed) + kMostIdle));
  return told;
}

std::string DescribePlaces(const Explanation& explanation) {
  std::string text;
  int number = 0;
  for (const std::size_t i : ToldPlaces(explanation)) {
    const TracePlace& place = explanation.trace->places[i];
    text += fmt::format("{:>4} at ({:.0f}, {:.0f}) px: {}\n", fmt::format("P{}", ++number), place.center_px.x(),
                        place.center_px.y(), Explain(place));
  }
  return text.empty() ? text : "places without a board of the first look that are full of contrast:\n" + text;
}

std::string PlaceLabel(const TracePlace& place, int number) {
  if (place.fate != PlaceFate::kViewed) return fmt::format("P{}: not viewed", number);
  if (place.boards == 0) return fmt::format("P{}: no new board", number);
  return fmt::format("P{}: {} board{}", number, place.boards, place.boards > 1 ? "s" : "");
}

void DrawPlacePanel(Canvas& canvas, double left, double top, const Explanation& explanation, std::size_t index,
                    int number) {
  const TracePlace& place = explanation.trace->places[index];
  DrawPanelHead(
      canvas, left, top, kLookInk,
      fmt::format("P{}   second look   at ({:.0f}, {:.0f})", number, place.center_px.x(), place.center_px.y()),
      Explain(place));
  double reach = 4;
  for (const Eigen::Vector2f& corner : place.outline_px)
    reach = std::max(reach, (corner.cast<double>() - place.center_px).cwiseAbs().maxCoeff() + 2);
  const double y = top + kPanelHeight - 10 - kCloseViewSide - 6;
  const PictureScale to = DrawAround(canvas, left + 14, y, explanation.image, place.center_px, reach);
  std::array<Eigen::Vector2d, 4> outline;
  for (std::size_t k = 0; k < 4; ++k) outline[k] = to(place.outline_px[k].cast<double>());
  canvas.Polyline(outline, kLookInk, 2, true);
  canvas.EndClip();

  const double view_left = left + 14 + kCloseViewSide + 26, scale = kCloseViewSide / place.side;
  canvas.Clip(view_left, y, kCloseViewSide, kCloseViewSide);
  const Image view = ViewOf(place);
  canvas.Picture(view.view(), view_left, y, scale);
  const Eigen::Matrix2f view_by_image = place.image_from_view.leftCols<2>().inverse();
  DrawLook(canvas, *explanation.trace, index, [&](const Eigen::Vector2f& pixel) -> Eigen::Vector2d {
    const Eigen::Vector2f in_view = view_by_image * (pixel - place.image_from_view.col(2));
    return Eigen::Vector2d(view_left, y) + scale * (in_view.cast<double>() + Eigen::Vector2d::Constant(0.5));
  });
  canvas.EndClip();
  const double text_left = view_left + kCloseViewSide + 16;
  double text_y = y + 14;
  const auto note = [&](const std::string& text) {
    for (const std::string& line : Wrapped(canvas, text, 12, left + kPanelWidth - 20 - text_left)) {
      canvas.Text(line, text_left, text_y, 12, kPanelInk);
      text_y += 16;
    }
    text_y += 6;
  };
  note("left: where it lies in the image");
  note(fmt::format("right: as it was straightened and searched{}, {} x {} px: a board's cells are about square here",
                   place.views > 1 ? " the second time" : "", place.side, place.side));
  note(fmt::format("{} corners, {} of them in the largest group", place.corners, place.most_linked));
}

}  // namespace chequer
