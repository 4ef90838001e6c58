#include "detect/shadowed_pixels.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/normal_integral.h"

namespace chequer {
namespace {

/// What is known of the edge's parameters before the pixels are looked at: standard deviations.
const ShadowEdge::Parameters kKnownTo(0.1, 0.3, 0.4, 0.8);
/// The most that they move in a step, and what no longer counts.
const ShadowEdge::Parameters kMostMove(0.1, 0.3, 0.3, 0.5), kStill(0.003, 0.003, 0.004, 0.03);
/// Pixels that are off by more standard deviations count with less weight.
constexpr double kMostDeviations = 4;
/// How far a corner's pixels lie from it, cells.
constexpr double kFarthestPixel = 1;

/// What a cell's level, in a channel, has in common with the edge's parameters and what is left.
struct LevelSums {
  double square = 0, residual = 0;
  ShadowEdge::Parameters edge = ShadowEdge::Parameters::Zero();
};

/// The photometric model around a corner, without what it has for edges that are no Gaussian's.
struct CornerModel {
  Eigen::Vector2d corner;
  double scale_x, scale_y;  ///< blurs a cell
  std::array<int, 4> cells;

  CornerModel(const BoardPixels& pixels, int index, double blur_px) : cells(CellsAround(pixels.size(), index)) {
    const CornerPlace& place = pixels.place(index);
    const Eigen::Matrix2d board_by_pixel = place.pixel_by_board.inverse();
    corner = place.board;
    scale_x = 1 / (board_by_pixel.row(0).norm() * blur_px);
    scale_y = 1 / (board_by_pixel.row(1).norm() * blur_px);
  }

  struct Shares {
    double right, down;
  };
  Shares At(const Eigen::Vector2d& board) const {
    const NormalTable& integral = NormalTable::Get();
    return {integral(scale_x * (board.x() - corner.x())), integral(scale_y * (board.y() - corner.y()))};
  }
  double Light(const Shares& shares, std::span<const PhaseValues> levels, std::size_t phase) const {
    const auto level = [&](std::size_t i) { return double{levels[static_cast<std::size_t>(cells[i])][phase]}; };
    const double above = level(0) + shares.right * (level(1) - level(0)),
                 below = level(2) + shares.right * (level(3) - level(2));
    return above + shares.down * (below - above);
  }
  /// The cell that has most of a pixel.
  std::size_t Nearest(const Shares& shares) const {
    return static_cast<std::size_t>(cells[(shares.right > 0.5 ? 1u : 0u) + (shares.down > 0.5 ? 2u : 0u)]);
  }
};

/// Calls visit(corner, phase, lane) for every lane, always in the same order.
template <class Visit>
void ForLanes(const BoardPixels& pixels, const Visit& visit) {
  for (int corner = 0; corner < pixels.corners(); ++corner)
    for (int phase = 0; phase < 4; ++phase) visit(corner, phase, pixels.Lane(corner) + phase);
}

}  // namespace

void ShadowedPixels::Start(const ShadowEdge& edge, const BoardPixels& pixels) {
  start_ = edge.values();
  pixels_.clear();
  const LaneBlock& lanes = pixels.lanes();
  ForLanes(pixels, [&](int, int, int lane) {
    for (int i = 0; i < lanes.count(lane); ++i) {
      const std::size_t at = lanes.Place(lane, i);
      pixels_.push_back({lanes.u_data()[at], lanes.v_data()[at], lanes.light_data()[at]});
    }
  });
}

void ShadowedPixels::PutBack(BoardPixels& pixels) const {
  LaneBlock& lanes = pixels.lanes();
  const Pixel* next = pixels_.data();
  ForLanes(pixels, [&](int, int, int lane) {
    for (int i = 0; i < lanes.count(lane); ++i, ++next) {
      const std::size_t at = lanes.Place(lane, i);
      lanes.u_data()[at] = next->u;
      lanes.v_data()[at] = next->v;
      lanes.light_data()[at] = next->light;
    }
  });
}

bool ShadowedPixels::Move(const Known& known, std::span<const bool> used, const BoardPixels& pixels, ShadowEdge& edge) {
  const LaneBlock& lanes = pixels.lanes();
  const Eigen::Matrix3d board_from_plane = pixels.BoardFromPlane(*known.geometry);
  const auto on_board = [&](float u, float v) -> Eigen::Vector2d {
    return (board_from_plane * Eigen::Vector3d(u, v, 1)).hnormalized();
  };
  std::array<std::array<LevelSums, 3>, kMaxCells> levels{};
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  ShadowEdge::Parameters gradient = ShadowEdge::Parameters::Zero();
  const Pixel* next = pixels_.data();
  ForLanes(pixels, [&](int corner, int parity, int lane) {
    const int pixels_of_lane = lanes.count(lane);
    // Where the light does not differ, the levels take up all that an edge may change.
    if (!used[static_cast<std::size_t>(corner)] || !edge.Crosses(pixels.place(corner).board, kFarthestPixel)) {
      next += pixels_of_lane;
      return;
    }
    const CornerModel around(pixels, corner, known.blur_px);
    const std::size_t phase = static_cast<std::size_t>(parity),
                      channel = static_cast<std::size_t>(known.channel_of_phase[phase]);
    for (int i = 0; i < pixels_of_lane; ++i, ++next) {
      if (next->light >= known.saturation) continue;
      const std::size_t at = lanes.Place(lane, i);
      const CornerModel::Shares shares = around.At(on_board(lanes.u_data()[at], lanes.v_data()[at]));
      const Eigen::Vector2d place = on_board(next->u, next->v);
      const double far = known.far_cells ? double{known.far_cells->Of(lanes, lane, i)} : 0;
      const double even = around.Light(shares, known.levels, phase) + far, lit = edge.At(place);
      const double residual = double{next->light} - lit * even;
      const double variance =
          double{known.noise->floor[channel]} + double{known.noise->slope[channel]} * std::max(lit * even, 0.0);
      const double deviations = std::abs(residual) / std::sqrt(variance);
      const double weight = (deviations > kMostDeviations ? kMostDeviations / deviations : 1.0) / variance;
      const ShadowEdge::Parameters by = even * edge.ByParameters(place);
      normal += weight * by * by.transpose();
      gradient += weight * residual * by;
      LevelSums& level = levels[around.Nearest(shares)][channel];
      level.square += weight * lit * lit;
      level.residual += weight * lit * residual;
      level.edge += weight * lit * by;
    }
  });
  for (const auto& channels : levels)
    for (const LevelSums& level : channels) {
      if (level.square <= 0) continue;
      normal -= level.edge * level.edge.transpose() / level.square;
      gradient -= level.edge * (level.residual / level.square);
    }
  const ShadowEdge::Parameters known_as = kKnownTo.cwiseProduct(kKnownTo).cwiseInverse();
  normal.diagonal() += known_as;
  gradient -= known_as.cwiseProduct(edge.values() - start_);
  const ShadowEdge::Parameters step = normal.ldlt().solve(gradient).cwiseMax(-kMostMove).cwiseMin(kMostMove);
  if (!step.allFinite()) return false;
  edge = ShadowEdge(edge.values() + step);
  return (step.cwiseAbs().array() > kStill.array()).any();
}

}  // namespace chequer
