#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "capture/recording.h"
#include "core/toml_reader.h"

namespace chequer {

/// What recording.toml says. Throws std::runtime_error naming file, line, key, value and what would be right.
RecordingInfo ParseRecordingInfo(TomlFile file);

/// The text of recording.toml; ParseRecordingInfo gives the same back.
std::string FormatRecordingInfo(const RecordingInfo& info);

/// First line of frames.csv.
inline constexpr std::string_view kFrameIndexHeader = "file,utc_us,monotonic_us,sequence";

/// The frames that a frames.csv lists. A last line that does not end with a line feed is left out. Throws
/// std::runtime_error naming file, line, what is wrong and what would be right. @param name stands for the file.
std::vector<RecordedFrame> ParseFrameIndex(std::string_view text, const std::string& name);

/// One line of frames.csv, with its line feed.
std::string FormatFrameLine(const RecordedFrame& frame);

/// Empty if a name stays in its folder and in its field of frames.csv, else what would be right.
std::string CheckFileName(std::string_view name);

}  // namespace chequer
