#include "tools/canvas.h"

#include <cairo-svg.h>
#include <cairo.h>

#include <cstring>
#include <numbers>
#include <sstream>

#include "chequer/check.h"
#include "print/cairo_file.h"

namespace chequer {
struct Canvas::Impl {
  std::vector<std::uint8_t> bytes;  ///< outlives the surface, which writes to it
  CairoSurface surface;
  Cairo cairo;
  bool svg = false;

  void Start(double width, double height) {
    cairo.reset(cairo_create(surface.get()));
    CheckCairo(cairo_status(cairo.get()));
    cairo_set_line_join(cairo.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_set_source_rgb(cairo.get(), 1, 1, 1);
    cairo_rectangle(cairo.get(), 0, 0, width, height);
    cairo_fill(cairo.get());
  }
  void Use(const Ink& ink) { cairo_set_source_rgba(cairo.get(), ink.red, ink.green, ink.blue, ink.opacity); }
  void Path(std::span<const Eigen::Vector2d> points, bool closed) {
    cairo_new_path(cairo.get());
    for (const Eigen::Vector2d& point : points) cairo_line_to(cairo.get(), point.x(), point.y());
    if (closed) cairo_close_path(cairo.get());
  }
  void Stroke(const Ink& ink, double width) {
    Use(ink);
    cairo_set_line_width(cairo.get(), width);
    cairo_stroke(cairo.get());
  }
  void Font(double size, bool bold) const {
    // The own font's letters are written out stroke by stroke, each time: a hundred times the bytes in an SVG.
    cairo_select_font_face(cairo.get(), svg ? "sans-serif" : "@cairo:", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo.get(), size);
  }
};

Canvas::Canvas(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

Canvas Canvas::Png(int width, int height) {
  auto impl = std::make_unique<Impl>();
  impl->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
  CheckCairo(cairo_surface_status(impl->surface.get()));
  impl->Start(width, height);
  return Canvas(std::move(impl));
}

Canvas Canvas::Svg(double width, double height) {
  auto impl = std::make_unique<Impl>();
  impl->svg = true;
  impl->surface.reset(cairo_svg_surface_create_for_stream(AppendToBytes, &impl->bytes, width, height));
  impl->Start(width, height);
  return Canvas(std::move(impl));
}

void Canvas::Line(double x0, double y0, double x1, double y1, const Ink& ink, double width) {
  const std::array<Eigen::Vector2d, 2> points{Eigen::Vector2d(x0, y0), Eigen::Vector2d(x1, y1)};
  Polyline(points, ink, width);
}

void Canvas::Polyline(std::span<const Eigen::Vector2d> points, const Ink& ink, double width, bool closed) {
  impl_->Path(points, closed);
  impl_->Stroke(ink, width);
}

void Canvas::FillPolygon(std::span<const Eigen::Vector2d> points, const Ink& ink) {
  impl_->Path(points, true);
  impl_->Use(ink);
  cairo_fill(impl_->cairo.get());
}

void Canvas::Rectangle(double x, double y, double width, double height, const Ink& fill) {
  cairo_rectangle(impl_->cairo.get(), x, y, width, height);
  impl_->Use(fill);
  cairo_fill(impl_->cairo.get());
}

void Canvas::Circle(double x, double y, double radius, const Ink& ink, double width) {
  cairo_new_path(impl_->cairo.get());
  cairo_arc(impl_->cairo.get(), x, y, radius, 0, 2 * std::numbers::pi);
  impl_->Stroke(ink, width);
}

void Canvas::Disc(double x, double y, double radius, const Ink& ink) {
  cairo_new_path(impl_->cairo.get());
  cairo_arc(impl_->cairo.get(), x, y, radius, 0, 2 * std::numbers::pi);
  impl_->Use(ink);
  cairo_fill(impl_->cairo.get());
}

void Canvas::Text(const std::string& text, double x, double y, double size, const Ink& ink, Align align, bool bold,
                  bool turned) {
  cairo_t* cairo = impl_->cairo.get();
  const double width = TextWidth(text, size, bold);
  cairo_save(cairo);
  cairo_translate(cairo, x, y);
  if (turned) cairo_rotate(cairo, -std::numbers::pi / 2);
  cairo_move_to(cairo, align == Align::kLeft ? 0 : align == Align::kMiddle ? -width / 2 : -width, 0);
  impl_->Use(ink);
  cairo_show_text(cairo, text.c_str());
  cairo_restore(cairo);
}

double Canvas::TextWidth(const std::string& text, double size, bool bold) const {
  impl_->Font(size, bold);
  cairo_text_extents_t extents;
  cairo_text_extents(impl_->cairo.get(), text.c_str(), &extents);
  return extents.x_advance;
}

void Canvas::Picture(const ImageView& image, double x, double y, double scale) {
  CHEQUER_CHECK(image.format() == PixelFormat::kBgr8, "pictures are drawn from BGR8");
  const CairoSurface picture(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width(), image.height()));
  CheckCairo(cairo_surface_status(picture.get()));
  unsigned char* rows = cairo_image_surface_get_data(picture.get());
  const int stride = cairo_image_surface_get_stride(picture.get());
  for (int row = 0; row < image.height(); ++row) {
    const std::uint8_t* in = image.plane(0).data + row * image.plane(0).stride_bytes;
    for (int col = 0; col < image.width(); ++col) {
      const std::uint32_t pixel =
          std::uint32_t{in[3 * col + 2]} << 16 | std::uint32_t{in[3 * col + 1]} << 8 | std::uint32_t{in[3 * col]};
      std::memcpy(rows + row * stride + 4 * col, &pixel, sizeof pixel);
    }
  }
  cairo_surface_mark_dirty(picture.get());
  cairo_t* cairo = impl_->cairo.get();
  cairo_save(cairo);
  cairo_translate(cairo, x, y);
  cairo_scale(cairo, scale, scale);
  cairo_set_source_surface(cairo, picture.get(), 0, 0);
  cairo_pattern_set_filter(cairo_get_source(cairo), scale < 1 ? CAIRO_FILTER_GOOD : CAIRO_FILTER_NEAREST);
  cairo_paint(cairo);
  cairo_restore(cairo);
}

void Canvas::Clip(double x, double y, double width, double height) {
  cairo_save(impl_->cairo.get());
  cairo_rectangle(impl_->cairo.get(), x, y, width, height);
  cairo_clip(impl_->cairo.get());
}

void Canvas::EndClip() { cairo_restore(impl_->cairo.get()); }

std::vector<std::uint8_t> Canvas::Finish() {
  CheckCairo(cairo_status(impl_->cairo.get()));
  if (!impl_->svg) CheckCairo(cairo_surface_write_to_png_stream(impl_->surface.get(), AppendToBytes, &impl_->bytes));
  cairo_surface_finish(impl_->surface.get());
  CheckCairo(cairo_surface_status(impl_->surface.get()));
  return std::move(impl_->bytes);
}

std::vector<std::string> Wrapped(const Canvas& canvas, const std::string& text, double size, double width) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.empty() && canvas.TextWidth(lines.back() + " " + word, size) <= width)
      lines.back() += " " + word;
    else
      lines.push_back(word);
  }
  return lines;
}

}  // namespace chequer
