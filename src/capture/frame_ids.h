#pragma once

#include <cstdint>
#include <optional>

namespace chequer {

/// Turns the frame ids of GigE Vision 1, which go from 1 to 65535 and begin at 1 again, into numbers that rise. Ids of
/// 64 bits are kept as they are. One thread.
class FrameIds {
 public:
  /// The number of the frame with that id, which came after the one before.
  std::uint64_t Number(std::uint64_t id) {
    constexpr std::uint64_t kCycle = 65535;
    if (!last_id_) {
      number_ = id;
    } else if (id<*last_id_&& * last_id_ <= kCycle&& * last_id_ - id> kCycle / 2) {
      number_ += id + kCycle - *last_id_;
    } else if (id > *last_id_) {
      number_ += id - *last_id_;
    } else {
      number_ = id;  // the camera began to count anew
    }
    last_id_ = id;
    return number_;
  }

 private:
  std::optional<std::uint64_t> last_id_;
  std::uint64_t number_ = 0;
};

}  // namespace chequer
