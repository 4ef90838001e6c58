#include "manual/config_page.h"

#include <vector>

#include "manual/troff.h"

namespace chequer {
namespace {

/// "#key = value": a key that is left out by default, as against prose.
bool IsLeftOutKey(std::string_view line) {
  if (!line.starts_with('#')) return false;
  const std::size_t end = line.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_", 1);
  return end != std::string_view::npos && end > 1 && line.substr(end).starts_with(" = ");
}

class Page {
 public:
  void Take(std::string_view line) {
    if (IsLeftOutKey(line))
      Key(line.substr(1), "left out by default; for example");
    else if (line.starts_with('#'))
      comment_.emplace_back(line.substr(line.starts_with("# ") ? 2 : 1));
    else if (line.starts_with('['))
      Section(line);
    else if (!line.empty())
      Key(line, {});
    else
      Flush();
  }
  std::string Finish() {
    Flush();
    return std::move(text_);
  }

 private:
  void Flush() {
    for (const std::string& line : comment_) text_ += Troff(line) + "\n";
    comment_.clear();
  }

  /// A comment that stands right above a table is about it.
  void Section(std::string_view line) {
    text_ += ".SS " + Troff(line) + "\n";
    Flush();
  }

  void Key(std::string_view line, std::string_view note) {
    const std::string_view name = line.substr(0, line.find(' '));
    text_ += ".TP\n\\fB" + Troff(name) + "\\fR" + Troff(line.substr(name.size())) + "\n";
    if (!note.empty()) text_ += "(" + Troff(note) + " so.)\n";
    Flush();
  }

  std::string text_;
  std::vector<std::string> comment_;
};

}  // namespace

std::string ConfigPage(std::string_view sample, std::string_view version) {
  Page page;
  while (!sample.empty()) {
    const std::size_t end = sample.find('\n');
    page.Take(sample.substr(0, end));
    sample = end == std::string_view::npos ? std::string_view() : sample.substr(end + 1);
  }
  return TroffHead("CHEQUERD.TOML", 5, version, "chequerd.toml", "configuration of chequerd") +
         ".SH SYNOPSIS\n\\fI/etc/chequer/NAME.toml\\fR, for the service \\fBchequerd@NAME\\fR\n.SH DESCRIPTION\n" +
         page.Finish() + ".SH FILES\n\\fI/etc/chequer/example.toml\\fR holds this text as a sample to copy.\n" +
         ".SH SEE ALSO\n" +
         Troff("chequerd(8), chequer(1), chequer-camera.toml(5), chequer-recording(5), chequer-robots.toml(5)") + "\n";
}

}  // namespace chequer
