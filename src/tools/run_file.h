#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluate/recognition.h"

namespace chequer {

/// What a camera saw in one go, frame by frame, in the order in which it was written.
struct Run {
  std::string name;  ///< the file's
  std::vector<SeenFrame> frames;
};

/// Reads what `chequer detect --json` or `chequer convert` printed (JSON, a line a frame), or a log of lcm-logger, told
/// apart by its first bytes. Throws std::runtime_error naming the file, the line, what is wrong and what would be
/// right; also for a file without frames, and for a log that is cut off.
/// @param channel of a log that holds the poses of several cameras; empty: the only one.
Run ReadRun(const std::filesystem::path& path, const std::string& channel = {});

}  // namespace chequer
