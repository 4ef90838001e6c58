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

/// Adds a board unless it was counted: what the first look refused may be viewed again by the second.
void CountOnce(const TraceCandidate& board, std::vector<const TraceCandidate*>& counted) {
  double reach = 0;
  for (const TraceCell& cell : board.cells)
    if (cell.HasPlace()) reach = std::max(reach, (cell.center_px - board.center_px).norm());
  const bool again = std::any_of(counted.begin(), counted.end(), [&](const TraceCandidate* other) {
    return (other->center_px - board.center_px).norm() < reach / 2;
  });
  if (!again) counted.push_back(&board);
}

}  // namespace

FrameLook LookAt(const ImageView& image, const std::vector<MarkerFamily>& families, std::span<const MarkerPose> markers,
                 const DetectTrace& trace) {
  FrameLook look;
  if (markers.empty()) look.picture = CheckPicture(image, kLines);
  std::vector<const TraceCandidate*> mirrored;
  for (const TraceCandidate& candidate : trace.candidates) {
    if (candidate.marker < 0) {
      look.borderless += candidate.corners.size() >= kBoardLike || candidate.CameFar() ? 1 : 0;
      if (HasMirroredInks(candidate)) CountOnce(candidate, mirrored);
      continue;
    }
    const auto kernel = KernelOf(candidate);
    const int family = FirstFamilyOf(families, candidate.size);
    if (kernel && family >= 0)
      look.kernels.push_back({family, *kernel, markers[static_cast<std::size_t>(candidate.marker)].id.has_value()});
  }
  look.mirrored = static_cast<int>(mirrored.size());
  return look;
}

}  // namespace chequer
