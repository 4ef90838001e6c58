// World files and lists of references. Whatever the text, they are read or refused with a message.
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "chequer/check.h"
#include "world/references.h"
#include "world/world_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const chequer::WorldCalibration world = chequer::ParseWorld(text, "fuzz.toml");
    std::size_t references = 0;
    try {
      references = chequer::ParseWorld(chequer::FormatWorld(world), "again.toml").references.size();
    } catch (const std::runtime_error&) {
      references = world.references.size() + 1;
    }
    CHEQUER_CHECK(references == world.references.size(), "a world file does not read back as it was written");
  } catch (const std::runtime_error&) {
  }
  try {
    chequer::ParseReferences(text, "fuzz.toml");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
