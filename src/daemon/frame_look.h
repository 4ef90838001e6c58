#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "core/picture_check.h"

namespace chequer {

/// What one frame shows of why markers are not read, for the hints of a status. Taken once a status, as it costs more
/// than to detect alone.
struct FrameLook {
  struct Kernel {
    int family = 0;  ///< index into DetectorOptions::families: the first of that size
    std::uint64_t kernel = 0;
    bool has_id = false;
  };
  std::optional<PictureCheck> picture;  ///< where no board was found: it then matters, and takes a millisecond
  std::vector<Kernel> kernels;          ///< of boards all cells of which were seen well
  int borderless = 0;                   ///< large groups of corners without the border of a marker that is sought
  int mirrored = 0;                     ///< of them, those whose border has its inks the other way round
};

/// @param image what was searched. @param families that were sought. @param trace of the detection.
FrameLook LookAt(const ImageView& image, const std::vector<MarkerFamily>& families, std::span<const MarkerPose> markers,
                 const DetectTrace& trace);

}  // namespace chequer
