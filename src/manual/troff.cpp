#include "manual/troff.h"

namespace chequer {
namespace {

/// Calls `take(line)` for each line.
template <typename Take>
void ForEachLine(std::string_view text, Take&& take) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    take(text.substr(0, end));
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
}

}  // namespace

std::string Troff(std::string_view line) {
  std::string quoted;
  if (line.starts_with('.') || line.starts_with('\'')) quoted = "\\&";
  for (const char c : line) switch (c) {
      case '\\': quoted += "\\e"; break;
      case '-': quoted += "\\-"; break;
      case '\'': quoted += "\\(aq"; break;
      case '^': quoted += "\\(ha"; break;
      case '~': quoted += "\\(ti"; break;
      case '`': quoted += "\\(ga"; break;
      default: quoted += c;
    }
  return quoted;
}

std::string TroffParagraphs(std::string_view text) {
  std::string page;
  bool example = false;
  bool paragraph = false;  // one is to begin
  ForEachLine(text, [&](std::string_view line) {
    const bool is_example = line.starts_with("  ");
    if (example && !is_example) page += ".EE\n.RE\n";
    if (is_example && !example) page += ".PP\n.RS 4\n.EX\n";
    if (!is_example && !line.empty() && (paragraph || example)) page += ".PP\n";
    example = is_example;
    paragraph = line.empty();
    if (!line.empty()) page += Troff(is_example ? line.substr(2) : line) + "\n";
  });
  return page + (example ? ".EE\n.RE\n" : "");
}

std::string TroffHead(std::string_view title, int section, std::string_view version, std::string_view name,
                      std::string_view summary) {
  std::string head = "'\\\" t\n.TH ";
  head.append(Troff(title)).append(" ").append(std::to_string(section)).append(" \"\" \"chequer ");
  head.append(version).append("\" \"chequer manual\"\n.nh\n.ad l\n.SH NAME\n");
  return head.append(Troff(name)).append(" \\- ").append(Troff(summary)).append("\n");
}

}  // namespace chequer
