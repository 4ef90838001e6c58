#include "capture/fault.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace chequer {
namespace {

using std::chrono::milliseconds;

[[noreturn]] void Refuse(std::string_view text) {
  throw std::runtime_error("fault \"" + std::string(text.substr(0, 80)) +
                           "\": must be \"stall FRAME TIME\", \"drop FRAME COUNT\", \"truncate FRAME\", "
                           "\"corrupt FRAME\", \"vanish FRAME TIME\" or \"vanish FRAME COUNT opens\", FRAME from 0, "
                           "COUNT from 1 to 1000000, TIME such as 0.5s or 500ms up to 3600s");
}

std::vector<std::string_view> SplitWords(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t start = text.find_first_not_of(' ');
    if (start == std::string_view::npos) return words;
    const std::size_t end = std::min(text.find(' ', start), text.size());
    words.push_back(text.substr(start, end - start));
    text.remove_prefix(end);
  }
}

std::optional<std::uint64_t> ParseCount(std::string_view word, std::uint64_t min, std::uint64_t max) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < min || value > max) return std::nullopt;
  return value;
}

std::optional<milliseconds> ParseTime(std::string_view word) {
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const std::string_view unit = word.substr(static_cast<std::size_t>(end - word.data()));
  if (error != std::errc() || (unit != "s" && unit != "ms")) return std::nullopt;
  const double in_ms = unit == "s" ? 1000 * value : value;
  if (!(in_ms >= 1 && in_ms <= 3.6e6)) return std::nullopt;
  return milliseconds(std::llround(in_ms));
}

std::optional<FaultKind> ParseKind(std::string_view word) {
  if (word == "stall") return FaultKind::kStall;
  if (word == "drop") return FaultKind::kDrop;
  if (word == "truncate") return FaultKind::kTruncate;
  if (word == "corrupt") return FaultKind::kCorrupt;
  if (word == "vanish") return FaultKind::kVanish;
  return std::nullopt;
}

}  // namespace

Fault ParseFault(std::string_view text) {
  constexpr std::uint64_t kMaxFrame = 1'000'000'000'000, kMaxCount = 1'000'000;
  const std::vector<std::string_view> words = SplitWords(text);
  if (words.size() < 2) Refuse(text);
  const auto kind = ParseKind(words[0]);
  const auto frame = ParseCount(words[1], 0, kMaxFrame);
  if (!kind || !frame) Refuse(text);
  Fault fault;
  fault.kind = *kind;
  fault.frame = *frame;
  if (fault.kind == FaultKind::kVanish && words.size() == 4 && words[3] == "opens") {
    const auto opens = ParseCount(words[2], 1, kMaxCount);
    if (!opens) Refuse(text);
    fault.failed_opens = static_cast<int>(*opens);
    return fault;
  }
  const bool alone = fault.kind == FaultKind::kTruncate || fault.kind == FaultKind::kCorrupt;
  if (words.size() != (alone ? 2u : 3u)) Refuse(text);
  if (alone) return fault;
  if (fault.kind == FaultKind::kDrop) {
    const auto count = ParseCount(words[2], 1, kMaxCount);
    if (!count) Refuse(text);
    fault.count = *count;
    return fault;
  }
  const auto duration = ParseTime(words[2]);
  if (!duration) Refuse(text);
  fault.duration = *duration;
  return fault;
}

std::vector<Fault> ParseFaults(const std::vector<std::string>& texts) {
  std::vector<Fault> faults;
  for (const std::string& text : texts) faults.push_back(ParseFault(text));
  std::sort(faults.begin(), faults.end(), [](const Fault& a, const Fault& b) { return a.frame < b.frame; });
  for (std::size_t i = 1; i < faults.size(); ++i)
    if (faults[i].frame == faults[i - 1].frame)
      throw std::runtime_error("two faults at frame " + std::to_string(faults[i].frame) + ": one frame has one fault");
  return faults;
}

}  // namespace chequer
