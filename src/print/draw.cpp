#include "print/draw.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "print/cairo_file.h"
#include "print/png_pixel_size.h"

namespace chequer {
namespace {

constexpr double kPointsPerMetre = 72 / 0.0254;
/// Cut marks end this far from the corner that they mark, so that no ink stays on what is cut out.
constexpr double kCutGapM = 0.0005, kCutLengthM = 0.003, kHairlineM = 0.0001;
constexpr double kFontM = 0.0025;
/// cairo holds no larger image surface.
constexpr double kMostPixels = 32'000;

/// Draws on one page, in metres from its top left.
class Pen {
 public:
  Pen(cairo_surface_t* surface, double units_per_metre) : cairo_(cairo_create(surface)) {
    cairo_scale(cairo_.get(), units_per_metre, units_per_metre);
    // cairo's own font: the same everywhere, also where none is installed.
    cairo_select_font_face(cairo_.get(), "@cairo:", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo_.get(), kFontM);
    cairo_set_line_width(cairo_.get(), kHairlineM);
  }

  void Colour(const PrintColour& colour) { cairo_set_source_rgb(cairo_.get(), colour.red, colour.green, colour.blue); }
  void AddRectangle(double x, double y, double width, double height) {
    cairo_rectangle(cairo_.get(), x, y, width, height);
  }
  /// All rectangles since the last time.
  void Fill() { cairo_fill(cairo_.get()); }
  void Line(double x0, double y0, double x1, double y1) {
    cairo_move_to(cairo_.get(), x0, y0);
    cairo_line_to(cairo_.get(), x1, y1);
    cairo_stroke(cairo_.get());
  }
  /// Made narrower where it would be wider than `most`. @param y of the baseline.
  void Text(const std::string& text, double x, double y, double most) {
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_.get(), text.c_str(), &extents);
    cairo_save(cairo_.get());
    cairo_translate(cairo_.get(), x, y);
    if (extents.x_advance > most) cairo_scale(cairo_.get(), most / extents.x_advance, 1);
    cairo_move_to(cairo_.get(), 0, 0);
    cairo_show_text(cairo_.get(), text.c_str());
    cairo_restore(cairo_.get());
  }
  /// From left to right, its head filled.
  void Arrow(double from, double to, double y) {
    const double head = std::min(0.0018, 0.5 * (to - from));
    Line(from, y, to - head, y);
    cairo_move_to(cairo_.get(), to, y);
    cairo_line_to(cairo_.get(), to - head, y - 0.5 * head);
    cairo_line_to(cairo_.get(), to - head, y + 0.5 * head);
    cairo_close_path(cairo_.get());
    cairo_fill(cairo_.get());
  }
  void Finish() { CheckCairo(cairo_status(cairo_.get())); }

 private:
  Cairo cairo_;
};

/// The cells. Light ones first, and under their dark neighbours too, dark ones over them: each edge is then drawn once,
/// and no renderer's smoothing lets paper shine through or moves it. All cells of a colour are one path: renderers
/// move single rectangles to whole dots.
void DrawBoard(Pen& pen, const SheetOptions& options, const PlacedMarker& marker) {
  const MarkerSize size = options.code.size();
  const std::string cells = CellColours(size, options.code.Encode(marker.id));
  const Eigen::Vector2d cell = options.CellM();
  const auto add = [&](double row, double col, double rows, double cols) {
    pen.AddRectangle(marker.x_m + col * cell.x(), marker.y_m + row * cell.y(), cols * cell.x(), rows * cell.y());
  };
  for (const char colour : {'W', 'Y', 'K', 'B'}) {
    for (int row = 0; row < size.rows; ++row)
      for (int col = 0; col < size.cols; ++col) {
        if (cells[static_cast<std::size_t>(row * size.cols + col)] != colour) continue;
        if (IsDark(row, col)) {
          add(row, col, 1, 1);
          continue;
        }
        const double left = col > 0 ? 0.5 : 0, right = col + 1 < size.cols ? 0.5 : 0;
        const double up = row > 0 ? 0.5 : 0, down = row + 1 < size.rows ? 0.5 : 0;
        add(row, col - left, 1, 1 + left + right);
        add(row - up, col, 1 + up + down, 1);
      }
    pen.Colour(options.inks.Of(colour));
    pen.Fill();
  }
}

void DrawCutMarks(Pen& pen, double gap_m, double left, double top, double right, double bottom) {
  // Not into the neighbours.
  const double length = std::min(kCutLengthM, gap_m - kCutGapM);
  for (const double y : {top, bottom}) {
    pen.Line(left - kCutGapM - length, y, left - kCutGapM, y);
    pen.Line(right + kCutGapM, y, right + kCutGapM + length, y);
  }
  for (const double x : {left, right}) {
    pen.Line(x, top - kCutGapM - length, x, top - kCutGapM);
    pen.Line(x, bottom + kCutGapM, x, bottom + kCutGapM + length);
  }
}

void DrawScaleBar(Pen& pen, const SheetOptions& options, const SheetLayout& layout, std::size_t page) {
  const double x = options.border_m, y = options.paper.height_m - options.border_m - 0.004;
  constexpr double kTickM = 0.002, kCentimetre = 0.01;
  pen.Line(x, y, x + layout.scale_bar_m, y);
  for (int i = 0; i * kCentimetre <= layout.scale_bar_m + 1e-9; ++i)
    pen.Line(x + i * kCentimetre, y - kTickM, x + i * kCentimetre, y + kTickM);
  const std::string text = fmt::format(
      "{} must be {:g} mm long; if not, print without \"fit to page\". Page {} of {}. Arrows point forward "
      "(x of the marker).",
      layout.upright_bar_m > 0 ? "These bars" : "This bar", layout.scale_bar_m * 1000, page + 1, layout.pages.size());
  pen.Text(text, x, y + 0.004, options.paper.width_m - 2 * options.border_m);
  if (layout.upright_bar_m <= 0) return;
  // Printers stretch what they feed otherwise than what they write along.
  const double beside = options.border_m - kUprightBarRoomM + kTickM;
  pen.Line(beside, y, beside, y - layout.upright_bar_m);
  for (int i = 0; i * kCentimetre <= layout.upright_bar_m + 1e-9; ++i)
    pen.Line(beside - kTickM, y - i * kCentimetre, beside + kTickM, y - i * kCentimetre);
}

/// A marker's own x axis, in the small print: where the robot's front belongs.
void DrawCaption(Pen& pen, const SheetOptions& options, const SheetLayout& layout, const PlacedMarker& marker,
                 double left, double bottom) {
  const double arrow = std::min(0.007, 0.25 * layout.tile_width_m), right = left + layout.tile_width_m - 0.0005;
  pen.Text(Caption(options, marker.id), left + 0.0005, bottom + kFontM, layout.tile_width_m - arrow - 0.002);
  pen.Arrow(right - arrow, right, bottom + 0.6 * kFontM);
}

void DrawPage(cairo_surface_t* surface, double units_per_metre, const SheetOptions& options, const SheetLayout& layout,
              std::size_t page) {
  Pen pen(surface, units_per_metre);
  pen.Colour({1, 1, 1});
  pen.AddRectangle(0, 0, options.paper.width_m, options.paper.height_m);
  pen.Fill();
  const MarkerSize size = options.code.size();
  const Eigen::Vector2d cell = options.CellM(), margin = options.margin_cells * cell;
  for (const PlacedMarker& marker : layout.pages[page]) {
    const double left = marker.x_m - margin.x(), top = marker.y_m - margin.y();
    const double bottom = marker.y_m + size.rows * cell.y() + margin.y();
    DrawBoard(pen, options, marker);
    pen.Colour({0, 0, 0});
    DrawCaption(pen, options, layout, marker, left, bottom);
    DrawCutMarks(pen, options.gap_m, left, top, left + layout.tile_width_m, bottom + layout.caption_m);
  }
  pen.Colour({0, 0, 0});
  DrawScaleBar(pen, options, layout, page);
  pen.Finish();
}

std::string SuffixOf(std::size_t page, const SheetLayout& layout) {
  return layout.pages.size() == 1 ? "" : fmt::format("-{}", page + 1);
}

}  // namespace

PrintedFile DrawPdf(const SheetOptions& options, const SheetLayout& layout) {
  PrintedFile file;
  const CairoSurface surface(cairo_pdf_surface_create_for_stream(
      AppendToBytes, &file.bytes, options.paper.width_m * kPointsPerMetre, options.paper.height_m * kPointsPerMetre));
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, "chequer markers");
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATOR, "chequer print");
  for (std::size_t page = 0; page < layout.pages.size(); ++page) {
    DrawPage(surface.get(), kPointsPerMetre, options, layout, page);
    cairo_surface_show_page(surface.get());
  }
  cairo_surface_finish(surface.get());
  CheckCairo(cairo_surface_status(surface.get()));
  return file;
}

std::vector<PrintedFile> DrawSvg(const SheetOptions& options, const SheetLayout& layout) {
  std::vector<PrintedFile> files;
  for (std::size_t page = 0; page < layout.pages.size(); ++page) {
    PrintedFile& file = files.emplace_back(PrintedFile{SuffixOf(page, layout), {}});
    // SVG's points are of a type that cairo writes as "pt": true size in every viewer.
    const CairoSurface surface(cairo_svg_surface_create_for_stream(
        AppendToBytes, &file.bytes, options.paper.width_m * kPointsPerMetre, options.paper.height_m * kPointsPerMetre));
    DrawPage(surface.get(), kPointsPerMetre, options, layout, page);
    cairo_surface_finish(surface.get());
    CheckCairo(cairo_surface_status(surface.get()));
  }
  return files;
}

std::vector<PrintedFile> DrawPng(const SheetOptions& options, const SheetLayout& layout, double dots_per_inch) {
  const double per_metre = dots_per_inch / 0.0254;
  const double width = options.paper.width_m * per_metre, height = options.paper.height_m * per_metre;
  if (!(width <= kMostPixels && height <= kMostPixels))
    throw std::runtime_error(
        fmt::format("a page would have {:.0f} x {:.0f} pixels, at most {:.0f} each fit; use fewer "
                    "dots per inch, or PDF",
                    width, height, kMostPixels));
  std::vector<PrintedFile> files;
  for (std::size_t page = 0; page < layout.pages.size(); ++page) {
    const CairoSurface surface(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width + 0.5), static_cast<int>(height + 0.5)));
    DrawPage(surface.get(), per_metre, options, layout, page);
    std::vector<std::uint8_t> bytes;
    CheckCairo(cairo_surface_write_to_png_stream(surface.get(), AppendToBytes, &bytes));
    files.push_back({SuffixOf(page, layout), WithPixelSize(bytes, per_metre)});
  }
  return files;
}

}  // namespace chequer
