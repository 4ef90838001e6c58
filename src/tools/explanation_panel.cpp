#include "tools/explanation_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "detect/toolbox.h"
#include "tools/plot.h"

namespace chequer {
namespace {

constexpr Ink kPanelSoft{0.4, 0.4, 0.4};
constexpr Ink kGood{0.0, 0.62, 0.2}, kOpen{0.95, 0.6, 0.0}, kBad{0.9, 0.05, 0.1};
/// Kernel cells with less log-likelihood are doubtful: one in twenty is wrong.
constexpr float kDoubtful = 3;

Ink CellInk(const TraceCell& cell) {
  const bool saturated = cell.saturated.value_or(false);
  if (cell.dark()) return saturated ? Ink{0.05, 0.2, 0.9} : Ink{0, 0, 0};
  return saturated ? Ink{1, 0.87, 0} : Ink{1, 1, 1};
}

/// A value in a plot, and which of the two groups it belongs to.
struct PlottedValue {
  double value = 0;
  bool upper = false;
  bool wrong = false;  ///< the border should be in the other group
};

/// Two groups of values: their Gaussians as curves of equal height, every value as a tick under them.
void DrawGaussians(Canvas& canvas, PlotArea area, const PlotTexts& texts, const std::vector<PlottedValue>& values,
                   const std::array<Ink, 2>& inks, const std::array<const char*, 2>& names) {
  std::array<GaussianSum, 2> sums;
  area.x_least = 0, area.x_most = 1;
  for (const PlottedValue& value : values) {
    sums[value.upper].Add(value.value);
    area.x_least = std::min(area.x_least, value.value);
    area.x_most = std::max(area.x_most, value.value);
  }
  // The curves, not only the values, to where they have fallen to a tenth.
  for (const GaussianSum& sum : sums) {
    const Gaussian gaussian = sum.Get();
    if (gaussian.count < 2) continue;
    area.x_least = std::min(area.x_least, gaussian.mean - 2.1 * gaussian.deviation);
    area.x_most = std::max(area.x_most, gaussian.mean + 2.1 * gaussian.deviation);
  }
  const double rim = 0.08 * (area.x_most - area.x_least);
  area.x_least -= rim, area.x_most += rim;
  area.y_least = -0.22, area.y_most = 1.12;
  DrawAxes(canvas, area, texts);
  canvas.Line(area.left, area.Y(0), area.left + area.width, area.Y(0), kPanelSoft, 0.7);
  canvas.Clip(area.left, area.top, area.width, area.height);
  for (std::size_t group = 0; group < 2; ++group) {
    const Gaussian gaussian = sums[group].Get();
    if (gaussian.count < 2) continue;
    const double deviation = std::max(gaussian.deviation, (area.x_most - area.x_least) / 300);
    std::vector<Eigen::Vector2d> curve;
    for (int i = 0; i <= 200; ++i) {
      const double x = area.x_least + (area.x_most - area.x_least) * i / 200, z = (x - gaussian.mean) / deviation;
      curve.emplace_back(area.X(x), area.Y(std::exp(-z * z / 2)));
    }
    canvas.Polyline(curve, inks[group], 2);
  }
  for (const PlottedValue& value : values) {
    const double x = area.X(value.value), low = value.upper ? -0.03 : -0.12;
    canvas.Line(x, area.Y(low), x, area.Y(low - 0.07), value.wrong ? kBad : inks[value.upper], value.wrong ? 2.5 : 1.5);
  }
  canvas.EndClip();
  const Gaussian lower = sums[0].Get(), upper = sums[1].Get();
  const bool both = lower.count > 1 && upper.count > 1;
  const double y = area.top + area.height + 3.9 * texts.size;
  canvas.Text(fmt::format("{} {:.1f} +- {:.1f}", names[0], lower.mean, lower.deviation), area.left, y, texts.size,
              inks[0]);
  canvas.Text(fmt::format("{} {:.1f} +- {:.1f}", names[1], upper.mean, upper.deviation), area.left + area.width, y,
              texts.size, inks[1], Align::kRight);
  canvas.Text(both ? fmt::format("overlap {:.2g}", Overlap(lower, upper)) : "overlap unknown", area.left,
              y + 1.3 * texts.size, texts.size, kPanelInk);
}

void DrawPlots(Canvas& canvas, double left, double top, const TraceCandidate& candidate) {
  std::vector<PlottedValue> luminances, saturations;
  for (const TraceCell& cell : candidate.cells) {
    if (!cell.seen) continue;
    luminances.push_back({cell.luminance, !cell.dark()});
    const bool wrong = cell.expected && cell.saturated && *cell.expected != *cell.saturated;
    if (cell.saturated || cell.expected)
      saturations.push_back({cell.saturation, cell.saturated.value_or(cell.expected.value_or(false)), wrong});
  }
  constexpr double kSize = 10.5, kWidth = 205, kHeight = 130;
  DrawGaussians(canvas, {.left = left, .top = top, .width = kWidth, .height = kHeight},
                {.title = "luminance", .x_label = "L* (HSV: V)", .y_label = "", .size = kSize, .y_steps = 0},
                luminances, {Ink{0.1, 0.1, 0.1}, Ink{0.45, 0.62, 0.8}}, {"dark", "light"});
  DrawGaussians(canvas, {.left = left + kWidth + 22, .top = top, .width = kWidth, .height = kHeight},
                {.title = "saturation",
                 .x_label = "b* of light, -b* of dark cells (HSV: S)",
                 .y_label = "",
                 .size = kSize,
                 .y_steps = 0},
                saturations, {Ink{0.35, 0.35, 0.35}, Ink{0.85, 0.55, 0}}, {"plain", "saturated"});
}

/// The image around a candidate.
void DrawCloseView(Canvas& canvas, double left, double top, const Explanation& explanation,
                   const TraceCandidate& candidate) {
  Eigen::Vector2d least = candidate.center_px, most = candidate.center_px;
  for (const TraceCell& cell : candidate.cells) {
    if (!cell.HasPlace()) continue;
    for (const Eigen::Vector2f& corner : cell.outline_px) {
      least = least.cwiseMin(corner.cast<double>());
      most = most.cwiseMax(corner.cast<double>());
    }
  }
  const PictureScale to = DrawAround(canvas, left, top, explanation.image, (least + most) / 2,
                                     std::clamp(0.56 * (most - least).maxCoeff(), 4.0, 2000.0));
  DrawCells(canvas, to, candidate);
  canvas.EndClip();
}

}  // namespace

Ink VerdictInk(const TraceCandidate& candidate) {
  if (candidate.refusal == Refusal::kNone) return kGood;
  return candidate.marker >= 0 ? kOpen : kBad;
}

void DrawCells(Canvas& canvas, const PictureScale& to, const TraceCandidate& candidate) {
  const Ink outline = VerdictInk(candidate);
  for (const TraceCell& cell : candidate.cells) {
    if (!cell.HasPlace()) continue;
    std::array<Eigen::Vector2d, 4> corners;
    for (std::size_t k = 0; k < 4; ++k) corners[k] = to(cell.outline_px[k].cast<double>());
    const double side = std::min((corners[1] - corners[0]).norm(), (corners[3] - corners[0]).norm());
    canvas.Polyline(corners, {outline.red, outline.green, outline.blue, 0.7}, side > 14 ? 1 : 0.5, true);
    const Eigen::Vector2d at = to(cell.center_px);
    const double radius = std::clamp(0.17 * side, 1.2, 9.0);
    if (!cell.seen || !cell.saturated) {
      const Ink cross = cell.seen ? Ink{0.6, 0.6, 0.6} : kBad;
      canvas.Line(at.x() - radius, at.y() - radius, at.x() + radius, at.y() + radius, cross, 1.5);
      canvas.Line(at.x() - radius, at.y() + radius, at.x() + radius, at.y() - radius, cross, 1.5);
      continue;
    }
    // A rim of grey keeps a disc apart from a cell of its own colour.
    canvas.Disc(at.x(), at.y(), radius + 1, {0.5, 0.5, 0.5});
    canvas.Disc(at.x(), at.y(), radius, CellInk(cell));
    const bool wrong = cell.expected && *cell.expected != *cell.saturated;
    const bool doubtful = !cell.expected && std::abs(cell.log_likelihood) < kDoubtful;
    if (wrong || doubtful) canvas.Circle(at.x(), at.y(), radius + 2.5, wrong ? kBad : kOpen, 2);
  }
}

void DrawPanelHead(Canvas& canvas, double left, double top, const Ink& stripe, const std::string& title,
                   const std::string& sentence) {
  canvas.Rectangle(left, top, kPanelWidth - 10, kPanelHeight - 10, {0.975, 0.975, 0.975});
  canvas.Rectangle(left, top, 5, kPanelHeight - 10, stripe);
  canvas.Text(title, left + 14, top + 20, 15, kPanelInk, Align::kLeft, true);
  double y = top + 38;
  for (const std::string& line : Wrapped(canvas, sentence, 12, kPanelWidth - 40)) {
    canvas.Text(line, left + 14, y, 12, kPanelInk);
    y += 15;
  }
}

PictureScale DrawAround(Canvas& canvas, double left, double top, const ImageView& image, const Eigen::Vector2d& middle,
                        double reach) {
  const int x0 = std::clamp(static_cast<int>(middle.x() - reach), 0, image.width() - 1),
            y0 = std::clamp(static_cast<int>(middle.y() - reach), 0, image.height() - 1);
  const int x1 = std::clamp(static_cast<int>(middle.x() + reach) + 2, x0 + 1, image.width()),
            y1 = std::clamp(static_cast<int>(middle.y() + reach) + 2, y0 + 1, image.height());
  const double scale = kCloseViewSide / (2 * reach);
  const PictureScale to{left, top, middle.x() + 0.5 - reach, middle.y() + 0.5 - reach, scale};
  const Plane plane = image.plane(0);
  const Plane part{plane.data + y0 * plane.stride_bytes + 3 * x0, plane.stride_bytes};
  canvas.Rectangle(left, top, kCloseViewSide, kCloseViewSide, {0.85, 0.85, 0.85});
  canvas.Clip(left, top, kCloseViewSide, kCloseViewSide);
  const Eigen::Vector2d corner = to({x0 - 0.5, y0 - 0.5});
  canvas.Picture(ImageView(PixelFormat::kBgr8, x1 - x0, y1 - y0, std::array{part}, image.tone_curve()), corner.x(),
                 corner.y(), scale);
  return to;
}

void DrawPanel(Canvas& canvas, double left, double top, const Explanation& explanation, std::size_t index, int number) {
  const TraceCandidate& candidate = explanation.candidate(index);
  DrawPanelHead(canvas, left, top, VerdictInk(candidate),
                fmt::format("{}   {}   {}   at ({:.0f}, {:.0f}){}", number, Verdict(explanation, candidate),
                            ToString(candidate.size), candidate.center_px.x(), candidate.center_px.y(),
                            candidate.place >= 0 ? "   second look" : ""),
                candidate.refusal != Refusal::kNone ? Explain(candidate) : "");
  DrawCloseView(canvas, left + 14, top + kPanelHeight - 10 - kCloseViewSide - 6, explanation, candidate);
  DrawPlots(canvas, left + 14 + kCloseViewSide + 26, top + 84, candidate);
}

}  // namespace chequer
