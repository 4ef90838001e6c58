#include "daemon/marker_detail.h"

#include <algorithm>
#include <cmath>

#include "chequer/detect_trace.h"
#include "core/crop.h"
#include "detect/toolbox.h"

namespace chequer {
namespace {

/// A marker without an id is recognised by its place from one frame to the next: half of a small board.
constexpr double kNearestPx = 40;
/// Units of work (DetectStats): some 10 ms of one core, more than any one marker of a usual size takes.
constexpr std::uint64_t kDetailBudget = 50'000;

DetectorOptions OptionsFor(DetectorOptions options) {
  options.camera.reset();  // it is for whole frames
  options.threads = 1;
  options.on_progress = nullptr;
  options.on_thread_start = nullptr;
  options.budget = kDetailBudget;
  return options;
}

/// Twice as far as its corners reach, so that the whole board and some of the ground around it are seen.
int ReachPx(const MarkerPose& marker) {
  double most = 8;
  for (int i = 0; i < CornerCount(marker.size); ++i) {
    const Eigen::Vector2d corner = marker.corners[static_cast<std::size_t>(i)].cast<double>();
    if (corner.allFinite()) most = std::max(most, (corner - marker.center_px).norm());
  }
  return static_cast<int>(std::ceil(2 * most)) + 8;
}

const TraceCandidate* CandidateOf(const DetectTrace& trace, int marker) {
  const auto found = std::find_if(trace.candidates.begin(), trace.candidates.end(),
                                  [&](const TraceCandidate& candidate) { return candidate.marker == marker; });
  return found == trace.candidates.end() ? nullptr : &*found;
}

NormalSummary SummaryOf(const GaussianSum& sum) {
  const Gaussian gaussian = sum.Get();
  return {gaussian.mean, gaussian.deviation};
}

void FillCells(const TraceCandidate& candidate, const Eigen::Vector2f& offset, DetailMessage& detail) {
  GaussianSum dark, light, plain, saturated;
  for (const TraceCell& cell : candidate.cells) {
    DetailCell out{.outline_px = cell.outline_px,
                   .luminance = cell.luminance,
                   .saturation = cell.saturation,
                   .saturated = cell.saturated,
                   .expected = cell.expected,
                   .seen = cell.seen,
                   .log_likelihood = cell.log_likelihood};
    for (Eigen::Vector2f& corner : out.outline_px)
      corner = cell.HasPlace() ? Eigen::Vector2f(corner + offset) : Eigen::Vector2f::Constant(std::nanf(""));
    detail.cells.push_back(out);
    if (!cell.seen) continue;
    (cell.dark() ? dark : light).Add(static_cast<double>(cell.luminance));
    if (cell.saturated || cell.expected)
      (cell.saturated.value_or(cell.expected.value_or(false)) ? saturated : plain)
          .Add(static_cast<double>(cell.saturation));
  }
  detail.luminance_dark = SummaryOf(dark);
  detail.luminance_light = SummaryOf(light);
  detail.saturation_plain = SummaryOf(plain);
  detail.saturation_saturated = SummaryOf(saturated);
}

void FillMarker(const MarkerPose& marker, const Eigen::Vector2f& offset, DetailMessage& detail) {
  detail.found = true;
  detail.family = marker.family;
  detail.id = marker.id;
  detail.variant = marker.variant;
  detail.size = marker.size;
  detail.center_px = marker.center_px + offset.cast<double>();
  detail.bits_corrected = marker.bits_corrected;
  detail.reprojection_rms_px = marker.reprojection_rms_px;
  detail.warnings = marker.warnings;
  detail.luminance_overlap = marker.luminance_overlap;
  detail.saturation_overlap = marker.saturation_overlap;
  for (int i = 0; i < CornerCount(marker.size); ++i)
    detail.corners.emplace_back(marker.corners[static_cast<std::size_t>(i)] + offset);
}

}  // namespace

const MarkerPose* FindChoice(const MarkerChoice& choice, const std::vector<MarkerPose>& markers) {
  const MarkerPose* best = nullptr;
  double nearest = kNearestPx;
  for (const MarkerPose& marker : markers) {
    if (choice.id && (marker.family != choice.family || marker.id != choice.id)) continue;
    const double distance = (marker.center_px - choice.center_px).norm();
    if (!choice.id && distance >= nearest) continue;
    best = &marker;
    nearest = distance;
    if (choice.id) break;
  }
  return best;
}

MarkerDetail::MarkerDetail(const DetectorOptions& options) : detector_(OptionsFor(options)) {}

DetailMessage MarkerDetail::Look(const ImageView& image, const MarkerPose& seen) {
  DetailMessage detail;
  const int reach = ReachPx(seen);
  int x = static_cast<int>(seen.center_px.x()) - reach, y = static_cast<int>(seen.center_px.y()) - reach;
  int width = 2 * reach, height = 2 * reach;
  const ImageView part = Crop(image, x, y, width, height);
  if (part.empty()) {
    detail.message = "it lies at the frame's edge";
    return detail;
  }
  const Eigen::Vector2f offset(static_cast<float>(x), static_cast<float>(y));
  DetectTrace trace;
  detector_.Detect(part, markers_, &trace);
  MarkerChoice same{.family = seen.family, .id = seen.id, .center_px = seen.center_px - offset.cast<double>()};
  const MarkerPose* marker = FindChoice(same, markers_);
  if (marker == nullptr) {
    detail.message =
        "seen in the whole frame, but not in the part around it alone: it hangs on what was left for later";
    return detail;
  }
  FillMarker(*marker, offset, detail);
  const TraceCandidate* candidate = CandidateOf(trace, static_cast<int>(marker - markers_.data()));
  if (candidate == nullptr) return detail;
  if (candidate->refusal != Refusal::kNone) detail.message = Explain(*candidate);
  FillCells(*candidate, offset, detail);
  return detail;
}

}  // namespace chequer
