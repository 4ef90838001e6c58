#pragma once

#include <string>
#include <string_view>

namespace chequer {

/// The manual page of a configuration, in troff, from the commented sample: comments become the text of what they stand
/// above, tables sections, keys with their defaults terms.
std::string ConfigPage(std::string_view sample, std::string_view version);

}  // namespace chequer
