#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "chequer/check.h"
#include "chequer/camera_file.h"

// Any text: a camera or a std::runtime_error, and what is read is written and read back the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const std::string once = chequer::FormatCamera(chequer::ParseCamera(text, "camera.toml"));
    const std::string twice = chequer::FormatCamera(chequer::ParseCamera(once, "camera.toml"));
    CHEQUER_CHECK(once == twice, "a camera file does not read back as it was written");
  } catch (const std::runtime_error&) {
    // What a bad file must give.
  }
  return 0;
}
