#include "tools/explanation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/canvas.h"
#include "tools/explanation_panel.h"

namespace chequer {
namespace {

constexpr Ink kDarkBar{0.13, 0.14, 0.16}, kPaleLetters{0.93, 0.93, 0.93};
constexpr Ink kPeak{1, 1, 1, 0.75}, kPeakRim{0, 0, 0, 0.6}, kCorner{0, 0.85, 1}, kOpenLink{0.95, 0.45, 1, 0.6},
    kSquareLink{0.1, 0.95, 0.3};
/// Groups that came nowhere near a board and are told all the same.
constexpr std::size_t kMostGroups = 30;
constexpr double kHead = 62;
/// The drawing library's and a viewer's limits.
constexpr double kMostSide = 30000, kMostPixels = 150e6;

/// Whether it got as far as to be sampled as a board.
bool CameFar(const TraceCandidate& candidate) { return !candidate.cells.empty(); }

int Rank(const TraceCandidate& candidate) {
  if (candidate.refusal == Refusal::kNone) return 2;
  return candidate.marker >= 0 ? 1 : 0;
}

/// Four corners of a board's outline.
std::array<Eigen::Vector2d, 4> OutlineOf(const TraceCandidate& candidate, const PictureScale& to) {
  const auto cell = [&](int row, int col, std::size_t corner) {
    return to(
        candidate.cells[static_cast<std::size_t>(row * candidate.size.cols + col)].outline_px[corner].cast<double>());
  };
  const int bottom = candidate.size.rows - 1, right = candidate.size.cols - 1;
  return {cell(0, 0, 0), cell(0, right, 1), cell(bottom, right, 2), cell(bottom, 0, 3)};
}

void DrawStages(Canvas& canvas, const PictureScale& to, const DetectTrace& trace) {
  const double unit = std::clamp(to.scale, 1.0, 4.0);
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
      canvas.Line(from.x(), from.y(), end.x(), end.y(), in_square ? kSquareLink : kOpenLink, 0.4 * unit);
    }
  for (const DetectTrace::Corner& corner : trace.corners) {
    const Eigen::Vector2d at = to(corner.position_px.cast<double>());
    canvas.Circle(at.x(), at.y(), (0.7 + 0.4 * corner.scale) * unit, kCorner, 0.35 * unit);
  }
}

void DrawLabel(Canvas& canvas, const Eigen::Vector2d& at, const std::string& text, double size, const Ink& ink) {
  const double width = canvas.TextWidth(text, size, true) + 6;
  canvas.Rectangle(at.x() - width / 2, at.y() - size, width, size + 4, {0, 0, 0, 0.72});
  canvas.Text(text, at.x(), at.y(), size, ink, Align::kMiddle, true);
}

void DrawCandidate(Canvas& canvas, const PictureScale& to, const Explanation& explanation,
                   const TraceCandidate& candidate, int number) {
  const Ink ink = VerdictInk(candidate);
  const Eigen::Vector2d center = to(candidate.center_px);
  double below = center.y();
  if (CameFar(candidate)) {
    const auto outline = OutlineOf(candidate, to);
    if (to.scale * (candidate.cells[0].outline_px[1] - candidate.cells[0].outline_px[0]).norm() > 9)
      DrawCells(canvas, to, candidate);
    canvas.Polyline(outline, ink, 2.5, true);
    for (const Eigen::Vector2d& corner : outline) below = std::max(below, corner.y());
  } else {
    for (const int corner : candidate.corners) {
      const Eigen::Vector2d at =
          to(explanation.trace->corners[static_cast<std::size_t>(corner)].position_px.cast<double>());
      canvas.Circle(at.x(), at.y(), 1.6 * std::clamp(to.scale, 1.0, 4.0), ink, 1.5);
      below = std::max(below, at.y());
    }
  }
  const std::string text = candidate.refusal == Refusal::kNone || candidate.marker >= 0
                               ? fmt::format("{}: {}", number, Verdict(explanation, candidate))
                               : fmt::format("{}: {}", number, RefusalName(candidate.refusal));
  DrawLabel(canvas, {center.x(), below + 16}, text, 13,
            {std::max(ink.red, 0.35), std::max(ink.green, 0.45), std::max(ink.blue, 0.4)});
}

std::string Counts(const Explanation& explanation) {
  const DetectStats& stats = explanation.stats;
  return fmt::format("{} peaks > {} corners > {} groups > {} boards > {} markers, {} of them without an id",
                     stats.corner_candidates, stats.corners, stats.grids, stats.boards, explanation.markers.size(),
                     stats.undecided);
}

void DrawHead(Canvas& canvas, double width, const Explanation& explanation) {
  canvas.Rectangle(0, 0, width, kHead, kDarkBar);
  canvas.Text(explanation.name + ":  " + Counts(explanation), 12, 22, 15, kPaleLetters, Align::kLeft, true);
  double x = 12;
  const auto entry = [&](const std::string& text, const auto& draw) {
    draw(x + 8, 44.0);
    canvas.Text(text, x + 22, 49, 13, kPaleLetters);
    x += 40 + canvas.TextWidth(text, 13);
  };
  const auto line = [&](const Ink& ink) {
    return [&canvas, ink](double at, double y) { canvas.Line(at - 8, y, at + 8, y, ink, 3); };
  };
  entry("peak, no corner", [&](double at, double y) { canvas.Disc(at, y, 2.5, kPeak); });
  entry("corner", [&](double at, double y) { canvas.Circle(at, y, 5, kCorner, 1.5); });
  entry("link", line(kOpenLink));
  entry("link of a closed square", line(kSquareLink));
  entry("read", line(VerdictInk(TraceCandidate{})));
  TraceCandidate open;
  open.refusal = Refusal::kTwoWords;
  open.marker = 0;
  entry("found without an id", line(VerdictInk(open)));
  open.marker = -1;
  entry("refused", line(VerdictInk(open)));
  entry("in cells: what it was taken for; cross: does not show; red ring: border wrong; amber ring: doubtful",
        [&](double at, double y) {
          canvas.Disc(at, y, 5, {1, 0.87, 0});
        });
}

}  // namespace

std::vector<std::size_t> ToldCandidates(const Explanation& explanation) {
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < explanation.trace->candidates.size(); ++i)
    if (explanation.region.Holds(explanation.candidate(i).center_px)) told.push_back(i);
  std::stable_sort(told.begin(), told.end(), [&](std::size_t a, std::size_t b) {
    const TraceCandidate &first = explanation.candidate(a), &second = explanation.candidate(b);
    if (Rank(first) != Rank(second)) return Rank(first) < Rank(second);
    // Boards first. Of groups, the one with the most corners is the likeliest marker, whatever refused it.
    if (first.corners.empty() != second.corners.empty()) return first.corners.empty();
    if (first.corners.size() != second.corners.size()) return first.corners.size() > second.corners.size();
    return first.refusal > second.refusal;
  });
  std::size_t groups = 0;
  std::erase_if(told, [&](std::size_t i) {
    const bool far = CameFar(explanation.candidate(i)) && explanation.candidate(i).refusal != Refusal::kNoYellow;
    return !far && explanation.candidate(i).refusal != Refusal::kNone && ++groups > kMostGroups;
  });
  return told;
}

std::string Verdict(const Explanation& explanation, const TraceCandidate& candidate) {
  if (candidate.marker < 0) return "refused: " + std::string(RefusalName(candidate.refusal));
  const auto& id = explanation.markers[static_cast<std::size_t>(candidate.marker)].id;
  return id ? fmt::format("id {}", *id) : "no id";
}

std::string DescribeExplanation(const Explanation& explanation) {
  std::string text = fmt::format("{}: {}\n", explanation.name, Counts(explanation));
  const std::vector<std::size_t> told = ToldCandidates(explanation);
  int number = 0;
  for (const std::size_t i : told) {
    const TraceCandidate& candidate = explanation.candidate(i);
    text += fmt::format("{:4} at ({:.0f}, {:.0f}) px: {}", ++number, candidate.center_px.x(), candidate.center_px.y(),
                        Verdict(explanation, candidate));
    if (!candidate.corners.empty()) text += fmt::format(" ({} corners)", candidate.corners.size());
    text += candidate.refusal == Refusal::kNone ? "\n" : "; " + Explain(candidate) + "\n";
  }
  if (told.empty())
    text += "     no group of corners anywhere: cells below 3.5 px, no contrast, strong blur, or no marker in view\n";
  if (told.size() < explanation.trace->candidates.size())
    text += fmt::format("     {} more groups of corners are not told\n",
                        explanation.trace->candidates.size() - told.size());
  return text;
}

std::vector<std::uint8_t> DrawExplanation(const Explanation& explanation, int scale, int most_panels) {
  const ImageRegion& region = explanation.region;
  const std::vector<std::size_t> told = ToldCandidates(explanation);
  std::vector<std::pair<std::size_t, int>> panels;  // with their numbers
  for (std::size_t i = 0; i < told.size() && static_cast<int>(panels.size()) < most_panels; ++i)
    if (CameFar(explanation.candidate(told[i]))) panels.emplace_back(told[i], static_cast<int>(i) + 1);
  constexpr double kLeastWidth = 2 * kPanelWidth + 10;
  const double width = std::max(kLeastWidth, static_cast<double>(region.width) * scale);
  const auto columns = static_cast<std::size_t>((width - 10) / kPanelWidth);
  const double picture = static_cast<double>(region.height) * scale;
  const double height =
      kHead + picture + 10 + kPanelHeight * static_cast<double>((panels.size() + columns - 1) / columns);
  if (width > kMostSide || height > kMostSide || width * height > kMostPixels)
    throw std::runtime_error(
        fmt::format("the picture would have {:.0f} x {:.0f} pixels; use a smaller --scale, fewer "
                    "--panels or a --region",
                    width, height));
  Canvas canvas = Canvas::Png(static_cast<int>(width), static_cast<int>(height));
  DrawHead(canvas, width, explanation);
  canvas.Clip(0, kHead, static_cast<double>(region.width) * scale, picture);
  const PictureScale to{0, kHead, static_cast<double>(region.x), static_cast<double>(region.y),
                        static_cast<double>(scale)};
  const Eigen::Vector2d corner = to({-0.5, -0.5});
  canvas.Picture(explanation.image, corner.x(), corner.y(), scale);
  DrawStages(canvas, to, *explanation.trace);
  for (std::size_t i = told.size(); i-- > 0;)
    DrawCandidate(canvas, to, explanation, explanation.candidate(told[i]), static_cast<int>(i) + 1);
  canvas.EndClip();
  for (std::size_t i = 0; i < panels.size(); ++i)
    DrawPanel(canvas, 10 + kPanelWidth * static_cast<double>(i % columns),
              kHead + picture + 10 + kPanelHeight * static_cast<double>(i / columns), explanation, panels[i].first,
              panels[i].second);
  return canvas.Finish();
}

}  // namespace chequer
