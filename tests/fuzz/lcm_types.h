#pragma once

#include <cstddef>
#include <cstdint>

// The decoders that users get, each type's, on any bytes. The first byte chooses the type: a fuzzer would not find the
// eight bytes of a type's fingerprint, so they are put before the rest.

namespace chequer::test {

inline constexpr int kLcmTypes = 17;

/// Decodes bytes as C's type of that number, and encodes what came out. @return its fingerprint where `data` is null.
std::uint64_t TryCType(int type, const std::uint8_t* data, std::size_t size);
/// The same of C++.
std::uint64_t TryCppType(int type, const std::uint8_t* data, std::size_t size);

}  // namespace chequer::test
