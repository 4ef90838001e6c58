#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "chequer/check.h"
#include "publish/wire.h"
#include "publish/wire_view.h"

// Any bytes that the network may bring to a program that listens: a message or nothing, and what is understood is sent
// and understood again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (const auto viewed = chequer::DecodeViewMessage({data, size})) {
    const auto again = std::visit([](const auto& known) { return chequer::EncodeView(known); }, *viewed);
    CHEQUER_CHECK(chequer::DecodeViewMessage(again).has_value(),
                  "a message for those who look is not understood as it is sent");
  }
  const auto message = chequer::DecodeMessage({data, size});
  if (!message) return 0;
  chequer::WireEncoder encoder;
  const auto bytes = std::visit([&](const auto& known) { return encoder.Encode(known); }, *message);
  CHEQUER_CHECK(chequer::DecodeMessage(bytes).has_value(), "a message is not understood as it is sent");
  return 0;
}
