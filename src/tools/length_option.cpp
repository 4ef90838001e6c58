#include "tools/length_option.h"

#include <cmath>

#include "core/length.h"

namespace chequer {
namespace {

/// In units of `unit_m`.
double Parse(const char* option, const std::string& text, double unit_m) {
  const std::optional<double> metres = ParseLength(text, unit_m);
  if (!metres || !(*metres > 0))
    throw CLI::ValidationError(
        option, "'" + text + "' is not a length; " +
                    (unit_m == 1 ? "it must be positive metres, such as 0.06, or have a unit, such as 60mm or 6cm"
                                 : "write it as 6mm or 3.45um, with its unit"));
  return *metres * std::round(1 / unit_m);
}

template <typename Value>
CLI::Option* Add(CLI::App& command, const char* name, Value& value, const std::string& help, double unit_m) {
  const auto set = [&value, name, unit_m](const std::string& text) { value = Parse(name, text, unit_m); };
  return command.add_option_function<std::string>(name, set, help)->type_name("LENGTH");
}

}  // namespace

double ParseLengthOption(const char* option, const std::string& text) { return Parse(option, text, 1); }

CLI::Option* AddLengthOption(CLI::App& command, const char* name, double& value, const std::string& help,
                             double unit_m) {
  return Add(command, name, value, help, unit_m);
}

CLI::Option* AddLengthOption(CLI::App& command, const char* name, std::optional<double>& value, const std::string& help,
                             double unit_m) {
  return Add(command, name, value, help, unit_m);
}

}  // namespace chequer
