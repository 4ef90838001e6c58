#pragma once

#include <string>
#include <vector>

#include "tools/canvas.h"

namespace chequer {

/// Round numbers from `least` to `most`, about `count` of them.
std::vector<double> RoundSteps(double least, double most, int count);

/// A diagram's rectangle on a canvas, with axes from `x_least` to `x_most` and `y_least` to `y_most`.
struct PlotArea {
  double left = 0, top = 0, width = 0, height = 0;
  double x_least = 0, x_most = 1, y_least = 0, y_most = 1;

  double X(double value) const { return left + (value - x_least) / (x_most - x_least) * width; }
  double Y(double value) const { return top + height - (value - y_least) / (y_most - y_least) * height; }
};

/// What is written at the axes.
struct PlotTexts {
  std::string title, x_label, y_label;
  double size = 12;  ///< of the letters
  int x_steps = 6;   ///< about so many numbers along x; 0: none
  int y_steps = 5;
};

/// Frame, grid, numbers and labels.
void DrawAxes(Canvas& canvas, const PlotArea& area, const PlotTexts& texts);

/// The colour of the i-th of several series, another for each of the first eight; they differ in lightness, too.
Ink SeriesInk(std::size_t i);

}  // namespace chequer
