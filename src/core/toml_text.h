#pragma once

#include <string>
#include <string_view>

namespace chequer {

/// A TOML text as the parser can bear it, or what is wrong with it and where.
struct PreparedToml {
  std::string text;  ///< the same document, line by line, in ASCII alone; empty if something is wrong
  int line = 0;      ///< from 1, of what is wrong; 0 if nothing is
  std::string wrong;
};

/// Prepares a text for toml++, of which version 3.3 has undefined behaviour where it meets a character beyond ASCII
/// while it looks for the end of a bare word: such characters are escaped in double quotes, replaced in comments, and
/// refused elsewhere. Refused are also
/// - keys of more than `max_key_parts` dotted parts: each part is a table in the other, and taking such a tree apart
///   needs stack for each, so a file of "a.a.a.a…" would end the program;
/// - texts in three quotes, which nothing here needs, so that quotes are easy to follow.
PreparedToml PrepareToml(std::string_view text, int max_key_parts);

}  // namespace chequer
