#include "daemon/frame_look.h"

#include <algorithm>

#include "detect/toolbox.h"

namespace chequer {
namespace {

/// Rows and columns of a picture that are looked at.
constexpr int kLines = 96;
/// A group with fewer linked corners may be clutter.
constexpr std::size_t kBoardLike = 9;

int FirstFamilyOf(const std::vector<MarkerFamily>& families, MarkerSize size) {
  const auto first = std::find_if(families.begin(), families.end(),
                                  [&](const MarkerFamily& family) { return family.code.size() == size; });
  return first == families.end() ? -1 : static_cast<int>(first - families.begin());
}

bool HasMirroredInks(const TraceCandidate& candidate) {
  return candidate.refusal == Refusal::kInksAlike && candidate.measured < -candidate.required;
}

}  // namespace

FrameLook LookAt(const ImageView& image, const std::vector<MarkerFamily>& families, std::span<const MarkerPose> markers,
                 const DetectTrace& trace) {
  FrameLook look;
  if (markers.empty()) look.picture = CheckPicture(image, kLines);
  for (const TraceCandidate& candidate : trace.candidates) {
    if (candidate.marker < 0) {
      look.borderless += candidate.corners.size() >= kBoardLike || candidate.CameFar() ? 1 : 0;
      look.mirrored += HasMirroredInks(candidate) ? 1 : 0;
      continue;
    }
    const auto kernel = KernelOf(candidate);
    const int family = FirstFamilyOf(families, candidate.size);
    if (kernel && family >= 0)
      look.kernels.push_back({family, *kernel, markers[static_cast<std::size_t>(candidate.marker)].id.has_value()});
  }
  return look;
}

}  // namespace chequer
