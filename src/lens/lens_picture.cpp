#include "lens/lens_picture.h"

#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include "lens/coverage.h"

namespace chequer {
namespace {

constexpr double kMapWidth = 960, kSide = 360, kMargin = 20, kLine = 20;
/// Residuals are drawn this many pixels long where they are as long as twice the RMS.
constexpr double kDrawnPx = 24;
/// More lines hide each other and the coverage below them: of more points, every second or tenth has one.
constexpr std::size_t kMostLines = 800;

/// How many points a part of the image has; the paler the fewer.
struct CoverageStep {
  int least;
  const char* text;
  std::array<double, 3> colour;
};
constexpr std::array<CoverageStep, 4> kCoverageSteps{{{0, "no point", {1.0, 0.86, 0.84}},
                                                      {1, "1 to 9", {0.97, 0.95, 0.82}},
                                                      {10, "10 to 39", {0.88, 0.95, 0.86}},
                                                      {40, "40 and more", {0.76, 0.9, 0.78}}}};

const CoverageStep& StepOf(int points) {
  const CoverageStep* step = kCoverageSteps.data();
  for (const CoverageStep& each : kCoverageSteps)
    if (points >= each.least) step = &each;
  return *step;
}

void UseColour(cairo_t* cairo, const CoverageStep& step) {
  cairo_set_source_rgb(cairo, step.colour[0], step.colour[1], step.colour[2]);
}

struct FreeSurface {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
struct FreeCairo {
  void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
};

cairo_status_t Append(void* bytes, const unsigned char* data, unsigned length) {
  auto& out = *static_cast<std::vector<std::uint8_t>*>(bytes);
  out.insert(out.end(), data, data + length);
  return CAIRO_STATUS_SUCCESS;
}

/// From blue (well) to red (three times the RMS and more).
void ColourOf(cairo_t* cairo, double error_px, double rms_px) {
  const double bad = std::clamp(error_px / (3 * rms_px), 0.0, 1.0);
  cairo_set_source_rgb(cairo, 0.1 + 0.85 * bad, 0.35 * (1 - bad), 0.8 * (1 - bad));
}

void Text(cairo_t* cairo, double x, double y, const std::string& text) {
  cairo_set_source_rgb(cairo, 0, 0, 0);
  cairo_move_to(cairo, x, y);
  cairo_show_text(cairo, text.c_str());
}

/// The parts of the image, as Coverage has them, by how many points they have.
void DrawCoverage(cairo_t* cairo, const LensCalibration& calibration, double scale) {
  std::array<int, Coverage::kCols * Coverage::kRows> points{};
  const int width = calibration.camera.width, height = calibration.camera.height;
  for (const LensResidual& residual : calibration.residuals) {
    const int col =
        std::clamp(static_cast<int>((residual.pixel.x() + 0.5) * Coverage::kCols / width), 0, Coverage::kCols - 1);
    const int row =
        std::clamp(static_cast<int>((residual.pixel.y() + 0.5) * Coverage::kRows / height), 0, Coverage::kRows - 1);
    ++points[static_cast<std::size_t>(row * Coverage::kCols + col)];
  }
  const double part_width = kMapWidth / Coverage::kCols, part_height = height * scale / Coverage::kRows;
  for (int row = 0; row < Coverage::kRows; ++row)
    for (int col = 0; col < Coverage::kCols; ++col) {
      UseColour(cairo, StepOf(points[static_cast<std::size_t>(row * Coverage::kCols + col)]));
      cairo_rectangle(cairo, kMargin + col * part_width, kMargin + row * part_height, part_width, part_height);
      cairo_fill(cairo);
    }
}

void DrawMap(cairo_t* cairo, const LensCalibration& calibration, double scale) {
  const double rms = std::max(calibration.record.rms_px, 1e-9), grow = kDrawnPx / (2 * rms);
  DrawCoverage(cairo, calibration, scale);
  cairo_set_line_width(cairo, 1);
  const std::size_t every = calibration.residuals.size() / kMostLines + 1;
  for (std::size_t i = 0; i < calibration.residuals.size(); ++i) {
    const LensResidual& residual = calibration.residuals[i];
    const double x = kMargin + (residual.pixel.x() + 0.5) * scale, y = kMargin + (residual.pixel.y() + 0.5) * scale;
    ColourOf(cairo, residual.error_px.norm(), rms);
    cairo_rectangle(cairo, x - 0.75, y - 0.75, 1.5, 1.5);
    cairo_fill(cairo);
    if (i % every != 0) continue;
    cairo_move_to(cairo, x, y);
    cairo_line_to(cairo, x + grow * residual.error_px.x(), y + grow * residual.error_px.y());
    cairo_stroke(cairo);
  }
}

/// What the colours of the map stand for.
void DrawLegend(cairo_t* cairo, const LensCalibration& calibration, double x, double y) {
  const double rms = std::max(calibration.record.rms_px, 1e-9);
  Text(cairo, x, y, "Points in a part of the image:");
  for (const CoverageStep& step : kCoverageSteps) {
    y += kLine;
    UseColour(cairo, step);
    cairo_rectangle(cairo, x, y - 12, 18, 14);
    cairo_fill_preserve(cairo);
    cairo_set_source_rgb(cairo, 0.6, 0.6, 0.6);
    cairo_stroke(cairo);
    Text(cairo, x + 26, y, step.text);
  }
  y += 1.5 * kLine;
  Text(cairo, x, y, "Lines, from seen to expected:");
  for (const double times : {0.5, 1.5, 3.0}) {
    y += kLine;
    ColourOf(cairo, times * rms, rms);
    cairo_set_line_width(cairo, 2);
    cairo_move_to(cairo, x, y - 5);
    cairo_line_to(cairo, x + kDrawnPx * times / 2, y - 5);
    cairo_stroke(cairo);
    Text(cairo, x + 2 * kDrawnPx, y, fmt::format("{:.3f} px{}", times * rms, times == 3 ? " and more" : ""));
  }
}

void DrawScatter(cairo_t* cairo, const LensCalibration& calibration, double x0, double y0) {
  const double rms = std::max(calibration.record.rms_px, 1e-9), reach = kSide / 2, grow = reach / (4 * rms);
  cairo_set_source_rgb(cairo, 0.96, 0.96, 0.96);
  cairo_rectangle(cairo, x0, y0, kSide, kSide);
  cairo_fill(cairo);
  cairo_set_source_rgb(cairo, 0.6, 0.6, 0.6);
  cairo_set_line_width(cairo, 1);
  cairo_new_sub_path(cairo);
  cairo_arc(cairo, x0 + reach, y0 + reach, grow * rms, 0, 2 * M_PI);
  cairo_stroke(cairo);
  for (const LensResidual& residual : calibration.residuals) {
    const double x = grow * residual.error_px.x(), y = grow * residual.error_px.y();
    if (std::max(std::abs(x), std::abs(y)) > reach) continue;
    ColourOf(cairo, residual.error_px.norm(), rms);
    cairo_rectangle(cairo, x0 + reach + x - 1, y0 + reach + y - 1, 2, 2);
    cairo_fill(cairo);
  }
}

void WriteNumbers(cairo_t* cairo, const LensCalibration& calibration, double x, double y) {
  const CameraModel& c = calibration.camera;
  const CalibrationRecord& r = calibration.record;
  const auto line = [&](const std::string& text) {
    Text(cairo, x, y, text);
    y += kLine;
  };
  line(fmt::format("RMS {:.3f} px (circle), lines {:.0f} times", r.rms_px, kDrawnPx / (2 * std::max(r.rms_px, 1e-9))));
  line(fmt::format("{} of {} views, {} points", r.views, calibration.views.size(), calibration.residuals.size()));
  line(fmt::format("fx {:.2f} +- {:.2f} px", c.fx, r.uncertainty[0]));
  line(fmt::format("fy {:.2f} +- {:.2f} px", c.fy, r.uncertainty[1]));
  line(fmt::format("cx {:.2f} +- {:.2f} px", c.cx, r.uncertainty[2]));
  line(fmt::format("cy {:.2f} +- {:.2f} px", c.cy, r.uncertainty[3]));
}

}  // namespace

std::vector<std::uint8_t> DrawLensPicture(const LensCalibration& calibration) {
  const double scale = kMapWidth / calibration.camera.width;
  const double height = std::max(calibration.camera.height * scale, kSide + 19 * kLine) + 2 * kMargin;
  const std::unique_ptr<cairo_surface_t, FreeSurface> surface(cairo_image_surface_create(
      CAIRO_FORMAT_RGB24, static_cast<int>(kMapWidth + kSide + 3 * kMargin), static_cast<int>(height)));
  const std::unique_ptr<cairo_t, FreeCairo> cairo(cairo_create(surface.get()));
  cairo_set_source_rgb(cairo.get(), 1, 1, 1);
  cairo_paint(cairo.get());
  // cairo's own font: the same everywhere, also where none is installed.
  cairo_select_font_face(cairo.get(), "@cairo:", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo.get(), 14);
  DrawMap(cairo.get(), calibration, scale);
  const double x = kMapWidth + 2 * kMargin;
  DrawScatter(cairo.get(), calibration, x, kMargin);
  WriteNumbers(cairo.get(), calibration, x, kMargin + kSide + 2 * kLine);
  DrawLegend(cairo.get(), calibration, x, kMargin + kSide + 9 * kLine);
  std::vector<std::uint8_t> png;
  if (const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), Append, &png);
      status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("cannot draw the calibration: ") + cairo_status_to_string(status));
  return png;
}

}  // namespace chequer
