#include <chequer/ask_t.hpp>
#include <chequer/calibration_reference_t.hpp>
#include <chequer/calibration_t.hpp>
#include <chequer/camera_family_t.hpp>
#include <chequer/camera_t.hpp>
#include <chequer/count_t.hpp>
#include <chequer/detail_cell_t.hpp>
#include <chequer/detail_t.hpp>
#include <chequer/marker_pose_t.hpp>
#include <chequer/poses_t.hpp>
#include <chequer/preview_t.hpp>
#include <chequer/robot_pose_t.hpp>
#include <chequer/robots_t.hpp>
#include <chequer/stage_latency_t.hpp>
#include <chequer/status_t.hpp>
#include <chequer/track_t.hpp>
#include <chequer/tracks_t.hpp>
#include <vector>

#include "chequer/check.h"
#include "fuzz/lcm_types.h"

namespace chequer::test {
namespace {

template <typename Type>
std::uint64_t Try(const std::uint8_t* data, std::size_t size) {
  if (data == nullptr) return static_cast<std::uint64_t>(Type::getHash());
  Type message{};
  if (message.decode(data, 0, static_cast<int>(size)) < 0) return 0;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  CHEQUER_CHECK(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0, "not encoded again");
  return 0;
}

}  // namespace

std::uint64_t TryCppType(int type, const std::uint8_t* data, std::size_t size) {
  switch (type) {
    case 0: return Try<count_t>(data, size);
    case 1: return Try<marker_pose_t>(data, size);
    case 2: return Try<poses_t>(data, size);
    case 3: return Try<robot_pose_t>(data, size);
    case 4: return Try<robots_t>(data, size);
    case 5: return Try<stage_latency_t>(data, size);
    case 6: return Try<status_t>(data, size);
    case 7: return Try<track_t>(data, size);
    case 8: return Try<tracks_t>(data, size);
    case 9: return Try<ask_t>(data, size);
    case 10: return Try<camera_family_t>(data, size);
    case 11: return Try<camera_t>(data, size);
    case 12: return Try<detail_cell_t>(data, size);
    case 13: return Try<detail_t>(data, size);
    case 14: return Try<preview_t>(data, size);
    case 15: return Try<calibration_reference_t>(data, size);
    default: return Try<calibration_t>(data, size);
  }
}

}  // namespace chequer::test
