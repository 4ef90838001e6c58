#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "capture/source_factory.h"

// Any text: a source that could be opened, or a std::runtime_error. Nothing is opened.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    chequer::TomlFile file = chequer::TomlFile::Parse(text, "swarm.toml");
    const auto options = chequer::ReadCaptureOptions(file.root().Table("capture"), "/");
    file.CheckAllKeysRead();
    chequer::MakeSource(options)->Describe();
  } catch (const std::runtime_error&) {
    // What a bad configuration must give.
  }
  return 0;
}
