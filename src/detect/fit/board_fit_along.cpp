// Of BoardFit: errors that pixels along an edge have in common, or pixels beside corners that lie alike.
#include <algorithm>
#include <cmath>

#include "detect/common/widened.h"
#include "detect/fit/alike_edges.h"
#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Of what corners share that lie alike and whose edges follow the pixels, over the root of how much they are alike,
/// the part that the fit's moves of them have (measured, of boards of 6 and 8 px cells alone in images that are
/// sharpened, blurred, median filtered or demosaiced: squared errors of position are then .2 to 2.2; without that 1.5
/// to 35).
constexpr double kMovesOfShared = 0.05;
/// Of that, what the edges' tally has seen counts so often (measured: with 1, squared errors in JPEG of quality 90,
/// whose blocks are as wide as the cells, are .63; with 4, those of boards of 8 px cells that are blurred are 2.9 and
/// of orientation 7.6, instead of 2.2 and 4.9).
constexpr double kSeenByTally = 2;

}  // namespace

EdgeTally BoardFit::TallyOf(std::array<AlikeEdges, 2>& edges, AlikePlaces* places) {
  const LaneBlock& lanes = pixels_.lanes();
  if (lanes.is_folded())
    for (AlikeEdges& of_axis : edges) lanes.SpreadFolded(of_axis.group_of_lane.data());
  const auto looked_at = static_cast<std::uint64_t>(pixels_.pixels() / AlikeEdges::kStride);
  if (run_->terms.look_farther) {
    AddEdgeErrors(run_->model_input, lanes, model_lanes_, static_cast<float>(run_->model.blur_px), edges[0], edges[1],
                  places);
    work_.Add(WorkStep::kModelTap, looked_at * static_cast<std::uint64_t>(run_->model_input.taps));
  } else {
    AddEdgeErrors(run_->plain_input, lanes, edges[0], edges[1], places);
    work_.Add(WorkStep::kFitPixel, looked_at);
  }
  EdgeTally tally;
  for (const AlikeEdges& of_axis : edges) tally.Add(of_axis, run_->told.pixel_variance);
  return tally;
}

void BoardFit::TellEdgeTally() {
  run_->result.along_edges = {};
  run_->told.shared_by_corners = 0;
  const UsedCorners corners{pixels_, run_->visibility};
  run_->told.along_pixels = GroupEdgesAlongPixels(corners);
  if (!run_->told.along_pixels) return;
  const std::optional<AlikePhases> alike = FindAlikePhases(corners, 1);
  // Where a motion is fitted, it tells other boards nothing: what it is off by is none of the camera's.
  const bool stands = !run_->terms.look_farther || run_->model.motion_px.isZero();
  if (!stands && !alike) return;
  std::array<AlikeEdges, 2> edges;
  corners.ForEach([&](int corner) {
    for (std::size_t axis = 0; axis < 2; ++axis)
      std::fill_n(edges[axis].group_of_lane.begin() + pixels_.Lane(corner), 4,
                  (*run_->told.along_pixels)[static_cast<std::size_t>(corner)][axis]);
  });
  AlikePlaces places;
  const EdgeTally own = TallyOf(edges, alike ? &places : nullptr);
  if (stands) run_->result.along_edges.own = own;
  if (!alike) return;
  run_->told.shared_by_corners = places.Shared() / std::sqrt(alike->alike);
  run_->told.corners_alike = alike->alike;
}

BoardGeometry::Information BoardFit::CovarianceOf(const BoardGeometry::Information& in_pixels,
                                                  const EdgeGroups& groups) const {
  return CovarianceOfGroups(in_pixels, run_->told.pixel_variance, shifted_, derivatives_, groups);
}

BoardGeometry::Information BoardFit::CountAlikeCorners(const BoardGeometry::Information& in_pixels,
                                                       const BoardGeometry::Information& of_moves) {
  const UsedCorners corners{pixels_, run_->visibility};
  std::optional<AlikePhases> phases = FindAlikePhases(corners, 1);
  if (!phases) phases = FindAlikePhases(corners, 2);
  if (!phases) return of_moves;
  std::array<AlikeEdges, 2> edges;
  GroupByParity(corners, phases->middle_px, edges);
  const EdgeTally own = TallyOf(edges, nullptr);
  const double more = own.MoreOf(own);
  return more == 0 ? of_moves : WidenedBy(of_moves, more * CovarianceOf(in_pixels, EdgeGroups{}));
}

BoardGeometry::Information BoardFit::CountAlongEdges(const BoardGeometry::Information& in_pixels,
                                                     const BoardGeometry::Information& of_moves) {
  const std::optional<EdgeGroups>& groups = run_->told.along_pixels;
  if (!groups) return CountAlikeCorners(in_pixels, of_moves);
  SharedEdgeErrors& along = run_->result.along_edges;
  const BoardGeometry::Information of_unit = CovarianceOf(in_pixels, *groups),
                                   by_moves = run_->result.geometry.ParametersByMoves();
  along.covariance = by_moves.lazyProduct(of_unit.lazyProduct(by_moves.transpose()).eval());
  EdgeTally all = run_->view.edge_tally;
  all.Add(along.own);
  along.counted = all.MoreOf(along.own);
  const BoardGeometry::Information told = along.counted == 0 ? of_moves : WidenedBy(of_moves, along.counted * of_unit);
  return CountSharedByCorners(in_pixels, told);
}

BoardGeometry::Information BoardFit::CountSharedByCorners(const BoardGeometry::Information& in_pixels,
                                                          const BoardGeometry::Information& of_moves) const {
  const double more = kMovesOfShared * run_->told.shared_by_corners / run_->told.pixel_variance -
                      kSeenByTally * run_->result.along_edges.counted;
  if (!(more > 0)) return of_moves;
  // Where they are less alike, those of one row lie alike along the columns, and the reverse: each line has an error of
  // its own beside.
  return WidenedBy(
      of_moves, more * (CovarianceOf(in_pixels, EdgeGroups{}) +
                        (1 - run_->told.corners_alike) * CovarianceOf(in_pixels, GroupEdgesByLine(run_->view.size))));
}

}  // namespace chequer
