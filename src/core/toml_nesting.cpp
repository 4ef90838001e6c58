#include "core/toml_nesting.h"

#include <algorithm>
#include <cstddef>

namespace chequer {
namespace {

/// The position behind a quoted text that begins at `start`; the end of the text where it is not closed.
std::size_t SkipQuoted(std::string_view text, std::size_t start) {
  const char quote = text[start];
  const bool escapes = quote == '"';
  std::size_t width = 0;
  while (width < 3 && start + width < text.size() && text[start + width] == quote) ++width;
  if (width == 2) return start + 2;
  std::size_t i = start + width;
  std::size_t run = 0;  // of closing quotes
  for (; i < text.size() && run < width; ++i) {
    if (width == 1 && text[i] == '\n') return i;
    run = text[i] == quote ? run + 1 : 0;
    if (escapes && text[i] == '\\') ++i;
  }
  // Up to two quotes may stand right before the closing three.
  for (int extra = 0; width == 3 && extra < 2 && i < text.size() && text[i] == quote; ++extra) ++i;
  return std::min(i, text.size());
}

}  // namespace

int LineOfTooDeepKey(std::string_view text, int max_parts) {
  int parts = 1;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\'') {
      i = SkipQuoted(text, i);
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size());
      continue;
    }
    if (c == '.' && ++parts > max_parts)
      return 1 + static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(i), '\n'));
    if (c == '=' || c == ',' || c == '[' || c == ']' || c == '{' || c == '}' || c == '\n') parts = 1;
    ++i;
  }
  return 0;
}

}  // namespace chequer
