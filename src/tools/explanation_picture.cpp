#include "tools/explanation_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tools/explanation_place.h"
#include "tools/label_layout.h"

namespace chequer {
namespace {

constexpr Ink kDarkBar{0.13, 0.14, 0.16}, kPaleLetters{0.93, 0.93, 0.93};
constexpr Ink kPeak{1, 1, 1, 0.75}, kPeakRim{0, 0, 0, 0.6}, kCorner{0, 0.85, 1};

/// A name for something in the picture.
struct Label {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< the middle of its upper edge, if nothing else lies there
  std::string text;
  Ink ink;
};

/// A pixel of the image, in picture pixels, within sensible bounds: marks do not grow with the pixels for ever.
double UnitOf(const PictureScale& to) { return std::clamp(to.scale, 1.0, 4.0); }

void DrawStages(Canvas& canvas, const PictureScale& to, const DetectTrace& trace) {
  const double unit = UnitOf(to);
  for (const Eigen::Vector2f& peak : trace.refused_peaks_px) {
    const Eigen::Vector2d at = to(peak.cast<double>());
    canvas.Disc(at.x(), at.y(), 0.55 * unit, kPeakRim);
    canvas.Disc(at.x(), at.y(), 0.35 * unit, kPeak);
  }
  for (const bool in_square : {false, true})
    for (const DetectTrace::Link& link : trace.links) {
      if (link.in_square != in_square) continue;
      const Eigen::Vector2d from = to(trace.corners[static_cast<std::size_t>(link.from)].position_px.cast<double>()),
                            end = to(trace.corners[static_cast<std::size_t>(link.to)].position_px.cast<double>());
      canvas.Line(from.x(), from.y(), end.x(), end.y(), in_square ? kSquareLinkInk : kOpenLinkInk, 0.4 * unit);
    }
  for (const DetectTrace::Corner& corner : trace.corners) {
    const Eigen::Vector2d at = to(corner.position_px.cast<double>());
    // Of the second look smaller, so that the first look's at the same place still shows.
    const double radius = corner.place >= 0 ? 0.7 : 0.7 + 0.4 * corner.scale;
    canvas.Circle(at.x(), at.y(), radius * unit, corner.place >= 0 ? kLookInk : kCorner, 0.35 * unit);
  }
}

void DrawPlaces(Canvas& canvas, const PictureScale& to, const Explanation& explanation, std::vector<Label>& labels) {
  int number = 0;
  for (const std::size_t i : ToldPlaces(explanation)) {
    const TracePlace& place = explanation.trace->places[i];
    const bool viewed = place.fate == PlaceFate::kViewed;
    const Ink ink = viewed ? kLookInk : kIdlePlaceInk;
    std::array<Eigen::Vector2d, 4> outline;
    Eigen::Vector2d top = to(place.center_px);
    for (std::size_t k = 0; k < 4; ++k) {
      outline[k] = to(place.outline_px[k].cast<double>());
      if (outline[k].y() < top.y()) top = outline[k];
    }
    // A dark rim sets it off from a light image.
    canvas.Polyline(outline, {0, 0, 0, 0.4}, viewed ? 3.5 : 2.5, true);
    canvas.Polyline(outline, ink, viewed ? 2 : 1, true);
    labels.push_back({top - Eigen::Vector2d(0, 21), PlaceLabel(place, ++number), ink});
  }
}

/// Where boards were expected.
void DrawExpected(Canvas& canvas, const PictureScale& to, const DetectTrace& trace) {
  for (const TraceExpected& expected : trace.expected) {
    std::array<Eigen::Vector2d, 4> outline;
    for (std::size_t k = 0; k < 4; ++k) outline[k] = to(expected.outline_px[k].cast<double>());
    canvas.Polyline(outline, {0, 0, 0, 0.4}, 2.5, true);
    canvas.Polyline(outline, kIdlePlaceInk, 1, true);
  }
}

/// Four corners of a board's outline; those of them that have a place.
std::vector<Eigen::Vector2d> OutlineOf(const TraceCandidate& candidate, const PictureScale& to) {
  std::vector<Eigen::Vector2d> outline;
  const auto add = [&](int row, int col, std::size_t corner) {
    const TraceCell& cell = candidate.cells[static_cast<std::size_t>(row * candidate.size.cols + col)];
    if (cell.HasPlace()) outline.push_back(to(cell.outline_px[corner].cast<double>()));
  };
  const int bottom = candidate.size.rows - 1, right = candidate.size.cols - 1;
  add(0, 0, 0);
  add(0, right, 1);
  add(bottom, right, 2);
  add(bottom, 0, 3);
  return outline;
}

/// Pixels of the picture; of a cell that has a place.
double CellSide(const TraceCandidate& candidate, const PictureScale& to) {
  const auto placed = std::find_if(candidate.cells.begin(), candidate.cells.end(),
                                   [](const TraceCell& cell) { return cell.HasPlace(); });
  if (placed == candidate.cells.end()) return 0;
  return to.scale * static_cast<double>((placed->outline_px[1] - placed->outline_px[0]).norm());
}

void DrawCandidate(Canvas& canvas, const PictureScale& to, const Explanation& explanation,
                   const TraceCandidate& candidate, int number, std::vector<Label>& labels) {
  const Ink ink = VerdictInk(candidate);
  const Eigen::Vector2d center = to(candidate.center_px);
  double below = center.y();
  if (candidate.CameFar()) {
    const auto outline = OutlineOf(candidate, to);
    if (CellSide(candidate, to) > 9) DrawCells(canvas, to, candidate);
    canvas.Polyline(outline, ink, 2.5, true);
    for (const Eigen::Vector2d& corner : outline) below = std::max(below, corner.y());
  } else {
    for (const int corner : candidate.corners) {
      const Eigen::Vector2d at =
          to(explanation.trace->corners[static_cast<std::size_t>(corner)].position_px.cast<double>());
      canvas.Circle(at.x(), at.y(), 1.6 * UnitOf(to), ink, 1.5);
      below = std::max(below, at.y());
    }
  }
  const std::string text =
      candidate.marker >= 0 ? Verdict(explanation, candidate) : std::string(RefusalName(candidate.refusal));
  labels.push_back({{center.x(), below + 4},
                    fmt::format("{}: {}", number, text),
                    {std::max(ink.red, 0.35), std::max(ink.green, 0.45), std::max(ink.blue, 0.4)}});
}

void DrawLabels(Canvas& canvas, const LabelLayout::Box& picture, const std::vector<Label>& labels) {
  constexpr double kSize = 13, kHeight = kSize + 4, kFar = 12;
  LabelLayout layout(picture);
  for (const Label& label : labels) {
    const double width = canvas.TextWidth(label.text, kSize, true) + 6;
    const LabelLayout::Box box = layout.Take({label.at.x() - width / 2, label.at.y(), width, kHeight});
    if (std::abs(box.top - label.at.y()) > kFar)
      canvas.Line(label.at.x(), label.at.y(), std::clamp(label.at.x(), box.left, box.left + width),
                  box.top > label.at.y() ? box.top : box.top + kHeight, label.ink, 1);
    canvas.Rectangle(box.left, box.top, width, kHeight, {0, 0, 0, 0.78});
    canvas.Text(label.text, box.left + width / 2, box.top + kSize, kSize, label.ink, Align::kMiddle, true);
  }
}

}  // namespace

void DrawHead(Canvas& canvas, double width, const std::string& line) {
  canvas.Rectangle(0, 0, width, kHeadHeight, kDarkBar);
  canvas.Text(line, 12, 22, 15, kPaleLetters, Align::kLeft, true);
  double x = 12, y = 44;
  const auto entry = [&](const std::string& text, const auto& draw) {
    const double needed = 40 + canvas.TextWidth(text, 13);
    if (x + needed > width) x = 12, y += 24;
    draw(x + 8, y);
    canvas.Text(text, x + 22, y + 5, 13, kPaleLetters);
    x += needed;
  };
  const auto stroke = [&](const Ink& ink) {
    return [&canvas, ink](double at, double mid) { canvas.Line(at - 8, mid, at + 8, mid, ink, 3); };
  };
  const auto ring = [&](const Ink& ink) {
    return [&canvas, ink](double at, double mid) { canvas.Circle(at, mid, 5, ink, 1.5); };
  };
  entry("peak, no corner", [&](double at, double mid) { canvas.Disc(at, mid, 2.5, kPeak); });
  entry("corner", ring(kCorner));
  entry("link", stroke(kOpenLinkInk));
  entry("link of a closed square", stroke(kSquareLinkInk));
  entry("place viewed again (P)", stroke(kLookInk));
  entry("its corners", ring(kLookInk));
  entry("not viewed again", stroke(kIdlePlaceInk));
  TraceCandidate example;
  example.marker = 0;
  entry("read", stroke(VerdictInk(example)));
  example.refusal = Refusal::kTwoWords;
  entry("found without an id", stroke(VerdictInk(example)));
  example.marker = -1;
  entry("refused", stroke(VerdictInk(example)));
  entry("cell: what it was taken for", [&](double at, double mid) { canvas.Disc(at, mid, 5, {1, 0.87, 0}); });
  entry("does not show", [&](double at, double mid) {
    canvas.Line(at - 5, mid - 5, at + 5, mid + 5, VerdictInk(example), 1.5);
    canvas.Line(at - 5, mid + 5, at + 5, mid - 5, VerdictInk(example), 1.5);
  });
  entry("border cell that should be otherwise", ring(VerdictInk(example)));
  example.marker = 0;
  entry("doubtful cell", ring(VerdictInk(example)));
}

void DrawPicture(Canvas& canvas, const PictureScale& to, const Explanation& explanation,
                 std::span<const std::size_t> told) {
  const ImageRegion& region = explanation.region;
  const LabelLayout::Box picture{to.left, to.top, region.width * to.scale, region.height * to.scale};
  canvas.Clip(picture.left, picture.top, picture.width, picture.height);
  const Eigen::Vector2d corner = to({-0.5, -0.5});
  canvas.Picture(explanation.image, corner.x(), corner.y(), to.scale);
  DrawStages(canvas, to, *explanation.trace);
  std::vector<Label> labels;
  // The first is the likeliest that somebody looks for: it is drawn last, and has its label where it belongs.
  for (std::size_t i = told.size(); i-- > 0;)
    DrawCandidate(canvas, to, explanation, explanation.candidate(told[i]), static_cast<int>(i) + 1, labels);
  std::reverse(labels.begin(), labels.end());
  DrawExpected(canvas, to, *explanation.trace);
  DrawPlaces(canvas, to, explanation, labels);
  DrawLabels(canvas, picture, labels);
  canvas.EndClip();
}

}  // namespace chequer
