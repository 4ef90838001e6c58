#include "core/toml_values.h"

#include <limits>
#include <optional>
#include <sstream>

#include "core/length.h"
#include "core/number_text.h"

namespace chequer::toml_values {
namespace {

constexpr std::size_t kMaxShown = 80;  ///< characters of a value in a message

std::string Allowed(NumberRange range) {
  return "from " + RoundText(range.min, 10) + " to " + RoundText(range.max, 10);
}

std::string Allowed(IntegerRange range) {
  if (range.max == std::numeric_limits<std::int64_t>::max()) return "at least " + std::to_string(range.min);
  return "from " + std::to_string(range.min) + " to " + std::to_string(range.max);
}

}  // namespace

std::string Printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  if (text.size() <= kMaxShown) return text;
  std::size_t cut = kMaxShown;
  while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xC0) == 0x80) --cut;  // not inside a UTF-8 sequence
  return text.substr(0, cut) + "…";
}

std::string Shown(const toml::node& node) {
  std::string shown;
  if (node.is_table()) return "{…}";
  if (const toml::array* list = node.as_array()) {
    for (std::size_t i = 0; i < list->size() && shown.size() <= kMaxShown; ++i)
      shown += (i == 0 ? "" : ", ") + Shown(*list->get(i));
    return Printable("[" + shown + "]");
  }
  if (const auto number = node.as_floating_point()) {  // toml++ gives 17 digits
    const std::string text = RoundText(number->get(), 10);
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
  }
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return Printable(text.str());
}

// Not by the library's own formatter of arrays, which of 3.3 computes how wide negative numbers are by what the
// language leaves undefined.
void Print(std::ostream& out, const toml::node& node) {
  if (const toml::array* array = node.as_array()) {
    out << '[';
    for (const toml::node& element : *array) Print(out << ' ', element);
    out << " ]";
  } else if (const toml::table* table = node.as_table()) {
    out << '{';
    for (const auto& [key, value] : *table) Print(out << ' ' << key.str() << " = ", value);
    out << " }";
  } else {
    node.visit([&](const auto& value) { out << value; });
  }
}

std::string Allowed(LengthRange length, const std::string& unit) {
  const std::string most = std::to_string(length.max) + " " + unit;
  return length.min == length.max ? most : std::to_string(length.min) + " to " + most;
}

std::string Take(const toml::node& node, bool& value) {
  if (!node.is_boolean()) return "must be true or false";
  value = **node.as_boolean();
  return {};
}

std::string Take(const toml::node& node, double& value, NumberRange range) {
  if (!node.is_number()) return "must be a number " + Allowed(range);
  const double number = *node.value<double>();
  if (!(number >= range.min && number <= range.max)) return "must be " + Allowed(range);
  value = number;
  return {};
}

std::string Take(const toml::node& node, double& value_m, MetreRange metres) {
  const auto* text = node.as_string();
  const std::optional<double> length = text != nullptr ? ParseLength(**text) : node.value<double>();
  const NumberRange range = metres.range;
  if (length && *length >= range.min && *length <= range.max) {
    value_m = *length;
    return {};
  }
  const std::string allowed = Allowed(range) + " m";
  if (!length) return "must be a length " + allowed + ", written \"60mm\", \"6cm\" or 0.06 (metres)";
  return "must be " + allowed + (text == nullptr ? DidYouMeanMillimetres(RoundText(*length, 10)) : std::string());
}

std::string Take(const toml::node& node, std::int64_t& value, IntegerRange range) {
  if (!node.is_integer()) return "must be a whole number " + Allowed(range);
  const std::int64_t number = **node.as_integer();
  if (number < range.min || number > range.max) return "must be " + Allowed(range);
  value = number;
  return {};
}

std::string Take(const toml::node& node, std::string& value, LengthRange length) {
  const auto* text = node.as_string();
  if (text == nullptr) return "must be a text in quotes";
  if ((*text)->size() < length.min || (*text)->size() > length.max) return "must have " + Allowed(length, "characters");
  if ((*text)->find('\0') != std::string::npos) return "must not contain the character 0";
  value = **text;
  return {};
}

}  // namespace chequer::toml_values
