#include <vector>

#include "chequer/check.h"
#include "chequer_ask_t.h"
#include "chequer_calibration_reference_t.h"
#include "chequer_calibration_t.h"
#include "chequer_camera_family_t.h"
#include "chequer_camera_t.h"
#include "chequer_count_t.h"
#include "chequer_detail_cell_t.h"
#include "chequer_detail_t.h"
#include "chequer_marker_pose_t.h"
#include "chequer_poses_t.h"
#include "chequer_preview_t.h"
#include "chequer_robot_pose_t.h"
#include "chequer_robots_t.h"
#include "chequer_stage_latency_t.h"
#include "chequer_status_t.h"
#include "chequer_track_t.h"
#include "chequer_tracks_t.h"
#include "fuzz/lcm_types.h"

namespace chequer::test {
namespace {

/// Another type for each row of the table below.
template <typename Type>
struct Functions {
  std::int64_t (*hash)();
  int (*decode)(const void*, int, int, Type*);
  int (*cleanup)(Type*);
  int (*encoded_size)(const Type*);
  int (*encode)(void*, int, int, const Type*);
};

template <typename Type>
std::uint64_t Try(const Functions<Type>& functions, const std::uint8_t* data, std::size_t size) {
  if (data == nullptr) return static_cast<std::uint64_t>(functions.hash());
  Type message{};
  const int read = functions.decode(data, 0, static_cast<int>(size), &message);
  if (read < 0) return 0;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(functions.encoded_size(&message)));
  CHEQUER_CHECK(functions.encode(bytes.data(), 0, static_cast<int>(bytes.size()), &message) >= 0, "not encoded again");
  functions.cleanup(&message);
  return 0;
}

#define CHEQUER_TRY(type) \
  Try<type>({__##type##_get_hash, type##_decode, type##_decode_cleanup, type##_encoded_size, type##_encode}, data, size)

}  // namespace

std::uint64_t TryCType(int type, const std::uint8_t* data, std::size_t size) {
  switch (type) {
    case 0: return CHEQUER_TRY(chequer_count_t);
    case 1: return CHEQUER_TRY(chequer_marker_pose_t);
    case 2: return CHEQUER_TRY(chequer_poses_t);
    case 3: return CHEQUER_TRY(chequer_robot_pose_t);
    case 4: return CHEQUER_TRY(chequer_robots_t);
    case 5: return CHEQUER_TRY(chequer_stage_latency_t);
    case 6: return CHEQUER_TRY(chequer_status_t);
    case 7: return CHEQUER_TRY(chequer_track_t);
    case 8: return CHEQUER_TRY(chequer_tracks_t);
    case 9: return CHEQUER_TRY(chequer_ask_t);
    case 10: return CHEQUER_TRY(chequer_camera_family_t);
    case 11: return CHEQUER_TRY(chequer_camera_t);
    case 12: return CHEQUER_TRY(chequer_detail_cell_t);
    case 13: return CHEQUER_TRY(chequer_detail_t);
    case 14: return CHEQUER_TRY(chequer_preview_t);
    case 15: return CHEQUER_TRY(chequer_calibration_reference_t);
    default: return CHEQUER_TRY(chequer_calibration_t);
  }
}

}  // namespace chequer::test
