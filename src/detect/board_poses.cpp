#include "detect/board_poses.h"

#include "detect/identity/marker_description.h"

namespace chequer {
namespace {

/// The covariance of a pose by the plain fit where another would explain the board better, over what that fit says.
/// With it, squared errors over the covariance are 0.6 to 1.1 in the mean, measured on robots that move, knocks and
/// hands.
constexpr double kPlainCovariance = 4;

/// Finds a board's poses anew with the edges' errors as all boards tell them, where it alone did not show them so.
void CountEdges(const EdgeTally& all, const SharedEdgeErrors& along_edges, BoardPoses& poses) {
  const auto information = along_edges.Recounted(poses.measured.information, all);
  if (!information) return;
  BoardMeasurement measured = poses.measured;
  measured.information = *information;
  if (const auto anew = PosesOf(measured)) poses = *anew;
}

}  // namespace

void DescribePoses(ImageState& frame) {
  EdgeTally all = frame.edge_tally;
  frame.AddEdgesTo(all);
  for (BoardOutcome& outcome : frame.outcomes) {
    if (!outcome.accepted || !outcome.poses) continue;
    CountEdges(all, outcome.along_edges, *outcome.poses);
    DescribePose(*outcome.poses, outcome.marker);
    if (outcome.plain_covariance) outcome.marker.covariance *= kPlainCovariance;
  }
}

}  // namespace chequer
