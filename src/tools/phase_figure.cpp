#include "tools/phase_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/canvas.h"
#include "tools/plot.h"

namespace chequer {
namespace {

constexpr Ink kPhaseLetters{0.1, 0.1, 0.1}, kBand{0.93, 0.95, 0.98}, kWrong{0.85, 0.1, 0.1}, kMissing{0.6, 0.6, 0.6};
constexpr double kPhaseLetterSize = 13, kFigureWidth = 1500, kPanelHeight = 210, kPanelStep = 280, kFirstPanel = 110;

/// A phase of the run on the time axis. A stream that is played over and over has each many times.
struct Span {
  std::string name;
  double from_s = 0, to_s = 0;
};

std::vector<Span> SpansOf(const std::vector<ScoredFrame>& frames) {
  std::vector<Span> spans;
  for (const ScoredFrame& frame : frames) {
    if (spans.empty() || spans.back().name != frame.phase) {
      if (!spans.empty()) spans.back().to_s = frame.time_s;
      spans.push_back({frame.phase, frame.time_s, frame.time_s});
    }
    spans.back().to_s = frame.time_s;
  }
  return spans;
}

/// Draws panels one below the other over one time axis.
class PhaseFigure {
 public:
  explicit PhaseFigure(const PhaseRun& run)
      : run_(run),
        canvas_(Canvas::Png(static_cast<int>(kFigureWidth), static_cast<int>(kFirstPanel + 3 * kPanelStep))) {
    canvas_.Text(run.name, kFigureWidth / 2, 30, 19, kPhaseLetters, Align::kMiddle, true);
  }

  std::vector<std::uint8_t> Draw() {
    DrawShares();
    DrawErrors();
    DrawTimes();
    return canvas_.Finish();
  }

 private:
  PlotArea NextPanel(double least, double most, const std::string& title, const std::string& unit) {
    const double top = kFirstPanel + kPanelStep * panels_++;
    PlotArea area{.left = 90, .top = top, .width = kFigureWidth - 120, .height = kPanelHeight};
    area.x_least = 0;
    area.x_most = std::max(1e-3, run_.frames.back().time_s);
    area.y_least = least;
    area.y_most = most;
    bool banded = true;
    double free_from = 0;
    for (const Span& span : SpansOf(run_.frames)) {
      const double left = area.X(span.from_s), right = area.X(span.to_s);
      banded = !banded;
      if (banded) canvas_.Rectangle(left, top, right - left, kPanelHeight, kBand);
      // Of many short phases as many names as have room.
      const double width = canvas_.TextWidth(span.name + " ", kPhaseLetterSize);
      if (left < free_from) continue;
      canvas_.Text(span.name, left, top - 6, kPhaseLetterSize, kPhaseLetters);
      free_from = left + width;
    }
    DrawAxes(canvas_, area,
             {.title = "", .x_label = panels_ == 3 ? "time, s" : "", .y_label = unit, .size = kPhaseLetterSize});
    canvas_.Text(title, area.left + area.width / 2, top - 26, 1.1 * kPhaseLetterSize, kPhaseLetters, Align::kMiddle,
                 true);
    return area;
  }

  void DrawShares() {
    const PlotArea area = NextPanel(
        0, 1.05, "Boards read, share; red: wrong ids, ghosts, ids read twice; grey: no answer", "share of the boards");
    for (const ScoredFrame& frame : run_.frames) {
      const double x = area.X(frame.time_s);
      if (!frame.score) {
        canvas_.Line(x, area.Y(0), x, area.Y(0.06), kMissing, 2);
        continue;
      }
      canvas_.Disc(x, area.Y(frame.score->Recall()), 2.2, SeriesInk(0));
      if (frame.score->wrong + frame.score->ghosts + frame.score->twice > 0)
        canvas_.Line(x, area.Y(0), x, area.Y(1), kWrong, 1.5);
    }
  }

  void DrawErrors() {
    std::vector<double> all;
    for (const ScoredFrame& frame : run_.frames)
      if (frame.score)
        for (const PoseError& error : frame.score->errors) all.push_back(error.position_mm);
    const auto [least, most] = Decades(all);
    const PlotArea area = NextPanel(least, most, "Errors of the positions, every board", "lg (error / mm)");
    for (const ScoredFrame& frame : run_.frames)
      if (frame.score)
        for (const PoseError& error : frame.score->errors)
          canvas_.Disc(area.X(frame.time_s), area.Y(LogWithin(error.position_mm, area)), 1.3, SeriesInk(2));
  }

  void DrawTimes() {
    std::vector<double> all;
    for (const ScoredFrame& frame : run_.frames) {
      if (frame.detect_ms) all.push_back(*frame.detect_ms);
      if (frame.latency_ms) all.push_back(*frame.latency_ms);
    }
    const auto [least, most] = Decades(all);
    const PlotArea area =
        NextPanel(least, most, "Time: detection (blue), capture to publication (orange)", "lg (time / ms)");
    for (const ScoredFrame& frame : run_.frames) {
      if (frame.detect_ms)
        canvas_.Disc(area.X(frame.time_s), area.Y(LogWithin(*frame.detect_ms, area)), 2, SeriesInk(0));
      if (frame.latency_ms)
        canvas_.Disc(area.X(frame.time_s), area.Y(LogWithin(*frame.latency_ms, area)), 2, SeriesInk(1));
    }
  }

  /// Logarithms that hold nearly all values, with some room; a few outliers must not squeeze the rest.
  static std::pair<double, double> Decades(const std::vector<double>& values) {
    const Spread spread = SpreadOf(values);
    if (spread.count == 0 || spread.largest <= 0) return {-1, 1};
    const double middle = std::log10(std::max(spread.median, 1e-9));
    return {std::min(middle - 1, std::log10(spread.largest) - 4),
            std::max(middle + 0.5, std::log10(spread.largest) + 0.1)};
  }
  static double LogWithin(double value, const PlotArea& area) {
    return std::clamp(std::log10(std::max(value, 1e-12)), area.y_least, area.y_most);
  }

  const PhaseRun& run_;
  Canvas canvas_;
  int panels_ = 0;
};

}  // namespace

std::vector<std::uint8_t> DrawPhaseFigure(const PhaseRun& run) { return PhaseFigure(run).Draw(); }

}  // namespace chequer
