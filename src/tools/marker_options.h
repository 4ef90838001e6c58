#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "setup/camera_setup.h"

namespace chequer {

/// Smallest pitch of cells, pixels, that is read for sure; design measurements put the limit at 3.5 to 4 px.
inline constexpr double kSafeCellPx = 4;

/// The options that say which markers are meant, as typed. Several commands share them.
struct MarkerOptions {
  std::vector<std::string> markers{"6x6"};   ///< SIZE, or SIZE:VARIANT[:SIDE]
  std::string variant = "secded";            ///< for those that do not name theirs
  std::optional<double> side_m;              ///< for those that do not name theirs
  std::optional<Eigen::Vector2d> printed_m;  ///< width and height, where --side has both; side_m is the longer one then
  std::string table;                         ///< file of the kernels of the variant `table`
  std::string ids;                           ///< roster such as 0-49,77; empty: all
  bool names_kind = false;                   ///< whether --marker, --variant or --table was typed
};

/// Width and height of "80.2x80.4mm", metres; nothing where a text is no two lengths.
std::optional<Eigen::Vector2d> ParseWidthAndHeight(const std::string& text);

/// Adds --marker, --variant, --side, --table and --ids to a command. `options` must outlive the parsing.
void AddMarkerOptions(CLI::App& command, MarkerOptions& options);

/// The families that the options describe. Throws CLI::ValidationError naming the option, what is wrong and what would
/// be right; std::runtime_error where the table file cannot be read.
/// @param need_sides whether a family without a side is an error (poses or drawings are wanted).
std::vector<MarkerFamily> ParseMarkerFamilies(const MarkerOptions& options, bool need_sides);

/// The same where a configuration may say it: its families, unless the options name a kind; with the side and the ids
/// of the options, where those are typed. Throws as ParseMarkerFamilies.
/// @param setup nothing: as ParseMarkerFamilies.
std::vector<MarkerFamily> ChooseMarkerFamilies(const MarkerOptions& options, const std::optional<CameraSetup>& setup,
                                               bool need_sides);

/// "0-49,77" → 0, …, 49, 77. Throws CLI::ValidationError on anything else and on more than a million ids.
std::vector<std::uint64_t> ParseRoster(const std::string& text);

}  // namespace chequer
