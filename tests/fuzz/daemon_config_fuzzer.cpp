#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "chequer/check.h"
#include "daemon/config.h"

// Any text: a configuration that a detector accepts, or a std::runtime_error. The files it names are not there.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    const auto config = chequer::ParseDaemonConfig(text, "chequerd.toml", "/nowhere");
    CHEQUER_CHECK(config.detector.Check().empty(), "a configuration was accepted that no detector accepts");
  } catch (const std::runtime_error&) {
    // What a bad configuration must give.
  }
  return 0;
}
