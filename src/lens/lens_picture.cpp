#include "lens/lens_picture.h"

#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

namespace chequer {
namespace {

constexpr double kMapWidth = 960, kSide = 360, kMargin = 20, kLine = 20;
/// Residuals are drawn this many pixels long where they are as long as twice the RMS.
constexpr double kDrawnPx = 24;

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

void DrawMap(cairo_t* cairo, const LensCalibration& calibration, double scale) {
  const double rms = std::max(calibration.record.rms_px, 1e-9), grow = kDrawnPx / (2 * rms);
  cairo_set_source_rgb(cairo, 0.96, 0.96, 0.96);
  cairo_rectangle(cairo, kMargin, kMargin, kMapWidth, calibration.camera.height * scale);
  cairo_fill(cairo);
  cairo_set_line_width(cairo, 1);
  for (const LensResidual& residual : calibration.residuals) {
    const double x = kMargin + (residual.pixel.x() + 0.5) * scale, y = kMargin + (residual.pixel.y() + 0.5) * scale;
    ColourOf(cairo, residual.error_px.norm(), rms);
    cairo_rectangle(cairo, x - 1, y - 1, 2, 2);
    cairo_fill(cairo);
    cairo_move_to(cairo, x, y);
    cairo_line_to(cairo, x + grow * residual.error_px.x(), y + grow * residual.error_px.y());
    cairo_stroke(cairo);
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
  const double height = std::max(calibration.camera.height * scale, kSide + 8 * kLine) + 2 * kMargin;
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
  std::vector<std::uint8_t> png;
  if (const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), Append, &png);
      status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("cannot draw the calibration: ") + cairo_status_to_string(status));
  return png;
}

}  // namespace chequer
