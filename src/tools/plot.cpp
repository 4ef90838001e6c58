#include "tools/plot.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace chequer {
namespace {

constexpr Ink kFrame{0.25, 0.25, 0.25}, kGrid{0.88, 0.88, 0.88}, kAxisLetters{0.1, 0.1, 0.1};

}  // namespace

std::vector<double> RoundSteps(double least, double most, int count) {
  if (!(most > least) || count < 1) return {};
  const double rough = (most - least) / count, power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double times : {5.0, 2.0, 1.0})
    if (times * power >= rough * 0.999) step = times * power;
  std::vector<double> steps;
  for (double i = std::ceil(least / step - 1e-9); i * step <= most + 1e-9 * step; ++i) steps.push_back(i * step + 0.0);
  return steps;
}

void DrawAxes(Canvas& canvas, const PlotArea& area, const PlotTexts& texts) {
  const double size = texts.size, bottom = area.top + area.height;
  for (const double x : RoundSteps(area.x_least, area.x_most, texts.x_steps)) {
    canvas.Line(area.X(x), area.top, area.X(x), bottom, kGrid);
    canvas.Text(fmt::format("{:.4g}", x), area.X(x), bottom + 1.3 * size, size, kAxisLetters, Align::kMiddle);
  }
  for (const double y : RoundSteps(area.y_least, area.y_most, texts.y_steps)) {
    canvas.Line(area.left, area.Y(y), area.left + area.width, area.Y(y), kGrid);
    canvas.Text(fmt::format("{:.4g}", y), area.left - 0.4 * size, area.Y(y) + 0.35 * size, size, kAxisLetters,
                Align::kRight);
  }
  const std::array<Eigen::Vector2d, 4> frame{
      Eigen::Vector2d(area.left, area.top), Eigen::Vector2d(area.left + area.width, area.top),
      Eigen::Vector2d(area.left + area.width, bottom), Eigen::Vector2d(area.left, bottom)};
  canvas.Polyline(frame, kFrame, 1, true);
  canvas.Text(texts.title, area.left + area.width / 2, area.top - 0.6 * size, 1.1 * size, kAxisLetters, Align::kMiddle,
              true);
  canvas.Text(texts.x_label, area.left + area.width / 2, bottom + 2.7 * size, size, kAxisLetters, Align::kMiddle);
  canvas.Text(texts.y_label, area.left - 4 * size, area.top + area.height / 2, size, kAxisLetters, Align::kMiddle,
              false, true);
}

Ink SeriesInk(std::size_t i) {
  constexpr std::array<Ink, 8> kInks{{{0.12, 0.35, 0.70},
                                      {0.85, 0.40, 0.05},
                                      {0.10, 0.55, 0.30},
                                      {0.60, 0.15, 0.45},
                                      {0.35, 0.70, 0.85},
                                      {0.55, 0.45, 0.10},
                                      {0.95, 0.55, 0.70},
                                      {0.20, 0.20, 0.20}}};
  return kInks[i % kInks.size()];
}

}  // namespace chequer
