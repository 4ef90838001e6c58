#pragma once

#include <string>
#include <string_view>

namespace chequer {

/// Characters of a text that comes from outside; the rest of it is left out.
inline constexpr std::size_t kMaxPrintableCharacters = 1000;

/// A text from outside (the network, a file, a device) as a terminal can be given it: one line of valid UTF-8. What
/// moves the cursor, begins an escape sequence, ends a line or turns the direction of writing is '?', and so is what
/// is no UTF-8. "…" stands for what is beyond kMaxPrintableCharacters.
std::string Printable(std::string_view text);

/// The same of a text whose lines are its own, such as the message of an error. No limit.
std::string PrintableLines(std::string_view text);

/// JSON in which such characters are escaped (\u009b); programs read the same. @pre valid UTF-8.
std::string PrintableJson(std::string_view json);

}  // namespace chequer
