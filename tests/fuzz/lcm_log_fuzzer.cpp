#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>

#include "chequer/check.h"
#include "publish/lcm_log_events.h"
#include "publish/wire.h"

// Any bytes that are said to be a log: its events, and what they hold.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chequer::UniqueFd file(memfd_create("log", MFD_CLOEXEC));
  CHEQUER_CHECK(file.valid() && write(file.get(), data, size) == static_cast<ssize_t>(size), "no file in memory");
  chequer::LogEventReader reader(std::move(file));
  std::size_t bytes = 0;
  while (const auto event = reader.Next()) {
    bytes += 28 + event->channel.size() + event->data.size();
    chequer::DecodeMessage(event->data);
  }
  CHEQUER_CHECK(bytes <= size && reader.damaged() == (bytes < size), "events do not account for the bytes");
  return 0;
}
