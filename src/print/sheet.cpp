#include "print/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace chequer {
namespace {

/// Height of the small print; two millimetres can be read at arm's length.
constexpr double kCaptionM = 0.004;
/// Height that the scale bar with its text needs at the foot of a page.
constexpr double kFootM = 0.010;
/// Longest scale bar: an error of 0.2 % is 0.2 mm on it, which a steel ruler shows.
constexpr double kScaleBarM = 0.1;
constexpr std::size_t kMostMarkers = 20'000;

struct NamedPaper {
  std::string_view name;
  PaperSize size;
};
constexpr std::array<NamedPaper, 10> kPapers{{{"A0", {0.841, 1.189}},
                                              {"A1", {0.594, 0.841}},
                                              {"A2", {0.420, 0.594}},
                                              {"A3", {0.297, 0.420}},
                                              {"A4", {0.210, 0.297}},
                                              {"A5", {0.148, 0.210}},
                                              {"A6", {0.105, 0.148}},
                                              {"letter", {0.2159, 0.2794}},
                                              {"legal", {0.2159, 0.3556}},
                                              {"tabloid", {0.2794, 0.4318}}}};

struct NamedInkSet {
  std::string_view name;
  PrintInks inks;
};
const std::array<NamedInkSet, 3> kInks{
    {{"pure", {}},
     {"laser", {.black = {0, 0, 0}, .white = {1, 1, 1}, .blue = {0, 0.25, 0.9}, .yellow = {1, 0.92, 0}}},
     {"inkjet", {.black = {0, 0, 0}, .white = {1, 1, 1}, .blue = {0, 0.1, 0.75}, .yellow = {1, 0.85, 0}}}}};

bool SameWord(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

std::optional<double> ParseNumber(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// Half the sum of red and green is what tells dark from light, blue against yellow what tells saturation.
double Luminance(const PrintColour& colour) { return (colour.red + colour.green) / 2; }
double Blueness(const PrintColour& colour) { return colour.blue - Luminance(colour); }

/// How many things of a length fit into a room, gaps between them.
int CountFitting(double room_m, double length_m, double gap_m) {
  // A whole number of them must not be lost to rounding.
  return static_cast<int>(std::floor((room_m + gap_m) / (length_m + gap_m) + 1e-9));
}

std::string TooLarge(const SheetOptions& options, double room_width_m, double room_height_m) {
  const MarkerSize size = options.code.size();
  const double cell = std::min(room_width_m / (size.cols + 2 * options.margin_cells),
                               (room_height_m - kCaptionM) / (size.rows + 2 * options.margin_cells));
  const double most = cell * std::max(size.rows, size.cols);
  return fmt::format("markers of {:g} mm do not fit on paper of {:g} x {:g} mm; at most {:g} mm do, with their margin",
                     options.side_m * 1000, options.paper.width_m * 1000, options.paper.height_m * 1000,
                     std::floor(std::max(most, 0.0) * 1000));
}

}  // namespace

std::optional<PaperSize> ParsePaper(std::string_view name) {
  for (const NamedPaper& paper : kPapers)
    if (SameWord(paper.name, name)) return paper.size;
  if (name.ends_with("mm")) name.remove_suffix(2);
  const std::size_t times = name.find('x');
  if (times == std::string_view::npos) return std::nullopt;
  const auto width = ParseNumber(name.substr(0, times)), height = ParseNumber(name.substr(times + 1));
  // The largest plotters' rolls; PDF holds no more than 5 m either.
  if (!width || !height || !(*width >= 30 && *width <= 5000 && *height >= 30 && *height <= 5000)) return std::nullopt;
  return PaperSize{*width / 1000, *height / 1000};
}

std::string PaperNames() {
  std::string names;
  for (const NamedPaper& paper : kPapers) names.append(paper.name).append(", ");
  return names + "or WIDTHxHEIGHT in millimetres, 30 to 5000, such as 330x480mm";
}

std::optional<PrintColour> ParseColour(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  unsigned rgb = 0;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 7, rgb, 16);
  if (error != std::errc() || end != text.data() + 7) return std::nullopt;
  return PrintColour{(rgb >> 16) / 255.0, (rgb >> 8 & 255) / 255.0, (rgb & 255) / 255.0};
}

const PrintColour& PrintInks::Of(char cell) const {
  switch (cell) {
    case 'W': return white;
    case 'B': return blue;
    case 'Y': return yellow;
    default: return black;
  }
}

std::string PrintInks::Check() const {
  if (std::max(Luminance(black), Luminance(blue)) > std::min(Luminance(white), Luminance(yellow)) - 0.5)
    return "black and blue must be much darker in red and green than white and yellow, by half the range at least";
  if (Blueness(blue) < Blueness(black) + 0.3) return "blue must have more blue against its red and green than black";
  if (Blueness(yellow) > Blueness(white) - 0.3)
    return "yellow must have less blue against its red and green than white";
  return "";
}

std::optional<PrintInks> NamedPrintInks(std::string_view name) {
  for (const NamedInkSet& set : kInks)
    if (set.name == name) return set.inks;
  return std::nullopt;
}

std::string PrintInkNames() {
  std::string names;
  for (const NamedInkSet& set : kInks) names.append(names.empty() ? "" : ", ").append(set.name);
  return names;
}

Eigen::Vector2d SheetOptions::CellM() const {
  const MarkerSize size = code.size();
  if (printed_m.isZero()) return Eigen::Vector2d::Constant(side_m / std::max(size.rows, size.cols));
  return {printed_m.x() / size.cols, printed_m.y() / size.rows};
}

std::string SheetOptions::Check() const {
  if (ids.empty()) return "no ids: at least one must be given";
  if (ids.size() > kMostMarkers) return fmt::format("{} markers are more than {}", ids.size(), kMostMarkers);
  for (const std::uint64_t id : ids)
    if (id > code.max_id())
      return fmt::format("id {} is beyond {}, the largest of {} {}", id, code.max_id(), ToString(code.size()),
                         VariantName(code.variant()));
  if (!(side_m >= 0.002 && side_m <= 5)) return "the side must be from 2 mm to 5 m";
  if (!(margin_cells >= 0 && margin_cells <= 10)) return "the margin must be from 0 to 10 cells";
  if (!(border_m >= 0 && border_m <= 0.1)) return "the border of the page must be from 0 to 100 mm";
  // Less leaves no room for cut marks.
  if (!(gap_m >= 0.002 && gap_m <= 0.1)) return "the gap between markers must be from 2 to 100 mm";
  return inks.Check();
}

SheetLayout LayOutSheet(const SheetOptions& options) {
  if (const std::string wrong = options.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  const MarkerSize size = options.code.size();
  const Eigen::Vector2d cell = options.CellM(), margin = options.margin_cells * cell;
  SheetLayout layout;
  layout.caption_m = kCaptionM;
  layout.tile_width_m = size.cols * cell.x() + 2 * margin.x();
  layout.tile_height_m = size.rows * cell.y() + 2 * margin.y() + kCaptionM;
  const double width = options.paper.width_m - 2 * options.border_m;
  const double height = options.paper.height_m - 2 * options.border_m - kFootM;
  layout.scale_bar_m = std::min(kScaleBarM, std::floor(std::max(width, 0.01) * 100) / 100);
  if (options.border_m >= kUprightBarRoomM && height >= layout.scale_bar_m) layout.upright_bar_m = layout.scale_bar_m;
  layout.columns = CountFitting(width, layout.tile_width_m, options.gap_m);
  layout.rows = CountFitting(height, layout.tile_height_m, options.gap_m);
  if (layout.columns < 1 || layout.rows < 1) throw std::runtime_error(TooLarge(options, width, height));
  const double used_width = layout.columns * (layout.tile_width_m + options.gap_m) - options.gap_m;
  const double used_height = layout.rows * (layout.tile_height_m + options.gap_m) - options.gap_m;
  const double left = options.border_m + (width - used_width) / 2, top = options.border_m + (height - used_height) / 2;
  const std::size_t a_page = static_cast<std::size_t>(layout.columns) * static_cast<std::size_t>(layout.rows);
  for (std::size_t i = 0; i < options.ids.size(); ++i) {
    if (i % a_page == 0) layout.pages.emplace_back();
    const int place = static_cast<int>(i % a_page);
    const int column = place % layout.columns, row = place / layout.columns;
    layout.pages.back().push_back({options.ids[i], left + column * (layout.tile_width_m + options.gap_m) + margin.x(),
                                   top + row * (layout.tile_height_m + options.gap_m) + margin.y()});
  }
  return layout;
}

std::string Caption(const SheetOptions& options, std::uint64_t id) {
  const std::string side = options.printed_m.isZero()
                               ? fmt::format("{:g}", options.side_m * 1000)
                               : fmt::format("{:g} x {:g}", options.printed_m.x() * 1000, options.printed_m.y() * 1000);
  return fmt::format("{}  {} {}  {} mm", id, ToString(options.code.size()), VariantName(options.code.variant()), side);
}

}  // namespace chequer
