#include "core/toml_text.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <utility>

namespace chequer {
namespace {

bool IsAscii(char c) { return static_cast<unsigned char>(c) < 0x80; }

/// The code point at the start of a text, and how many bytes it takes: 0 where it is not UTF-8.
std::pair<std::uint32_t, std::size_t> DecodeUtf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  constexpr std::uint32_t kSmallest[] = {0, 0, 0x80, 0x800, 0x10000};
  const std::uint32_t first = byte(0);
  const std::size_t size = first < 0x80 ? 1 : first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : first >= 0xC0 ? 2 : 0;
  if (size == 0 || first > 0xF4 || text.size() < size) return {0, 0};
  std::uint32_t point = size == 1 ? first : first & (0xFFu >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {0, 0};
    point = point << 6 | (byte(i) & 0x3F);
  }
  const bool surrogate = point >= 0xD800 && point <= 0xDFFF;
  if (point < kSmallest[size] || point > 0x10FFFF || surrogate) return {0, 0};
  return {point, size};
}

/// Walks over the text once, part by part.
class Preparer {
 public:
  Preparer(std::string_view text, int max_key_parts) : rest_(text), max_key_parts_(max_key_parts) {}

  PreparedToml Run() {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    while (!rest_.empty() && prepared_.wrong.empty()) {
      switch (rest_.front()) {
        case '"':
        case '\'': Quoted(); break;
        case '#': Comment(); break;
        default: Bare();
      }
    }
    if (!prepared_.wrong.empty()) prepared_.text.clear();
    return std::move(prepared_);
  }

 private:
  void Take(std::size_t count = 1) {
    prepared_.text.append(rest_.substr(0, count));
    rest_.remove_prefix(std::min(count, rest_.size()));
  }

  void Refuse(std::string why) {
    prepared_.wrong = std::move(why);
    prepared_.line = 1 + static_cast<int>(std::count(prepared_.text.begin(), prepared_.text.end(), '\n'));
  }

  /// Up to the closing quote, or to the end of the line where there is none.
  void Quoted() {
    const char quote = rest_.front();
    if (rest_.starts_with("\"\"\"") || rest_.starts_with("'''"))
      return Refuse("texts in three quotes are not read here: use one");
    Take();
    while (!rest_.empty() && rest_.front() != quote && rest_.front() != '\n') {
      if (!IsAscii(rest_.front())) {
        Escape(quote);
        if (!prepared_.wrong.empty()) return;
      } else {
        const bool escape = quote == '"' && rest_.front() == '\\' && rest_.size() > 1 && IsAscii(rest_[1]);
        Take(escape ? 2 : 1);
      }
    }
    if (!rest_.empty() && rest_.front() == quote) Take();
  }

  void Escape(char quote) {
    if (quote != '"') return Refuse("characters beyond ASCII must stand in double quotes or comments");
    const auto [point, size] = DecodeUtf8(rest_);
    if (size == 0) return Refuse("the text is not UTF-8");
    char escaped[16];
    std::snprintf(escaped, sizeof escaped, "\\U%08x", static_cast<unsigned>(point));
    prepared_.text.append(escaped);
    rest_.remove_prefix(size);
  }

  void Comment() {
    const std::string_view comment = rest_.substr(0, rest_.find('\n'));
    for (const char c : comment) prepared_.text += IsAscii(c) ? c : '?';
    rest_.remove_prefix(comment.size());
  }

  void Bare() {
    const char c = rest_.front();
    if (!IsAscii(c)) return Refuse("characters beyond ASCII must stand in double quotes or comments");
    if (c == '.' && ++key_parts_ > max_key_parts_)
      return Refuse("a key must have at most " + std::to_string(max_key_parts_) + " parts");
    if (c == '=' || c == ',' || c == '[' || c == ']' || c == '{' || c == '}' || c == '\n') key_parts_ = 1;
    Take();
  }

  std::string_view rest_;
  int max_key_parts_;
  int key_parts_ = 1;
  PreparedToml prepared_;
};

}  // namespace

PreparedToml PrepareToml(std::string_view text, int max_key_parts) { return Preparer(text, max_key_parts).Run(); }

}  // namespace chequer
