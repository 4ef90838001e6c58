#pragma once

#include <string>
#include <string_view>

namespace chequer {

/// Text for a manual page: what troff would take for a command or a hyphen is quoted. One line.
std::string Troff(std::string_view line);

/// Several lines of plain text as they stand in `--help`: blank lines part paragraphs, lines that begin with two spaces
/// are examples and keep their form.
std::string TroffParagraphs(std::string_view text);

/// The head of a page. @param title such as "CHEQUERD". @param summary what apropos(1) shows, without a full stop.
std::string TroffHead(std::string_view title, int section, std::string_view version, std::string_view name,
                      std::string_view summary);

}  // namespace chequer
