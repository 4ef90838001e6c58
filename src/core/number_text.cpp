#include "core/number_text.h"

#include <array>
#include <charconv>

namespace chequer {

std::string ExactText(double number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

}  // namespace chequer
