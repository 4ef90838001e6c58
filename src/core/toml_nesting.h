#pragma once

#include <string_view>

namespace chequer {

/// The line (from 1) of a TOML text at which a key has more than `max_parts` dotted parts; 0 where there is none.
/// The parser builds one table inside the other for each part, and taking those apart again needs stack for each:
/// a file of "a.a.a.a…" would end the program.
int LineOfTooDeepKey(std::string_view text, int max_parts);

}  // namespace chequer
