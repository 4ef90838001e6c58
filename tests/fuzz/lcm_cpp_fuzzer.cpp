#include <cstddef>
#include <cstdint>
#include <vector>

#include "fuzz/lcm_types.h"

// Any bytes that the network may bring to a program of a user in C++.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const int type = data[0] % chequer::test::kLcmTypes;
  std::vector<std::uint8_t> message(8);
  const std::uint64_t fingerprint = chequer::test::TryCppType(type, nullptr, 0);
  for (std::size_t i = 0; i < 8; ++i) message[i] = static_cast<std::uint8_t>(fingerprint >> (56 - 8 * i));
  message.insert(message.end(), data + 1, data + size);
  chequer::test::TryCppType(type, message.data(), message.size());
  return 0;
}
