#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "chequer/check.h"
#include "publish/wire.h"

// Any bytes that the network may bring to a program that listens: a message or nothing, and what is understood is sent
// and understood again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto message = chequer::DecodeMessage({data, size});
  if (!message) return 0;
  chequer::WireEncoder encoder;
  const auto bytes = std::visit([&](const auto& known) { return encoder.Encode(known); }, *message);
  CHEQUER_CHECK(chequer::DecodeMessage(bytes).has_value(), "a message is not understood as it is sent");
  return 0;
}
