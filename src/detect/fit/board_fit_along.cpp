// Of BoardFit: errors that pixels along an edge have in common.
#include <algorithm>
#include <cmath>

#include "core/small_cholesky.h"
#include "detect/common/widened.h"
#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Edges that leave their row or column of pixels by less along a cell may have errors that are alike (measured: JPEG
/// of quality 90 makes squared errors of 10 to 20 at 0.4 px or less; none at 0.4 to 0.8 px).
constexpr double kAlongPixels = 0.5;

}  // namespace

std::optional<BoardFit::EdgeGroups> BoardFit::GroupAlikeEdges() const {
  const Eigen::Matrix2d board_by_pixel = BoardByPixel();
  const auto follow_pixels = [&](int axis) {
    const Eigen::RowVector2d across = board_by_pixel.row(axis).cwiseAbs();
    return across.minCoeff() * CellPx() < kAlongPixels * across.maxCoeff();
  };
  const bool along_x = follow_pixels(0), along_y = follow_pixels(1);
  if (!along_x && !along_y) return std::nullopt;
  // Edges of constant x follow the columns of the image, or its rows.
  const int across_x = std::abs(board_by_pixel(0, 0)) > std::abs(board_by_pixel(0, 1)) ? 0 : 1;
  std::optional<EdgeGroups> groups(std::in_place);
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    const auto group = [&](int axis) {
      return static_cast<int>(pixels_.place(corner).pixel[axis]) % AlikeEdges::kBlockPx;
    };
    const bool counts = pixels_.inside(corner) && used(corner);
    (*groups)[static_cast<std::size_t>(corner)] = {counts && along_x ? group(across_x) : -1,
                                                   counts && along_y ? group(1 - across_x) : -1};
  }
  return groups;
}

void BoardFit::TellEdgeTally() {
  run_->result.along_edges = {};
  EdgeTally& tally = run_->result.along_edges.own;
  if (run_->terms.look_farther) return;
  const std::optional<EdgeGroups> groups = GroupAlikeEdges();
  if (!groups) return;
  AlikeEdges edges[2];
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (const int group = (*groups)[static_cast<std::size_t>(corner)][axis]; group >= 0)
        std::fill_n(edges[axis].group_of_lane.begin() + pixels_.Lane(corner), 4, group);
  const LaneBlock& lanes = pixels_.lanes();
  if (lanes.is_folded())
    for (AlikeEdges& of_axis : edges) lanes.SpreadFolded(of_axis.group_of_lane.data());
  AddEdgeErrors(run_->plain_input, lanes, edges[0], edges[1]);
  work_.Add(WorkStep::kFitPixel, static_cast<std::uint64_t>(pixels_.pixels() / AlikeEdges::kStride));
  for (const AlikeEdges& of_axis : edges) tally.Add(of_axis, run_->told.pixel_variance);
}

std::optional<BoardGeometry::Information> BoardFit::CovarianceAlongEdges(
    const BoardGeometry::Information& in_pixels) const {
  using Parameters = BoardGeometry::Parameters;
  const std::optional<EdgeGroups> groups = GroupAlikeEdges();
  if (!groups) return std::nullopt;
  // Each group has one error that all its edges share.
  std::array<std::array<Parameters, AlikeEdges::kBlockPx>, 2> moves;
  for (auto& of_axis : moves) of_axis.fill(Parameters::Zero());
  std::array<std::array<double, AlikeEdges::kBlockPx>, 2> information{};
  for (const ShiftedCorner& corner : shifted_)
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const int group = (*groups)[static_cast<std::size_t>(corner.corner)][axis];
      if (group < 0) continue;
      const CornerDerivative& by = derivatives_[static_cast<std::size_t>(corner.corner)];
      const Eigen::Vector2d of_axis = corner.information.col(static_cast<Eigen::Index>(axis));
      moves[axis][static_cast<std::size_t>(group)] += by.x * of_axis.x() + by.y * of_axis.y();
      information[axis][static_cast<std::size_t>(group)] += of_axis[static_cast<Eigen::Index>(axis)];
    }
  const SmallCholesky<BoardGeometry::kParameters> factor(in_pixels);
  BoardGeometry::Information covariance = BoardGeometry::Information::Zero();
  for (std::size_t axis = 0; axis < 2; ++axis)
    for (std::size_t group = 0; group < AlikeEdges::kBlockPx; ++group) {
      if (!(information[axis][group] > 0)) continue;
      const Parameters move = factor.Solve(moves[axis][group]);
      covariance += move * move.transpose() / information[axis][group];
    }
  return run_->told.pixel_variance * covariance;
}

BoardGeometry::Information BoardFit::CountAlongEdges(const BoardGeometry::Information& in_pixels,
                                                     const BoardGeometry::Information& of_moves) {
  SharedEdgeErrors& along = run_->result.along_edges;
  const std::optional<BoardGeometry::Information> of_unit = CovarianceAlongEdges(in_pixels);
  if (!of_unit) return of_moves;
  const BoardGeometry::Information by_moves = run_->result.geometry.ParametersByMoves();
  along.covariance = by_moves.lazyProduct(of_unit->lazyProduct(by_moves.transpose()).eval());
  EdgeTally all = run_->view.edge_tally;
  all.Add(along.own);
  along.counted = all.MoreOf(along.own);
  if (along.counted == 0) return of_moves;
  return WidenedBy(of_moves, along.counted * *of_unit);
}

}  // namespace chequer
