#include "print/cairo_file.h"

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace chequer {

cairo_status_t AppendToBytes(void* bytes, const unsigned char* data, unsigned length) {
  auto& out = *static_cast<std::vector<std::uint8_t>*>(bytes);
  out.insert(out.end(), data, data + length);
  return CAIRO_STATUS_SUCCESS;
}

void CheckCairo(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("cannot draw: ") + cairo_status_to_string(status));
}

}  // namespace chequer
