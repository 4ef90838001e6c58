// A detector that finds nothing by itself: it reports one marker whose id is the first pixel and that stands obliquely
// in the middle of the frame. Compiled also as libraries that are to be refused.
#include <cstddef>
#include <cstdint>

#include "bench/peer_plugin.h"

namespace {

struct Frame {
  int width;
  int height;
};

/// A rim of one cell around 2 × 2 that hold the id's bits, the lowest first.
void Draw(int id, std::uint8_t* cells) {
  for (int cell = 0; cell < 16; ++cell) cells[cell] = 1;
  for (int bit = 0; bit < 4; ++bit) cells[4 * (1 + bit / 2) + 1 + bit % 2] = (id >> bit & 1) != 0 ? 1 : 0;
}

void* Create(int width, int height) { return width > 0 && height > 0 ? new Frame{width, height} : nullptr; }
void Destroy(void* detector) { delete static_cast<Frame*>(detector); }

int Detect(void* detector, const std::uint8_t* grey, std::size_t, ChequerPeerMarker* markers, int capacity) {
  if (capacity < 1) return 0;
  const Frame& frame = *static_cast<Frame*>(detector);
  // A square of 0.1 m at 0.5 m from a camera with f = 500 px, its top leaning away by arcsin 0.6.
  const double x = frame.width / 2.0, y = frame.height / 2.0;
  const double far_px = 500 / 0.53, near_px = 500 / 0.47;
  markers[0] = {grey[0],
                {{x - 0.05 * far_px, y - 0.04 * far_px},
                 {x + 0.05 * far_px, y - 0.04 * far_px},
                 {x + 0.05 * near_px, y + 0.04 * near_px},
                 {x - 0.05 * near_px, y + 0.04 * near_px}}};
  return 1;
}

#ifdef CHEQUER_FAKE_IS_STALE
constexpr int kAbi = CHEQUER_PEER_ABI - 1;
#else
constexpr int kAbi = CHEQUER_PEER_ABI;
#endif

[[maybe_unused]] constexpr ChequerPeer kPeer{.abi = kAbi,
                                             .name = "fake",
                                             .pattern = "squares",
                                             .draw = Draw,
                                             .cells = 4,
                                             .rim = 1,
                                             .ids = 16,
                                             .create = Create,
                                             .destroy = Destroy,
                                             .detect = Detect};

}  // namespace

#ifndef CHEQUER_FAKE_IS_MUTE
const ChequerPeer* chequer_peer() { return &kPeer; }
#endif
