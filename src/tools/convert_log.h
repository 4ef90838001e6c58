#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace chequer {

/// Whether a file begins as LCM logs do (lcm-logger, or a file:// URL). False where it cannot be read.
bool IsLcmLog(const std::filesystem::path& path);

/// Which messages of a log are written.
enum class LogStream : std::uint8_t { kAll, kPoses, kRobots, kTracks };

/// Writes the messages of an LCM log as text: CSV, a line a marker, robot or track, where `out` ends in .csv, else a
/// JSON object a line and message as `chequer listen --json` prints them. `out` "-" is standard output, as JSON. A
/// table holds one kind of message: of kAll the poses. Messages that are not chequer's are passed over. Throws
/// std::runtime_error naming the file and what is wrong: unreadable, cut off (what stands before the cut is written),
/// without any message of chequer's or of that stream, not writable.
void ConvertLog(const std::filesystem::path& log, const std::string& out, LogStream stream = LogStream::kAll);

}  // namespace chequer
