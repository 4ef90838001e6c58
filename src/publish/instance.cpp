#include "publish/instance.h"

#include <random>

namespace chequer {

std::uint64_t InstanceOfProcess() {
  // Constant for as long as the process lives, as a process id is.
  static const std::uint64_t number = [] {
    std::random_device device;
    return std::uniform_int_distribution<std::uint64_t>(1, (std::uint64_t{1} << 48) - 1)(device);
  }();
  return number;
}

std::optional<std::uint64_t> InstanceOf(const StatusMessage& status) {
  for (const NamedCount& count : status.detections)
    if (count.name == kInstanceName) return count.count;
  return std::nullopt;
}

}  // namespace chequer
