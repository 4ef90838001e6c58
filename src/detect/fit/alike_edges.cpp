#include "detect/fit/alike_edges.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/small_cholesky.h"

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

}  // namespace

std::optional<EdgeGroups> GroupEdgesAlongPixels(const UsedCorners& corners) {
  const CornerPlace& middle = corners.pixels.middle();
  const auto follow_pixels = [&](int axis) {
    const Eigen::RowVector2d across = middle.board_by_pixel.row(axis).cwiseAbs();
    return across.minCoeff() * middle.CellPx() < kAlongPixels * across.maxCoeff();
  };
  const bool along_x = follow_pixels(0), along_y = follow_pixels(1);
  if (!along_x && !along_y) return std::nullopt;
  // Edges of constant x follow the columns of the image, or its rows.
  const int across_x = std::abs(middle.board_by_pixel(0, 0)) > std::abs(middle.board_by_pixel(0, 1)) ? 0 : 1;
  std::optional<EdgeGroups> groups(std::in_place);
  groups->fill({-1, -1});
  corners.ForEach([&](int corner) {
    const auto group = [&](int axis) {
      return static_cast<int>(corners.pixels.place(corner).pixel[axis]) % AlikeEdges::kBlockPx;
    };
    (*groups)[static_cast<std::size_t>(corner)] = {along_x ? group(across_x) : -1, along_y ? group(1 - across_x) : -1};
  });
  return groups;
}

EdgeGroups GroupEdgesByLine(MarkerSize size) {
  EdgeGroups groups{};
  for (int corner = 0; corner < CornerCount(size); ++corner)
    groups[static_cast<std::size_t>(corner)] = {corner / (size.cols - 1) % AlikeEdges::kBlockPx,
                                                corner % (size.cols - 1) % AlikeEdges::kBlockPx};
  return groups;
}

std::optional<AlikePhases> FindAlikePhases(const UsedCorners& corners, double period_px) {
  const Eigen::Array<double, 2, 2> cell = corners.pixels.middle().board_by_pixel.inverse().array() / period_px;
  if ((cell - cell.round()).abs().maxCoeff() > kMostOffWhole) return std::nullopt;
  Eigen::Vector2d cosines = Eigen::Vector2d::Zero(), sines = Eigen::Vector2d::Zero();
  double count = 0;
  const double turn = 2 * std::numbers::pi / period_px;
  corners.ForEach([&](int corner) {
    const Eigen::Array2d phase = turn * corners.pixels.place(corner).pixel.array();
    cosines += phase.cos().matrix(), sines += phase.sin().matrix();
    ++count;
  });
  const double alike = (cosines.cwiseAbs2() + sines.cwiseAbs2()).minCoeff() / std::max(count * count, 1.0);
  if (alike < std::max(kAlike, kAboveChance / std::max(count, 1.0))) return std::nullopt;
  const Eigen::Vector2d middle(std::atan2(sines.x(), cosines.x()), std::atan2(sines.y(), cosines.y()));
  return AlikePhases{middle / turn, alike};
}

void GroupByParity(const UsedCorners& corners, const Eigen::Vector2d& middle_px, std::array<AlikeEdges, 2>& edges) {
  corners.ForEach([&](int corner) {
    const Eigen::Vector2i pixel = (corners.pixels.place(corner).pixel - middle_px).array().round().matrix().cast<int>();
    const int phase_there = (pixel.x() & 1) + 2 * (pixel.y() & 1);
    for (int phase = 0; phase < 4; ++phase)
      for (AlikeEdges& of_axis : edges)
        of_axis.group_of_lane[static_cast<std::size_t>(corners.pixels.Lane(corner) + phase)] = phase ^ phase_there;
  });
}

BoardGeometry::Information CovarianceOfGroups(const BoardGeometry::Information& in_pixels, double pixel_variance,
                                              std::span<const ShiftedCorner> corners,
                                              std::span<const CornerDerivative> derivatives, const EdgeGroups& groups) {
  using Parameters = BoardGeometry::Parameters;
  std::array<std::array<Parameters, AlikeEdges::kBlockPx>, 2> moves;
  for (auto& of_axis : moves) of_axis.fill(Parameters::Zero());
  std::array<std::array<double, AlikeEdges::kBlockPx>, 2> information{};
  for (const ShiftedCorner& corner : corners)
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const int group = groups[static_cast<std::size_t>(corner.corner)][axis];
      if (group < 0) continue;
      const CornerDerivative& by = derivatives[static_cast<std::size_t>(corner.corner)];
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
  return pixel_variance * covariance;
}

}  // namespace chequer
