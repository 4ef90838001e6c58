#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/marker.h"

namespace chequer {

/// Width and height of a sheet, metres.
struct PaperSize {
  double width_m = 0.210;
  double height_m = 0.297;
};

/// "A0" … "A6", "letter", "legal", "tabloid" (any case), or WIDTHxHEIGHT in millimetres such as "330x480mm"; nothing
/// for anything else.
std::optional<PaperSize> ParsePaper(std::string_view name);

/// What ParsePaper knows, for messages.
std::string PaperNames();

/// A colour as it is sent to the printer: sRGB, 0..1.
struct PrintColour {
  double red = 0;
  double green = 0;
  double blue = 0;
  bool operator==(const PrintColour&) const = default;
};

/// "#RRGGBB", or nothing.
std::optional<PrintColour> ParseColour(std::string_view text);

/// The four colours of cells.
struct PrintInks {
  PrintColour black{0, 0, 0};
  PrintColour white{1, 1, 1};
  PrintColour blue{0, 0, 1};
  PrintColour yellow{1, 1, 0};

  /// @pre cell is 'K', 'W', 'B' or 'Y'.
  const PrintColour& Of(char cell) const;
  /// Empty, or which colours cannot be told apart: dark ones must be darker than light ones by half the range,
  /// saturated ones more saturated than the others.
  std::string Check() const;
};

/// "pure" (the default: full blue and yellow), "laser" (a blue with less magenta, which lasers print as violet),
/// "inkjet" (darker blue, warmer yellow, as ink on plain paper pales). Nothing if there is no such set.
std::optional<PrintInks> NamedPrintInks(std::string_view name);
std::string PrintInkNames();

/// What is to be printed.
struct SheetOptions {
  MarkerCode code{MarkerSize{}, Variant::kSecded};
  std::vector<std::uint64_t> ids;
  double side_m = 0.06;  ///< of the longer side of the board, cells included
  /// Width and height of the board, where they are not side_m's: for a printer that stretches one of them.
  Eigen::Vector2d printed_m = Eigen::Vector2d::Zero();
  PaperSize paper;
  double border_m = 0.010;  ///< of the page, which printers leave white
  double margin_cells = 1;  ///< plain border round each board
  double gap_m = 0.004;     ///< between markers, for cutting
  PrintInks inks;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
  Eigen::Vector2d CellM() const;  ///< width and height of a cell
};

/// A marker on a page.
struct PlacedMarker {
  std::uint64_t id = 0;
  double x_m = 0;  ///< of the board's left side, from the page's left
  double y_m = 0;  ///< of the board's top, from the page's top
};

/// How much of a page's border the upright bar takes.
inline constexpr double kUprightBarRoomM = 0.005;

/// Where things stand on a page, the same for all pages; metres.
struct SheetLayout {
  int columns = 0;
  int rows = 0;
  double tile_width_m = 0;  ///< board, margin and caption
  double tile_height_m = 0;
  double caption_m = 0;    ///< height of the small print under each margin
  double scale_bar_m = 0;  ///< length of the bar to check the printer with
  /// Length of the bar up the left border: the same, or 0 where there is no room for it.
  double upright_bar_m = 0;
  std::vector<std::vector<PlacedMarker>> pages;
};

/// As many markers a page as fit, row by row in the order of the ids, centred. Throws std::runtime_error with Check's
/// message, or saying how large a marker the paper holds where not one fits.
SheetLayout LayOutSheet(const SheetOptions& options);

/// Small print of a marker: "17  6x6 secded  60 mm".
std::string Caption(const SheetOptions& options, std::uint64_t id);

}  // namespace chequer
