#include "tools/track_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "chequer/check.h"
#include "tools/bar_labels.h"
#include "tools/plot.h"

namespace chequer {
namespace {

constexpr Ink kFigureLetters{0.1, 0.1, 0.1}, kFigureSoft{0.45, 0.45, 0.45};
constexpr double kLetterSize = 13;
/// Room above what is highest.
constexpr double kHeadroom = 1.12;
/// Between the highest label and the frame.
constexpr double kRim = 4;

/// One run as a figure needs it.
struct Series {
  std::string name;
  ErrorMeasures measures;
  std::vector<Eigen::Vector2d> points;  ///< metres along the track, error
  Ink ink;
};

std::vector<Series> SeriesOf(TrackFigure figure, std::span<const Evaluation> runs) {
  std::vector<Series> all;
  for (const Evaluation& run : runs) {
    if (!run.track) continue;
    Series& series = all.emplace_back();
    series.name = run.name;
    series.measures = figure == TrackFigure::kLinear ? run.linear_mm : run.angular_deg;
    for (std::size_t i = 0; i < run.track->along_m.size(); ++i)
      series.points.emplace_back(run.track->along_m[i], figure == TrackFigure::kLinear ? 1e3 * run.track->distance_m[i]
                                                                                       : run.track->angle_deg[i]);
    std::sort(series.points.begin(), series.points.end(), [](const auto& a, const auto& b) { return a.x() < b.x(); });
    series.ink = SeriesInk(all.size() - 1);
  }
  return all;
}

Ink Pale(Ink ink) {
  ink.opacity = 0.45;
  return ink;
}

/// Names below the bars; where they are too long for that, numbers, by which the legend has them, as many as have room.
void WriteNames(Canvas& canvas, const PlotArea& area, const std::vector<Series>& runs) {
  const double step = area.width / static_cast<double>(runs.size());
  const bool names_fit = std::all_of(runs.begin(), runs.end(),
                                     [&](const Series& run) { return canvas.TextWidth(run.name, kLetterSize) < step; });
  const double number_width = canvas.TextWidth(fmt::format("{} ", runs.size()), kLetterSize);
  const std::size_t every = names_fit ? 1 : static_cast<std::size_t>(std::ceil(number_width / step));
  for (std::size_t i = 0; i < runs.size(); i += every)
    canvas.Text(names_fit ? runs[i].name : fmt::format("{}", i + 1), area.left + (static_cast<double>(i) + 0.5) * step,
                area.top + area.height + 1.3 * kLetterSize, kLetterSize, kFigureLetters, Align::kMiddle);
}

void DrawBars(Canvas& canvas, PlotArea area, const std::vector<Series>& runs, const std::string& unit) {
  const double step = area.width / static_cast<double>(runs.size()), bar = std::min(0.36 * step, 48.0);
  double highest = 1e-9;
  std::vector<double> values;
  for (const Series& run : runs) {
    highest = std::max(highest, run.measures.rmse);  // the MAE is never larger
    values.insert(values.end(), {run.measures.rmse, run.measures.mae});
  }
  const BarLabels labels(canvas, values, bar);
  area.y_least = 0;
  area.y_most = std::max(kHeadroom, area.height / (area.height - labels.height() - kRim)) * highest;
  DrawAxes(canvas, area,
           {.title = "RMSE (full) and MAE (pale)", .x_label = "", .y_label = unit, .size = kLetterSize, .x_steps = 0});
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const double middle = area.left + (static_cast<double>(i) + 0.5) * step, floor = area.top + area.height;
    const auto draw = [&](double left, double value, const Ink& ink) {
      canvas.Rectangle(left, area.Y(value), bar, floor - area.Y(value), ink);
      labels.Write(canvas, value, left, area.Y(value), kFigureLetters);
    };
    draw(middle - bar - 1, runs[i].measures.rmse, runs[i].ink);
    draw(middle + 1, runs[i].measures.mae, Pale(runs[i].ink));
  }
  WriteNames(canvas, area, runs);
}

void DrawPoints(Canvas& canvas, PlotArea area, const std::vector<Series>& runs, const std::string& unit) {
  area.x_least = area.x_most = 0;
  area.y_least = 0;
  area.y_most = 1e-9;
  for (const Series& run : runs)
    for (const Eigen::Vector2d& point : run.points) {
      area.x_least = std::min(area.x_least, point.x());
      area.x_most = std::max(area.x_most, point.x());
      area.y_most = std::max(area.y_most, kHeadroom * point.y());
    }
  const double rim = 0.03 * std::max(area.x_most - area.x_least, 1e-3);
  area.x_least -= rim;
  area.x_most += rim;
  DrawAxes(canvas, area,
           {.title = "Every pose",
            .x_label = "along the best line from the middle of the run, m",
            .y_label = unit,
            .size = kLetterSize});
  for (const Series& run : runs) {
    std::vector<Eigen::Vector2d> line;
    for (const Eigen::Vector2d& point : run.points) line.emplace_back(area.X(point.x()), area.Y(point.y()));
    if (line.size() <= 200) canvas.Polyline(line, Pale(run.ink), 1);
    const double radius = line.size() <= 60 ? 3.5 : 2;
    for (const Eigen::Vector2d& point : line) canvas.Disc(point.x(), point.y(), radius, run.ink);
  }
}

}  // namespace

std::vector<std::uint8_t> DrawTrackFigure(TrackFigure figure, std::span<const Evaluation> runs) {
  const std::vector<Series> series = SeriesOf(figure, runs);
  CHEQUER_CHECK(!series.empty(), "a figure needs a run with a track");
  constexpr double kWidth = 1100, kPlotHeight = 330, kTop = 74;
  const double legend = kTop + kPlotHeight + 66;
  Canvas canvas = Canvas::Svg(kWidth, legend + 20 * static_cast<double>(series.size()) + 10);
  const bool linear = figure == TrackFigure::kLinear;
  const std::string unit = linear ? "distance from the best line, mm" : "angle to the best orientation, degrees";
  canvas.Text(linear ? "Linear error along a straight track" : "Angular error along a straight track", kWidth / 2, 28,
              19, kFigureLetters, Align::kMiddle, true);
  DrawBars(canvas, {.left = 80, .top = kTop, .width = 410, .height = kPlotHeight}, series, unit);
  DrawPoints(canvas, {.left = 580, .top = kTop, .width = 490, .height = kPlotHeight}, series, unit);
  for (std::size_t i = 0; i < series.size(); ++i) {
    const double y = legend + 20 * static_cast<double>(i);
    canvas.Rectangle(80, y - 10, 14, 12, series[i].ink);
    const ErrorMeasures& m = series[i].measures;
    canvas.Text(fmt::format("{}  {}: {} poses, RMSE {:.4g}, MAE {:.4g}, largest {:.4g} {}", i + 1, series[i].name,
                            series[i].points.size(), m.rmse, m.mae, m.largest, linear ? "mm" : "degrees"),
                102, y, kLetterSize, kFigureSoft);
  }
  return canvas.Finish();
}

}  // namespace chequer
