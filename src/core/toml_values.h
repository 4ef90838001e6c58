#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "core/toml_reader.h"

// How TomlTable reads and shows single values. Private to it: nobody else includes the library's header.

namespace chequer::toml_values {

/// For messages: one line, not endless, no control characters.
std::string Printable(std::string text);
/// A value as messages show it.
std::string Shown(const toml::node& node);
/// A value so that equal ones print alike.
void Print(std::ostream& out, const toml::node& node);
/// "1 to 9 values".
std::string Allowed(LengthRange length, const std::string& unit);

/// The range of a length, in metres.
struct MetreRange {
  NumberRange range;
};

// Each element of a list and each single value is taken by one of these: empty on success, or what would be right.

std::string Take(const toml::node& node, bool& value);
std::string Take(const toml::node& node, double& value, NumberRange range);
/// A number is in metres, a text has a unit.
std::string Take(const toml::node& node, double& value_m, MetreRange metres);
std::string Take(const toml::node& node, std::int64_t& value, IntegerRange range);
std::string Take(const toml::node& node, std::string& value, LengthRange length);

template <typename Value, typename Limit>
std::string TakeList(const toml::node& node, std::vector<Value>& values, LengthRange length, Limit each) {
  const toml::array* list = node.as_array();
  if (list == nullptr) return "must be a list of " + Allowed(length, "values");
  if (list->size() < length.min || list->size() > length.max) return "must have " + Allowed(length, "values");
  std::vector<Value> taken(list->size());
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string wrong = Take(*list->get(i), taken[i], each);
    if (!wrong.empty()) return "value " + std::to_string(i + 1) + " (" + Shown(*list->get(i)) + ") " + wrong;
  }
  values = std::move(taken);
  return {};
}

}  // namespace chequer::toml_values
