#include "tools/marker_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/length.h"
#include "core/suggestion.h"
#include "marker/variants.h"
#include "tools/length_option.h"

namespace chequer {
namespace {

/// More ids than any table of one's own; keeps a typing error such as 0-4900000000 from filling the memory.
constexpr std::uint64_t kMaxRosterSize = 1'000'000;

std::vector<std::string> KnownVariants() {
  std::vector<std::string> names;
  for (const auto& [name, variant] : kVariants) names.emplace_back(name);
  return names;
}

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t start = 0;
  for (std::size_t end; (end = text.find(separator, start)) != std::string::npos; start = end + 1)
    parts.push_back(text.substr(start, end - start));
  parts.push_back(text.substr(start));
  return parts;
}

template <typename Number>
std::optional<Number> ParseNumber(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

MarkerSize ParseSize(const std::string& text) {
  const auto size = ParseMarkerSize(text);
  if (!size)
    throw CLI::ValidationError("--marker", "'" + text +
                                               "' is not a marker size; it must be ROWSxCOLS such as 6x6, at least "
                                               "3x3, with at most 64 cells inside the border");
  return *size;
}

/// Metres. A bare number that looks like millimetres is taken as metres, as ever, and remarked upon.
double ParseSide(const char* option, const std::string& typed) {
  const double side_m = ParseLengthOption(option, typed);
  if (const std::string hint = DidYouMeanMillimetres(typed); !hint.empty())
    fmt::print(stderr, "chequer: warning: {} {} is {}{}\n", option, typed, LengthText(side_m), hint);
  return side_m;
}

Variant ParseVariantOption(const char* option, const std::string& name) {
  const auto variant = ParseVariant(name);
  if (!variant) throw CLI::ValidationError(option, UnknownWord("a variant", name, KnownVariants()));
  return *variant;
}

MarkerCode MakeCode(MarkerSize size, Variant variant, const std::string& table) {
  if (variant == Variant::kTable) {
    if (table.empty()) throw CLI::ValidationError("--table", "the variant table needs --table FILE with its kernels");
    return MarkerCode::LoadTable(size, table);
  }
  try {
    return MarkerCode(size, variant);
  } catch (const std::runtime_error& error) {
    throw CLI::ValidationError("--marker", error.what());
  }
}

void SetPrinted(const char* option, const Eigen::Vector2d& printed_m, MarkerFamily& family) {
  if (!family.SetPrinted(printed_m))
    throw CLI::ValidationError(option, "must be the width and height of a board of nearly square cells");
}

/// By --side, if that was typed.
void SetSide(const MarkerOptions& options, MarkerFamily& family) {
  if (!options.side_m) return;
  family.printed_m.setZero();
  family.side_m = *options.side_m;
  if (options.printed_m) SetPrinted("--side", *options.printed_m, family);
}

MarkerFamily ParseFamily(const std::string& text, const MarkerOptions& options) {
  const std::vector<std::string> parts = Split(text, ':');
  if (parts.size() > 3)
    throw CLI::ValidationError("--marker",
                               "'" + text + "' must be SIZE or SIZE:VARIANT:SIDE, such as 6x6:secded:120mm");
  const MarkerSize size = ParseSize(parts[0]);
  const Variant variant =
      parts.size() > 1 ? ParseVariantOption("--marker", parts[1]) : ParseVariantOption("--variant", options.variant);
  MarkerFamily family{.code = MakeCode(size, variant, options.table), .side_m = 0, .roster = {}};
  if (parts.size() > 2) {
    if (const auto printed = ParseWidthAndHeight(parts[2]))
      SetPrinted("--marker", *printed, family);
    else
      family.side_m = ParseSide("--marker", parts[2]);
  } else {
    SetSide(options, family);
  }
  return family;
}

/// "6x6 secded, ids 0 to 2047".
std::string Describe(const MarkerCode& code) {
  return ToString(code.size()) + " " + std::string(VariantName(code.variant())) + ", ids 0 to " +
         std::to_string(code.max_id());
}

/// Gives each family the ids it has; an id that none has is a typing error.
void LimitToRoster(std::vector<MarkerFamily>& families, const std::vector<std::uint64_t>& ids) {
  std::string all_families;
  std::uint64_t largest = 0;
  for (const MarkerFamily& family : families) {
    all_families.append(all_families.empty() ? "" : "; ").append(Describe(family.code));
    largest = std::max(largest, family.code.max_id());
  }
  const auto beyond = std::find_if(ids.begin(), ids.end(), [&](std::uint64_t id) { return id > largest; });
  if (beyond != ids.end())
    throw CLI::ValidationError("--ids", "no marker has the id " + std::to_string(*beyond) + " (" + all_families + ")");
  for (MarkerFamily& family : families) {
    family.roster.clear();
    std::copy_if(ids.begin(), ids.end(), std::back_inserter(family.roster),
                 [&](std::uint64_t id) { return id <= family.code.max_id(); });
    // An empty roster would mean all ids.
    if (family.roster.empty()) throw CLI::ValidationError("--ids", "names no id of " + Describe(family.code));
  }
}

void CheckSide(const MarkerOptions& options) {
  if (options.side_m && !(std::isfinite(*options.side_m) && *options.side_m > 0))
    throw CLI::ValidationError("--side", fmt::format("{} is not a length; it must be above 0", *options.side_m));
}

void CheckSidesThere(const std::vector<MarkerFamily>& families) {
  for (const MarkerFamily& family : families)
    if (family.side_m == 0)
      throw CLI::ValidationError(
          "--side", "a side is missing: poses need the side of the board, such as --side 0.12 or --side 120mm");
}

}  // namespace

void AddMarkerOptions(CLI::App& command, MarkerOptions& options) {
  const auto note_kind = [&options](const std::string&) { options.names_kind = true; };
  command
      .add_option("--marker", options.markers,
                  "Size ROWSxCOLS, or SIZE:VARIANT:SIDE in one; repeat it to seek several kinds")
      ->type_name("SIZE[:VARIANT[:SIDE]]")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false)
      ->capture_default_str()
      ->each(note_kind);
  command
      .add_option("--variant", options.variant, fmt::format("How ids are coded: {}", fmt::join(KnownVariants(), ", ")))
      ->capture_default_str()
      ->each(note_kind);
  const auto set_side = [&options](const std::string& typed) {
    options.printed_m = ParseWidthAndHeight(typed);
    options.side_m = options.printed_m ? options.printed_m->maxCoeff() : ParseSide("--side", typed);
  };
  command
      .add_option_function<std::string>("--side", set_side,
                                        "Longer side of the whole board, cells included: 60mm, 6cm or 0.06 (metres); "
                                        "or width and height as printed: 60.3x60.1mm")
      ->type_name("LENGTH");
  command.add_option("--table", options.table, "File of kernels for the variant table: one a line, digits 0 and 1")
      ->type_name("FILE")
      ->each(note_kind);
  command.add_option("--ids", options.ids, "Ids in use, such as 0-49,77; all others are not considered")
      ->type_name("LIST");
}

std::optional<Eigen::Vector2d> ParseWidthAndHeight(const std::string& text) {
  const std::size_t times = text.find('x');
  if (times == std::string::npos) return std::nullopt;
  std::string width = text.substr(0, times);
  const std::string height = text.substr(times + 1);
  // The unit may stand once, behind both.
  if (const std::size_t digits = width.find_last_of("0123456789."); digits + 1 == width.size())
    width += height.substr(std::min(height.size(), height.find_last_of("0123456789.") + 1));
  const auto w = ParseLength(width), h = ParseLength(height);
  if (!w || !h || !(*w > 0 && *h > 0)) return std::nullopt;
  return Eigen::Vector2d(*w, *h);
}

std::vector<MarkerFamily> ParseMarkerFamilies(const MarkerOptions& options, bool need_sides) {
  CheckSide(options);
  std::vector<MarkerFamily> families;
  for (const std::string& marker : options.markers) families.push_back(ParseFamily(marker, options));
  if (need_sides) CheckSidesThere(families);
  const bool table_used = std::any_of(families.begin(), families.end(), [](const MarkerFamily& family) {
    return family.code.variant() == Variant::kTable;
  });
  if (!options.table.empty() && !table_used)
    throw CLI::ValidationError("--table", "is only for the variant table; add --variant table, or leave it out");
  if (!options.ids.empty()) LimitToRoster(families, ParseRoster(options.ids));
  return families;
}

std::vector<MarkerFamily> ChooseMarkerFamilies(const MarkerOptions& options, const std::optional<CameraSetup>& setup,
                                               bool need_sides) {
  if (options.names_kind || !setup || setup->families.empty()) return ParseMarkerFamilies(options, need_sides);
  CheckSide(options);
  std::vector<MarkerFamily> families = setup->families;
  for (MarkerFamily& family : families) SetSide(options, family);
  if (need_sides) CheckSidesThere(families);
  if (!options.ids.empty()) LimitToRoster(families, ParseRoster(options.ids));
  return families;
}

std::vector<std::uint64_t> ParseRoster(const std::string& text) {
  std::vector<std::uint64_t> ids;
  for (const std::string& part : Split(text, ',')) {
    const std::size_t dash = part.find('-');
    const auto first = ParseNumber<std::uint64_t>(std::string_view(part).substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : ParseNumber<std::uint64_t>(std::string_view(part).substr(dash + 1));
    if (!first || !last || *last < *first)
      throw CLI::ValidationError("--ids", "'" + part + "' is neither an id nor a range; write them as in 0-49,77");
    if (*last - *first >= kMaxRosterSize - ids.size())
      throw CLI::ValidationError("--ids", "names more than " + std::to_string(kMaxRosterSize) + " ids");
    for (std::uint64_t id = *first;; ++id) {
      ids.push_back(id);
      if (id == *last) break;
    }
  }
  return ids;
}

}  // namespace chequer
