#include "marker/table_file.h"

#include <sstream>
#include <stdexcept>
#include <string_view>

#include "core/file.h"
#include "marker/table_code.h"

namespace chequer {
namespace {

/// The text without comment and without blanks at its ends (a carriage return is one).
std::string_view Content(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r\v\f";
  line = line.substr(0, line.find('#'));
  const std::size_t begin = line.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return line.substr(begin, line.find_last_not_of(kBlank) + 1 - begin);
}

/// The start of a text that may be long or not be text at all, fit for a message.
std::string Excerpt(std::string_view text) {
  constexpr std::size_t kLongest = 80;
  std::string excerpt(text.substr(0, kLongest));
  for (char& character : excerpt) {
    if (character < ' ' || character > '~') character = '?';
  }
  return text.size() > kLongest ? excerpt + "…" : excerpt;
}

}  // namespace

TableFile ReadTableFile(MarkerSize size, const std::filesystem::path& path) {
  std::istringstream file(ReadFile(path, kMaxTextBytes));
  const auto bits = static_cast<std::size_t>(KernelBits(size));
  TableFile table;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string_view content = Content(line);
    if (content.empty()) continue;
    const std::string place = path.string() + ":" + std::to_string(number);
    if (content.size() != bits || content.find_first_not_of("01") != std::string_view::npos) {
      throw std::runtime_error(place + ": \"" + Excerpt(content) + "\" is not a kernel; a " + ToString(size) +
                               " marker needs " + std::to_string(bits) + " digits 0 or 1");
    }
    if (table.kernels.size() == kMaxTableEntries) {
      throw std::runtime_error(place + ": one kernel too many; at most " + std::to_string(kMaxTableEntries) +
                               " are allowed");
    }
    std::uint64_t kernel = 0;
    for (const char digit : content) kernel = kernel << 1 | std::uint64_t{digit == '1'};
    table.kernels.push_back(kernel);
    table.places.push_back("line " + std::to_string(number));
  }
  return table;
}

}  // namespace chequer
