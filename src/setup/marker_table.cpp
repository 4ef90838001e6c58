#include "setup/marker_table.h"

#include <charconv>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/suggestion.h"
#include "marker/variants.h"

namespace chequer {
namespace {

/// More than any table of one's own holds; keeps a typing error such as 0-4900000000 from filling the memory.
constexpr std::uint64_t kMaxRosterSize = 1'000'000;
constexpr NumberRange kSide{0.001, 99.0};  // what a detector accepts, from the smallest that anyone could print

std::optional<std::uint64_t> ParseId(std::string_view text) {
  std::uint64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return id;
}

/// Adds the ids of "17" or "0-49".
void AddIds(const TomlTable& table, const std::string& text, std::uint64_t max_id, std::vector<std::uint64_t>& ids) {
  const std::size_t dash = text.find('-');
  const auto first = ParseId(std::string_view(text).substr(0, dash));
  const auto last = dash == std::string::npos ? first : ParseId(std::string_view(text).substr(dash + 1));
  if (!first || !last || *last < *first)
    table.Fail("roster", "'" + text + "' is neither an id nor a range of ids; write them as [\"0-49\", \"77\"]");
  if (*last > max_id)
    table.Fail("roster", "'" + text + "' is beyond " + std::to_string(max_id) + ", the largest id of this kind");
  if (*last - *first >= kMaxRosterSize - ids.size())
    table.Fail("roster", "must name at most " + std::to_string(kMaxRosterSize) + " ids");
  for (std::uint64_t id = *first; id < *last; ++id) ids.push_back(id);
  ids.push_back(*last);
}

MarkerSize ReadSize(TomlTable& table) {
  std::string text;
  table.Require("size", text);
  const auto size = ParseMarkerSize(text);
  if (!size)
    table.Fail("size", "must be ROWSxCOLS such as \"6x6\", at least 3x3, with at most 64 cells inside the border");
  return *size;
}

Variant ReadVariant(TomlTable& table) {
  std::string text;
  table.Require("variant", text);
  if (const auto variant = ParseVariant(text)) return *variant;
  std::vector<std::string> known;
  for (const auto& [name, variant] : kVariants) known.emplace_back(name);
  table.Fail("variant",
             "must be one of unconstrained, saturation_constrained, color_constrained, secded, golay, "
             "nordstrom_robinson, reed_muller, table" +
                 DidYouMean(text, known));
}

/// One length, or width and height as measured on the print.
bool ReadSide(TomlTable& table, MarkerFamily& family) {
  if (!table.HoldsList("side")) return table.ReadLength("side", family.side_m, kSide);
  std::vector<double> printed;
  table.ReadLengths("side", printed, LengthRange{2, 2}, kSide);
  if (!family.SetPrinted({printed[0], printed[1]}))
    table.Fail("side", "must be [width, height] of a board of nearly square cells");
  return true;
}

MarkerCode MakeCode(TomlTable& table, const std::filesystem::path& base) {
  const MarkerSize size = ReadSize(table);
  const Variant variant = ReadVariant(table);
  std::string file;
  const bool has_table = table.Read("table", file);
  if (has_table != (variant == Variant::kTable))
    table.Fail("table", has_table ? "is only for variant = \"table\""
                                  : "is missing: variant = \"table\" needs a file of kernels, one a line");
  try {
    return has_table ? MarkerCode::LoadTable(size, base / file) : MarkerCode(size, variant);
  } catch (const std::runtime_error& error) {
    table.Fail(has_table ? "table" : "variant", error.what());
  }
}

}  // namespace

MarkerFamily ReadMarkerFamily(TomlTable& table, const std::filesystem::path& base, bool need_side) {
  MarkerFamily family{.code = MakeCode(table, base), .side_m = 0, .roster = {}};
  if (!ReadSide(table, family) && need_side)
    table.Fail("side", "is missing: poses need the side of the whole board, such as \"120mm\" or 0.12 (metres)");
  std::vector<std::string> roster;
  table.Read("roster", roster, LengthRange{1, 100'000});
  for (const std::string& text : roster) AddIds(table, text, family.code.max_id(), family.roster);
  return family;
}

}  // namespace chequer
