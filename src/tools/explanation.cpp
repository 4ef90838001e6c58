#include "tools/explanation.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "tools/canvas.h"
#include "tools/explanation_panel.h"
#include "tools/explanation_picture.h"
#include "tools/explanation_place.h"
#include "tools/ink_share.h"

namespace chequer {
namespace {

/// Groups that came nowhere near a board and are told all the same.
constexpr std::size_t kMostGroups = 30;
/// The drawing library's and a viewer's limits.
constexpr double kMostSide = 30000, kMostPixels = 150e6;

int Rank(const TraceCandidate& candidate) {
  if (candidate.refusal == Refusal::kNone) return 2;
  return candidate.marker >= 0 ? 1 : 0;
}

/// What a panel is about.
struct Panel {
  std::size_t index = 0;  ///< of the candidate, or of the place
  int number = 0;
  bool is_place = false;
};

/// Of candidates with cells, and of the places that were viewed again: those before the markers that were read.
std::vector<Panel> PanelsOf(const Explanation& explanation, std::span<const std::size_t> told, int most) {
  std::vector<Panel> panels;
  for (std::size_t i = 0; i < told.size(); ++i)
    if (explanation.candidate(told[i]).CameFar()) panels.push_back({told[i], static_cast<int>(i) + 1, false});
  const auto read = std::find_if(panels.begin(), panels.end(), [&](const Panel& panel) {
    return explanation.candidate(panel.index).refusal == Refusal::kNone;
  });
  std::vector<Panel> places;
  for (const std::size_t i : ToldPlaces(explanation))
    if (explanation.trace->places[i].fate == PlaceFate::kViewed)
      places.push_back({i, static_cast<int>(places.size()) + 1, true});
  panels.insert(read, places.begin(), places.end());
  panels.resize(std::min(panels.size(), static_cast<std::size_t>(most)));
  return panels;
}

std::string FindingsText(const Explanation& explanation) {
  std::string text;
  for (const Finding& finding : explanation.findings) {
    if (finding.reach_px > 0 && !explanation.region.Holds(finding.center_px)) continue;
    text += finding.reach_px > 0 ? fmt::format("   * at ({:.0f}, {:.0f}) px: {}\n", finding.center_px.x(),
                                               finding.center_px.y(), finding.text)
                                 : fmt::format("   * {}\n", finding.text);
  }
  return text.empty() ? text : "what is wrong, and what would help:\n" + text;
}

/// " (warnings: ...)" of a marker that was found; empty where there are none.
std::string Warnings(const MarkerPose& marker) {
  std::string text;
  for (const Warning warning : kAllWarnings) {
    if (!marker.Has(warning)) continue;
    text.append(text.empty() ? "; warnings: " : ", ").append(WarningName(warning));
    if (warning == Warning::kPoorIllumination) text += fmt::format(" (overlap {:.3f})", marker.luminance_overlap);
    if (warning == Warning::kPoorWhiteBalance) text += fmt::format(" (overlap {:.3f})", marker.saturation_overlap);
    if (warning == Warning::kPoorFit)
      text += fmt::format(
          " (the pose leaves {:.0f} times as much unexplained as noise does: is the side right, in both "
          "directions, and the board flat? The covariance is widened by as much)",
          marker.misfit);
  }
  if (marker.bits_corrected > 0) text += fmt::format("; {} cells corrected", marker.bits_corrected);
  return text;
}

/// "7 corners (5 misfit, 2 outside)"; empty where none is hidden.
template <class Parts, class WhyOf>
std::string CountHidden(std::string_view what, const Parts& parts, const WhyOf& why_of) {
  std::array<int, kReasonsToHide> counts{};
  for (const auto& part : parts) ++counts[static_cast<std::size_t>(why_of(part))];
  std::string reasons;
  int hidden = 0;
  for (std::size_t why = static_cast<std::size_t>(Hidden::kNot) + 1; why < counts.size(); ++why) {
    if (counts[why] == 0) continue;
    hidden += counts[why];
    reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", counts[why], HiddenName(static_cast<Hidden>(why)));
  }
  return hidden == 0 ? "" : fmt::format("{} {} ({})", hidden, what, reasons);
}

/// "; hidden: …" of a board; empty where all of it shows.
std::string HiddenParts(const TraceCandidate& candidate) {
  const std::string corners = CountHidden("corners", candidate.inner_corners, [](Hidden why) { return why; });
  const std::string cells = CountHidden("cells", candidate.cells, [](const TraceCell& cell) { return cell.hidden; });
  if (corners.empty() && cells.empty()) return {};
  return "; hidden: " + cells + (corners.empty() || cells.empty() ? "" : ", ") + corners;
}

/// A line a board that the frames before led to expect; empty where there are none.
std::string ExpectedText(const Explanation& explanation) {
  const DetectTrace& trace = *explanation.trace;
  if (trace.expected.empty()) return {};
  std::string text = fmt::format("expected by the frames before: {} boards, {} of them read there",
                                 explanation.stats.expected, explanation.stats.expected_read);
  if (!trace.shift_px.isZero())
    text += fmt::format("; the camera moved: all lie ({:.1f}, {:.1f}) px off", trace.shift_px.x(), trace.shift_px.y());
  text += "\n";
  for (const TraceExpected& expected : trace.expected)
    if (explanation.region.Holds(expected.center_px))
      text += fmt::format("     id {} at ({:.0f}, {:.0f}) px: {}\n", expected.id, expected.center_px.x(),
                          expected.center_px.y(), Explain(expected));
  return text;
}

}  // namespace

Eigen::AlignedBox2d CandidateBox(const Explanation& explanation, const TraceCandidate& candidate) {
  Eigen::AlignedBox2d box(candidate.center_px - Eigen::Vector2d::Constant(4),
                          candidate.center_px + Eigen::Vector2d::Constant(4));
  for (const int corner : candidate.corners)
    box.extend(explanation.trace->corners[static_cast<std::size_t>(corner)].position_px.cast<double>());
  for (const TraceCell& cell : candidate.cells) box.extend(cell.center_px);
  return box;
}

const Finding* FindingAt(const Explanation& explanation, const Eigen::Vector2d& pixel) {
  const auto about = [&](const Finding& finding) { return finding.IsAbout(pixel); };
  const auto found = std::find_if(explanation.findings.begin(), explanation.findings.end(), about);
  return found == explanation.findings.end() ? nullptr : &*found;
}

std::string StageCounts(const Explanation& explanation) {
  const DetectStats& stats = explanation.stats;
  return fmt::format("{} peaks > {} corners > {} groups > {} boards > {} markers, {} of them without an id",
                     stats.corner_candidates, stats.corners, stats.grids, stats.boards, explanation.markers.size(),
                     stats.undecided);
}

std::vector<std::size_t> ToldCandidates(const Explanation& explanation) {
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < explanation.trace->candidates.size(); ++i)
    if (explanation.region.Holds(explanation.candidate(i).center_px)) told.push_back(i);
  std::vector<int> likely(explanation.trace->candidates.size());
  for (const std::size_t i : told) {
    const TraceCandidate& candidate = explanation.candidate(i);
    if (FindingAt(explanation, candidate.center_px) != nullptr) likely[i] += 2;
    if (InkShare(explanation.image, CandidateBox(explanation, candidate)) > kLeastInkShare) likely[i] += 1;
  }
  std::stable_sort(told.begin(), told.end(), [&](std::size_t a, std::size_t b) {
    const TraceCandidate &first = explanation.candidate(a), &second = explanation.candidate(b);
    if (Rank(first) != Rank(second)) return Rank(first) < Rank(second);
    if (likely[a] != likely[b]) return likely[a] > likely[b];
    // Boards first. Of groups, the one with the most corners is the likeliest marker, whatever refused it.
    if (first.corners.empty() != second.corners.empty()) return first.corners.empty();
    if (first.corners.size() != second.corners.size()) return first.corners.size() > second.corners.size();
    return first.refusal > second.refusal;
  });
  std::size_t groups = 0;
  std::erase_if(told, [&](std::size_t i) {
    const bool far = explanation.candidate(i).CameFar() && explanation.candidate(i).refusal != Refusal::kNoYellow;
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
  std::string text = fmt::format("{}: {}\n", explanation.name, StageCounts(explanation)) + FindingsText(explanation);
  const std::vector<std::size_t> told = ToldCandidates(explanation);
  int number = 0;
  for (const std::size_t i : told) {
    const TraceCandidate& candidate = explanation.candidate(i);
    text += fmt::format("{:4} at ({:.0f}, {:.0f}) px: {}", ++number, candidate.center_px.x(), candidate.center_px.y(),
                        Verdict(explanation, candidate));
    if (!candidate.corners.empty()) text += fmt::format(" ({} corners)", candidate.corners.size());
    if (candidate.place >= 0) text += ", by a second look";
    if (candidate.refusal != Refusal::kNone) text += "; " + Explain(candidate);
    if (const Finding* finding = FindingAt(explanation, candidate.center_px)) text += "; " + finding->text;
    text += HiddenParts(candidate);
    if (candidate.marker >= 0) text += Warnings(explanation.markers[static_cast<std::size_t>(candidate.marker)]);
    text += "\n";
  }
  if (told.empty())
    text += "     no group of corners here: cells below 3.5 px, no contrast, strong blur, or no marker in view\n";
  if (told.size() < explanation.trace->candidates.size())
    text += fmt::format("     {} more groups of corners are not told\n",
                        explanation.trace->candidates.size() - told.size());
  return text + DescribePlaces(explanation) + ExpectedText(explanation);
}

std::vector<std::uint8_t> DrawExplanation(const Explanation& explanation, int scale, int most_panels) {
  const ImageRegion& region = explanation.region;
  const std::vector<std::size_t> told = ToldCandidates(explanation);
  const std::vector<Panel> panels = PanelsOf(explanation, told, most_panels);
  constexpr double kLeastWidth = 2 * kPanelWidth + 10;
  const double width = std::max(kLeastWidth, static_cast<double>(region.width) * scale);
  const auto columns = static_cast<std::size_t>((width - 10) / kPanelWidth);
  const double below = kHeadHeight + static_cast<double>(region.height) * scale + 10;
  const double height = below + kPanelHeight * static_cast<double>((panels.size() + columns - 1) / columns);
  if (width > kMostSide || height > kMostSide || width * height > kMostPixels)
    throw std::runtime_error(
        fmt::format("the picture would have {:.0f} x {:.0f} pixels; use a smaller --scale, fewer "
                    "--panels or a --region",
                    width, height));
  Canvas canvas = Canvas::Png(static_cast<int>(width), static_cast<int>(height));
  DrawHead(canvas, width, explanation.name + ":  " + StageCounts(explanation));
  DrawPicture(
      canvas,
      {0, kHeadHeight, static_cast<double>(region.x), static_cast<double>(region.y), static_cast<double>(scale)},
      explanation, told);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const double left = 10 + kPanelWidth * static_cast<double>(i % columns),
                 top = below + kPanelHeight * static_cast<double>(i / columns);
    const auto draw = panels[i].is_place ? DrawPlacePanel : DrawPanel;
    draw(canvas, left, top, explanation, panels[i].index, panels[i].number);
  }
  return canvas.Finish();
}

}  // namespace chequer
