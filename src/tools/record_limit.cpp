#include "tools/record_limit.h"

#include <CLI/CLI.hpp>
#include <charconv>

namespace chequer {
namespace {

std::uint64_t ParseBytes(const std::string& typed) {
  double value = 0;
  const char* last = typed.data() + typed.size();
  const auto [end, error] = std::from_chars(typed.data(), last, value);
  const std::string unit(end, last);
  double factor = 0;
  if (unit.empty()) factor = 1;
  if (unit == "k" || unit == "K") factor = 1e3;
  if (unit == "M") factor = 1e6;
  if (unit == "G") factor = 1e9;
  if (unit == "T") factor = 1e12;
  constexpr double kMost = 1e15;
  if (error != std::errc() || !(factor * value >= 1 && factor * value <= kMost))
    throw CLI::ValidationError("--bytes", "'" + typed + "' must be a number above 0, with k, M, G or T, such as 500M");
  return static_cast<std::uint64_t>(factor * value);
}

}  // namespace

RecordLimit MakeRecordLimit(std::uint64_t frames, double seconds, const std::string& bytes) {
  RecordLimit limit;
  if (frames > 0) limit.frames = frames;
  if (seconds > 0) limit.seconds = seconds;
  if (!bytes.empty()) limit.bytes = ParseBytes(bytes);
  return limit;
}

}  // namespace chequer
