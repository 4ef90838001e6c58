#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "chequer/camera_file.h"
#include "core/file.h"
#include "core/length.h"
#include "core/suggestion.h"
#include "print/draw.h"
#include "tools/commands.h"
#include "tools/length_option.h"
#include "tools/marker_options.h"
#include "tools/setup_option.h"

namespace chequer {
namespace {

/// The options as typed.
struct PrintRequest {
  std::string config;
  std::string marker = "6x6";
  std::string variant = "secded";
  std::string table;
  std::string ids;
  std::string side;
  std::string paper = "A4";
  bool landscape = false;
  std::string border = "10mm";
  std::string gap = "4mm";
  double margin_cells = 1;
  std::string inks = "pure";
  std::string blue, yellow, black;
  bool names_kind = false;  ///< whether --marker, --variant or --table was typed
  double dots_per_inch = 300;
  std::string calibration;
  std::optional<double> focal_px;
  std::string distance;
  std::string out;
};

enum class SheetFormat { kPdf, kSvg, kPng };

SheetFormat FormatOf(const std::filesystem::path& out) {
  std::string extension = out.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".pdf") return SheetFormat::kPdf;
  if (extension == ".svg") return SheetFormat::kSvg;
  if (extension == ".png") return SheetFormat::kPng;
  throw CLI::ValidationError("--out", "'" + out.string() + "' must end in .pdf, .svg or .png");
}

PrintInks PlanInks(const PrintRequest& request) {
  auto inks = NamedPrintInks(request.inks);
  if (!inks) throw CLI::ValidationError("--inks", UnknownWord("known", request.inks, WordsOf(PrintInkNames())));
  const auto replace = [](const char* option, const std::string& text, PrintColour& colour) {
    if (text.empty()) return;
    const auto parsed = ParseColour(text);
    if (!parsed) throw CLI::ValidationError(option, "'" + text + "' is not a colour; write it as #RRGGBB");
    colour = *parsed;
  };
  replace("--blue", request.blue, inks->blue);
  replace("--yellow", request.yellow, inks->yellow);
  replace("--black", request.black, inks->black);
  if (const std::string wrong = inks->Check(); !wrong.empty()) throw CLI::ValidationError("--inks", wrong);
  return *inks;
}

/// The kind that the options name, else the configuration's first.
MarkerFamily PlanFamily(const PrintRequest& request, const std::optional<CameraSetup>& setup) {
  MarkerOptions markers;
  markers.markers = {request.marker};
  markers.variant = request.variant;
  markers.table = request.table;
  markers.ids = request.ids;
  markers.names_kind = request.names_kind;
  if (!request.side.empty()) {
    markers.printed_m = ParseWidthAndHeight(request.side);
    markers.side_m = markers.printed_m ? markers.printed_m->maxCoeff() : ParseLengthOption("--side", request.side);
  }
  MarkerFamily family = ChooseMarkerFamilies(markers, setup, true).front();
  if (!request.ids.empty())
    family.roster = ParseRoster(request.ids);
  else if (family.roster.empty())
    throw CLI::ValidationError("--ids", setup ? "is missing, and " + setup->file.string() + " has no roster of ids"
                                              : "is missing: which markers to print, such as 0-49");
  return family;
}

SheetOptions PlanSheet(const PrintRequest& request, const std::optional<CameraSetup>& setup) {
  SheetOptions sheet;
  const MarkerFamily family = PlanFamily(request, setup);
  sheet.code = family.code;
  sheet.ids = family.roster;
  sheet.side_m = family.side_m;
  sheet.printed_m = family.printed_m;
  const auto paper = ParsePaper(request.paper);
  if (!paper) throw CLI::ValidationError("--paper", UnknownWord("known", request.paper, WordsOf(PaperNames())));
  sheet.paper = *paper;
  if (request.landscape) std::swap(sheet.paper.width_m, sheet.paper.height_m);
  sheet.border_m = ParseLengthOption("--border", request.border);
  sheet.gap_m = ParseLengthOption("--gap", request.gap);
  sheet.margin_cells = request.margin_cells;
  sheet.inks = PlanInks(request);
  if (!(request.dots_per_inch >= 30 && request.dots_per_inch <= 4800))
    throw CLI::ValidationError("--dpi", fmt::format("{} is outside 30 to 4800", request.dots_per_inch));
  if (const std::string wrong = sheet.Check(); !wrong.empty())
    throw CLI::ValidationError(wrong + DidYouMeanMillimetres(request.side));
  return sheet;
}

/// Pixels of focal length, if a camera was given.
std::optional<double> FocalPx(const PrintRequest& request, const std::optional<CameraSetup>& setup) {
  if (setup && setup->calibration && request.calibration.empty() && !request.focal_px && !request.distance.empty()) {
    const CameraModel camera = LoadCamera(*setup->calibration);
    return std::min(camera.fx, camera.fy);
  }
  const bool has_camera = !request.calibration.empty() || request.focal_px.has_value();
  if (has_camera != !request.distance.empty())
    throw CLI::ValidationError("--distance", "goes with --calibration or --focal: how far away the markers will be");
  if (!request.calibration.empty() && request.focal_px)
    throw CLI::ValidationError("--focal", "is already said by --calibration; give one of them");
  if (!request.calibration.empty()) {
    const CameraModel camera = LoadCamera(request.calibration);
    return std::min(camera.fx, camera.fy);
  }
  if (request.focal_px && !(*request.focal_px > 0)) throw CLI::ValidationError("--focal", "must be above 0 pixels");
  return request.focal_px;
}

/// Warns where a camera will not read the markers.
void WarnOfSmallCells(const SheetOptions& sheet, double focal_px, double distance_m) {
  const double cell_m = sheet.CellM().minCoeff(), cell_px = focal_px * cell_m / distance_m;
  if (cell_px >= kSafeCellPx) return;
  const double side_m = kSafeCellPx * distance_m / focal_px * std::max(sheet.code.size().rows, sheet.code.size().cols);
  fmt::print(stderr,
             "chequer print: warning: cells are {:.2f} px wide at {:g} m; below {:g} px markers are missed. A side of "
             "{:.0f} mm would do, or at most {:.2f} m\n",
             cell_px, distance_m, kSafeCellPx, std::ceil(side_m * 1000 - 1e-6), focal_px * cell_m / kSafeCellPx);
}

void RunPrint(const PrintRequest& request) {
  const std::filesystem::path out = request.out;
  const SheetFormat format = FormatOf(out);
  const std::optional<CameraSetup> setup = LoadSetup(request.config);
  const SheetOptions sheet = PlanSheet(request, setup);
  const std::optional<double> focal_px = FocalPx(request, setup);
  const SheetLayout layout = LayOutSheet(sheet);
  std::vector<PrintedFile> files;
  switch (format) {
    case SheetFormat::kPdf: files.push_back(DrawPdf(sheet, layout)); break;
    case SheetFormat::kSvg: files = DrawSvg(sheet, layout); break;
    case SheetFormat::kPng: files = DrawPng(sheet, layout, request.dots_per_inch); break;
  }
  for (const PrintedFile& file : files) {
    const std::filesystem::path name =
        out.parent_path() / (out.stem().string() + file.suffix + out.extension().string());
    WriteFileAtomically(name, file.bytes);
  }
  fmt::print("{} marker{} of {:g} mm on {} page{}, {} x {} a page: {}\n", sheet.ids.size(),
             sheet.ids.size() == 1 ? "" : "s", sheet.side_m * 1000, layout.pages.size(),
             layout.pages.size() == 1 ? "" : "s", layout.columns, layout.rows, request.out);
  if (focal_px) WarnOfSmallCells(sheet, *focal_px, ParseLengthOption("--distance", request.distance));
}

void AddOptions(CLI::App& command, PrintRequest& request) {
  const auto note_kind = [&request](const std::string&) { request.names_kind = true; };
  AddSetupOption(command, request.config, "kind, ids, side and camera file");
  command.add_option("--marker", request.marker, "Size in cells")
      ->type_name("ROWSxCOLS")
      ->capture_default_str()
      ->each(note_kind);
  command.add_option("--variant", request.variant, "How ids are coded (chequer detect --help lists them)")
      ->capture_default_str()
      ->each(note_kind);
  command.add_option("--table", request.table, "File of kernels for the variant table")
      ->type_name("FILE")
      ->each(note_kind);
  command.add_option("--ids", request.ids, "Which to print, such as 0-49,77 [the roster of the configuration]")
      ->type_name("LIST");
  command
      .add_option(
          "--side", request.side,
          "Longer side of the board, cells included: 60mm, 6cm or 0.06 (metres); or width and height, 59.8x60mm, "
          "for a printer that stretches one")
      ->type_name("LENGTH");
  command.add_option("--paper", request.paper, PaperNames())->capture_default_str();
  command.add_flag("--landscape", request.landscape, "Turn the paper");
  command.add_option("--border", request.border, "Of the page, left white")->type_name("LENGTH")->capture_default_str();
  command.add_option("--gap", request.gap, "Between markers")->type_name("LENGTH")->capture_default_str();
  command.add_option("--margin", request.margin_cells, "Plain border round each board, cells")
      ->type_name("CELLS")
      ->capture_default_str();
  command.add_option("--inks", request.inks, PrintInkNames())->type_name("SET")->capture_default_str();
  command.add_option("--blue", request.blue, "Instead of the set's")->type_name("#RRGGBB");
  command.add_option("--yellow", request.yellow, "Instead of the set's")->type_name("#RRGGBB");
  command.add_option("--black", request.black, "Instead of the set's")->type_name("#RRGGBB");
  command.add_option("--dpi", request.dots_per_inch, "Dots per inch of PNG")->type_name("N")->capture_default_str();
  command.add_option("--out", request.out, "File to write: .pdf, .svg or .png")->required()->type_name("FILE");
  const char* check = "Will they be read?";
  command.add_option("--calibration", request.calibration, "Camera file")->type_name("FILE")->group(check);
  command.add_option("--focal", request.focal_px, "Or its focal length, pixels")->type_name("PX")->group(check);
  command.add_option("--distance", request.distance, "From the camera")->type_name("LENGTH")->group(check);
}

}  // namespace

void AddPrintCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand("print", "Draws sheets of markers to print, in true size");
  // Shared, as the callback outlives this function and std::function copies what it holds.
  const auto request = std::make_shared<PrintRequest>();
  AddOptions(*command, *request);
  command->footer(
      "Print without \"fit to page\" and hold a ruler to the bars at the foot and at the left. The arrow below each "
      "marker\n"
      "points forward, along its x axis. SVG and PNG of several pages are files\n"
      "sheet-1.svg, sheet-2.svg, …\n\n"
      "The robots of the configuration north:\n"
      "  chequer print --config north --out sheet.pdf\n"
      "Fifty markers for robots that a camera sees from 3 m:\n"
      "  chequer print --variant secded --marker 6x6 --ids 0-49 --side 60mm --paper A4 --out sheet.pdf \\\n"
      "    --calibration camera.toml --distance 3m");
  command->callback([request] { RunPrint(*request); });
}

}  // namespace chequer
