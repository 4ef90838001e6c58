#include "setup/print_table.h"

#include "core/length.h"

namespace chequer {
namespace {

// Beyond, nobody would call it the same print; DetectorOptions::Check says the same.
constexpr NumberRange kScale{0, 0.05}, kRegister{0, 0.005};

bool Holds(NumberRange range, double value) { return value >= range.min && value <= range.max; }

}  // namespace

PrintTolerance ReadPrintTolerance(TomlTable table) {
  PrintTolerance tolerance;
  if (table.HoldsTable("tolerance")) {
    TomlTable numbers = table.Table("tolerance");
    numbers.Read("scale", tolerance.scale, kScale);
    numbers.ReadLength("register", tolerance.register_m, kRegister);
    return tolerance;
  }
  std::string name;
  if (!table.Read("tolerance", name)) return tolerance;
  const auto named = name.find(',') == std::string::npos ? ParsePrintTolerance(name) : std::nullopt;
  if (!named)
    table.Fail("tolerance", "must be \"office\", \"none\", or numbers: { scale = 0.0025, register = \"0.03mm\" }");
  return *named;
}

std::optional<PrintTolerance> ParsePrintTolerance(std::string_view text) {
  if (text == "office") return kOfficePrints;
  if (text == "none") return PrintTolerance{};
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::string_view first = text.substr(0, comma);
  const bool is_share = !first.empty() && first.find_first_not_of("0123456789.e-") == std::string_view::npos;
  const auto scale = is_share ? ParseLength(first) : std::nullopt, inks = ParseLength(text.substr(comma + 1));
  if (!scale || !inks || !Holds(kScale, *scale) || !Holds(kRegister, *inks)) return std::nullopt;
  return PrintTolerance{*scale, *inks};
}

}  // namespace chequer
