#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "capture/recording.h"
#include "capture/recording_text.h"
#include "chequer/check.h"
#include "core/file.h"
#include "support/temporary_directory.h"

// A text cut in two at its first 0 byte: recording.toml and frames.csv of a folder that holds an image, a raw file and,
// one folder up, a file that must not be reached.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace chequer;
  static const test::TemporaryDirectory parent;
  static const std::filesystem::path folder = parent / "recording";
  if (!std::filesystem::exists(folder)) {
    std::filesystem::create_directory(folder);
    WriteFileAtomically(folder / "0.pgm", "P5 2 2 255 abcd");
    WriteFileAtomically(folder / "0.raw", "abcd");
    WriteFileAtomically(parent / "0.pgm", "P5 2 2 255 xxxx");
  }
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t cut = std::min(text.find('\0'), text.size());
  WriteFileAtomically(folder / kRecordingFile, text.substr(0, cut));
  WriteFileAtomically(folder / kFrameIndexFile, text.substr(std::min(cut + 1, text.size())));
  try {
    const Recording recording = OpenRecording(folder);
    const std::string once = FormatRecordingInfo(recording.info);
    const std::string twice = FormatRecordingInfo(ParseRecordingInfo(TomlFile::Parse(once, "recording.toml")));
    CHEQUER_CHECK(once == twice, "a recording.toml does not read back as it was written");
    const Image image = LoadFrame(recording, recording.frames.size() - 1);
    CHEQUER_CHECK(image.bytes()[0] != 'x', "a file outside of the recording was read");
  } catch (const std::runtime_error&) {
    // What a bad recording must give.
  }
  return 0;
}
