#include "core/date_text.h"

#include <algorithm>

namespace chequer {

bool IsDateText(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           std::string_view(" :.+-").find(c) != std::string_view::npos;
  });
}

}  // namespace chequer
