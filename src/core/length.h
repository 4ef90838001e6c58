#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace chequer {

/// How lengths are written, for messages.
inline constexpr std::string_view kLengthForms = "60mm, 6cm, 0.06m or 0.06 (metres)";

/// Metres of "60mm", "6 cm", "0.06m", "3.45um" or a bare number; nothing where it is none of these or not finite. The
/// command line and all configuration files read lengths by this. @param bare_m what a bare number is in, metres.
std::optional<double> ParseLength(std::string_view text, double bare_m = 1);

/// "0.06 m" as people say it: "60 mm", "1.2 m".
std::string LengthText(double metres);

/// "; a bare number is in metres: did you mean \"60mm\"?" where a length was written as a bare number that millimetres
/// explain better; else empty. @param text as typed.
std::string DidYouMeanMillimetres(std::string_view text);

}  // namespace chequer
