#include "core/printable.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <limits>

namespace chequer {
namespace {

/// What stands at the front of a text.
struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 1;
  bool valid = false;
};

/// Reads UTF-8 as RFC 3629 has it: no longer forms than needed, no surrogates, nothing beyond U+10FFFF.
Character FirstOf(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {};
  std::uint32_t code = lead & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3fu);
  }
  constexpr std::array<std::uint32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  if (code < kLeast[bytes] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {};
  return {code, bytes, true};
}

bool Within(std::uint32_t code, std::uint32_t first, std::uint32_t last) { return code >= first && code <= last; }

/// Controls (C0, DEL, C1), ends of lines, and what changes the direction of writing.
bool IsHarmful(std::uint32_t code) {
  return code < 0x20 || Within(code, 0x7f, 0x9f) || Within(code, 0x200e, 0x200f) || Within(code, 0x2028, 0x202e) ||
         Within(code, 0x2066, 0x2069);
}

std::string Clean(std::string_view text, std::string_view kept, std::size_t max_characters) {
  std::string clean;
  for (std::size_t count = 0; !text.empty(); ++count) {
    if (count == max_characters) return clean + "…";
    const Character first = FirstOf(text);
    const bool is_kept = first.valid && (!IsHarmful(first.code) || kept.find(text.front()) != std::string_view::npos);
    clean += is_kept ? text.substr(0, first.bytes) : "?";
    text.remove_prefix(first.bytes);
  }
  return clean;
}

}  // namespace

std::string Printable(std::string_view text) { return Clean(text, {}, kMaxPrintableCharacters); }

std::string PrintableLines(std::string_view text) {
  return Clean(text, "\n\t", std::numeric_limits<std::size_t>::max());
}

std::string PrintableJson(std::string_view json) {
  std::string clean;
  while (!json.empty()) {
    const Character first = FirstOf(json);
    if (first.valid && IsHarmful(first.code)) {
      char escaped[16];
      std::snprintf(escaped, sizeof escaped, "\\u%04x", first.code);
      clean += escaped;
    } else {
      clean += json.substr(0, first.bytes);
    }
    json.remove_prefix(first.bytes);
  }
  return clean;
}

}  // namespace chequer
