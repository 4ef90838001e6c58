// Of BoardFit: errors that pixels along an edge have in common, or pixels beside corners that lie alike.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/small_cholesky.h"
#include "detect/common/widened.h"
#include "detect/fit/board_fit.h"

namespace chequer {
namespace {

/// Edges that leave their row or column of pixels by less along a cell may have errors that are alike (measured: JPEG
/// of quality 90 makes squared errors of 10 to 20 at 0.4 px or less; none at 0.4 to 0.8 px).
constexpr double kAlongPixels = 0.5;
/// Corners lie alike between the pixels where that is the squared length of the mean of their phases, which is 1 where
/// all have the same and 0 where they have any (measured: sharpening makes squared errors of 4 at 0.17, of 2 at 0,
/// where each row has the same). Chance makes one over their number of it.
constexpr double kAlike = 0.06, kAboveChance = 1.5;
/// Cells are whole pixels along rows and columns then, but for that (derived: with 0.17, the mean of five corners'
/// phases is that short).
constexpr double kMostOffWhole = 0.18;
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

std::optional<BoardFit::AlikePhases> BoardFit::PhaseOfAlikeCorners(double period_px) const {
  const Eigen::Array<double, 2, 2> cell = BoardByPixel().inverse().array() / period_px;
  if ((cell - cell.round()).abs().maxCoeff() > kMostOffWhole) return std::nullopt;
  Eigen::Vector2d cosines = Eigen::Vector2d::Zero(), sines = Eigen::Vector2d::Zero();
  double count = 0;
  const double turn = 2 * std::numbers::pi / period_px;
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner) || !used(corner)) continue;
    const Eigen::Array2d phase = turn * pixels_.place(corner).pixel.array();
    cosines += phase.cos().matrix(), sines += phase.sin().matrix();
    ++count;
  }
  const double alike = (cosines.cwiseAbs2() + sines.cwiseAbs2()).minCoeff() / std::max(count * count, 1.0);
  if (alike < std::max(kAlike, kAboveChance / std::max(count, 1.0))) return std::nullopt;
  const Eigen::Vector2d middle(std::atan2(sines.x(), cosines.x()), std::atan2(sines.y(), cosines.y()));
  return AlikePhases{middle / turn, alike};
}

EdgeTally BoardFit::TallyOf(AlikeEdges& x, AlikeEdges& y, AlikePlaces* places) {
  const LaneBlock& lanes = pixels_.lanes();
  if (lanes.is_folded())
    for (AlikeEdges* of_axis : {&x, &y}) lanes.SpreadFolded(of_axis->group_of_lane.data());
  const auto looked_at = static_cast<std::uint64_t>(pixels_.pixels() / AlikeEdges::kStride);
  if (run_->terms.look_farther) {
    AddEdgeErrors(run_->model_input, lanes, model_lanes_, static_cast<float>(run_->model.blur_px), x, y, places);
    work_.Add(WorkStep::kModelTap, looked_at * static_cast<std::uint64_t>(run_->model_input.taps));
  } else {
    AddEdgeErrors(run_->plain_input, lanes, x, y, places);
    work_.Add(WorkStep::kFitPixel, looked_at);
  }
  EdgeTally tally;
  for (const AlikeEdges* of_axis : {&x, &y}) tally.Add(*of_axis, run_->told.pixel_variance);
  return tally;
}

void BoardFit::TellEdgeTally() {
  run_->result.along_edges = {};
  run_->told.shared_by_corners = 0;
  const std::optional<EdgeGroups> groups = GroupAlikeEdges();
  if (!groups) return;
  const std::optional<AlikePhases> alike = PhaseOfAlikeCorners(1);
  // Where a motion is fitted, it tells other boards nothing: what it is off by is none of the camera's.
  const bool stands = !run_->terms.look_farther || run_->model.motion_px.isZero();
  if (!stands && !alike) return;
  AlikeEdges edges[2];
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (const int group = (*groups)[static_cast<std::size_t>(corner)][axis]; group >= 0)
        std::fill_n(edges[axis].group_of_lane.begin() + pixels_.Lane(corner), 4, group);
  AlikePlaces places;
  const EdgeTally own = TallyOf(edges[0], edges[1], alike ? &places : nullptr);
  if (stands) run_->result.along_edges.own = own;
  if (!alike) return;
  run_->told.shared_by_corners = places.Shared() / std::sqrt(alike->alike);
  run_->told.corners_alike = alike->alike;
}

double BoardFit::MoreOfAlikeCorners(const Eigen::Vector2d& phase_of_all) {
  AlikeEdges edges[2];
  for (int corner = 0; corner < pixels_.corners(); ++corner) {
    if (!pixels_.inside(corner) || !used(corner)) continue;
    // Pixels whose offsets from their corners have the same parity.
    const Eigen::Vector2i pixel = (pixels_.place(corner).pixel - phase_of_all).array().round().matrix().cast<int>();
    const int phase_there = (pixel.x() & 1) + 2 * (pixel.y() & 1);
    for (int phase = 0; phase < 4; ++phase)
      for (AlikeEdges& of_axis : edges)
        of_axis.group_of_lane[static_cast<std::size_t>(pixels_.Lane(corner) + phase)] = phase ^ phase_there;
  }
  const EdgeTally own = TallyOf(edges[0], edges[1], nullptr);
  return own.MoreOf(own);
}

BoardGeometry::Information BoardFit::CountAlikeCorners(const BoardGeometry::Information& in_pixels,
                                                       const BoardGeometry::Information& of_moves) {
  std::optional<AlikePhases> phases = PhaseOfAlikeCorners(1);
  if (!phases) phases = PhaseOfAlikeCorners(2);
  const double more = phases ? MoreOfAlikeCorners(phases->middle_px) : 0;
  if (more == 0) return of_moves;
  return WidenedBy(of_moves, more * CovarianceOfGroups(in_pixels, EdgeGroups{}));
}

BoardGeometry::Information BoardFit::CovarianceOfGroups(const BoardGeometry::Information& in_pixels,
                                                        const EdgeGroups& groups) const {
  using Parameters = BoardGeometry::Parameters;
  // Each group has one error that all its edges share.
  std::array<std::array<Parameters, AlikeEdges::kBlockPx>, 2> moves;
  for (auto& of_axis : moves) of_axis.fill(Parameters::Zero());
  std::array<std::array<double, AlikeEdges::kBlockPx>, 2> information{};
  for (const ShiftedCorner& corner : shifted_)
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const int group = groups[static_cast<std::size_t>(corner.corner)][axis];
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
  const std::optional<EdgeGroups> groups = GroupAlikeEdges();
  if (!groups) return CountAlikeCorners(in_pixels, of_moves);
  SharedEdgeErrors& along = run_->result.along_edges;
  const BoardGeometry::Information of_unit = CovarianceOfGroups(in_pixels, *groups),
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
  // its own beside. (Of large boards, lines that are eight apart have the same.)
  EdgeGroups lines;
  const int across = run_->view.size.cols - 1;
  for (int corner = 0; corner < pixels_.corners(); ++corner)
    lines[static_cast<std::size_t>(corner)] = {corner / across % AlikeEdges::kBlockPx,
                                               corner % across % AlikeEdges::kBlockPx};
  return WidenedBy(of_moves, more * (CovarianceOfGroups(in_pixels, EdgeGroups{}) +
                                     (1 - run_->told.corners_alike) * CovarianceOfGroups(in_pixels, lines)));
}

}  // namespace chequer
