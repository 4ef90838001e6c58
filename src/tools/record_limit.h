#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace chequer {

/// When a recording is long enough; what is left out does not limit it.
struct RecordLimit {
  std::optional<std::uint64_t> frames;
  std::optional<double> seconds;
  std::optional<std::uint64_t> bytes;
};

/// The limits that were typed. @param frames, seconds 0: none. @param bytes a number, with k, M, G or T for powers of
/// 1000 behind it; empty: none. Throws CLI::ValidationError saying what would be right.
RecordLimit MakeRecordLimit(std::uint64_t frames, double seconds, const std::string& bytes);

}  // namespace chequer
