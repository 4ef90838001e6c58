#include "detect/board_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// The most pixels of a lane: large cells are thinned out to that.
constexpr int kLaneCapacity = 400;

/// How far outwards, in cells, the pixels of the board's rim are used: the rim itself is blurred with a background
/// that nothing is known of.
double OutwardReach(double px_per_cell, double blur_px) {
  return std::clamp(1 - (2.2 * blur_px + 0.5) / px_per_cell, 0.4, 0.9);
}

/// The inverse of a lens around one pixel, to second order.
struct LocalLens {
  Eigen::Vector2d pixel, plane;
  Eigen::Matrix2d by_pixel;             ///< d plane / d pixel
  Eigen::Vector2d by_xx, by_xy, by_yy;  ///< ½ d²/dx², d²/dxdy, ½ d²/dy²
};

/// Nothing where the lens has no inverse.
std::optional<LocalLens> LensAround(const Lens& lens, const Eigen::Vector2d& plane) {
  LocalLens local;
  local.plane = plane;
  local.by_xx = local.by_xy = local.by_yy = Eigen::Vector2d::Zero();
  if (!lens.calibrated()) {
    local.pixel = plane;
    local.by_pixel.setIdentity();
    return local;
  }
  Eigen::Matrix2d at, at_x, at_y;
  local.pixel = lens.ToImage(plane, &at);
  if (!(at.determinant() > 1e-6)) return std::nullopt;
  local.by_pixel = at.inverse();
  // Change of the inverse Jacobian over a step of h pixels along x and along y.
  constexpr double h = 2;
  lens.ToImage(plane + h * local.by_pixel.col(0), &at_x);
  lens.ToImage(plane + h * local.by_pixel.col(1), &at_y);
  const Eigen::Matrix2d by_x = (at_x.inverse() - local.by_pixel) / h, by_y = (at_y.inverse() - local.by_pixel) / h;
  local.by_xx = 0.5 * by_x.col(0);
  local.by_xy = by_x.col(1);
  local.by_yy = 0.5 * by_y.col(1);
  return local;
}

/// The plane coordinates of pixels around a local lens's pixel, from an origin: parabolas along rows, by differences.
struct PlaneWalk {
  float u, v, u_step, v_step, u_bend, v_bend;

  void Next() {
    u += u_step;
    v += v_step;
    u_step += u_bend;
    v_step += v_bend;
  }
};

/// From the pixel that lies (dx, dy) from the local lens's.
PlaneWalk WalkFrom(const LocalLens& lens, const Eigen::Vector2d& start, double dx, double dy) {
  const Eigen::Vector2d slope = lens.by_pixel.col(0) + dy * lens.by_xy, bend = lens.by_xx;
  const Eigen::Vector2d at = start + dy * (lens.by_pixel.col(1) + dy * lens.by_yy) + dx * (slope + dx * bend);
  const Eigen::Vector2d step = slope + (2 * dx + 1) * bend;
  return {static_cast<float>(at.x()),   static_cast<float>(at.y()),       static_cast<float>(step.x()),
          static_cast<float>(step.y()), static_cast<float>(2 * bend.x()), static_cast<float>(2 * bend.y())};
}

/// A band of the board between two lines of constant x or y, cut along rows of pixels: offsets along the row from the
/// corner's pixel, which move by `slope` a row.
struct Band {
  double low, high, slope;
};

/// The part of the board around a corner, in cells from it, and how it lies in the image.
struct Region {
  double left, right, top, bottom;
  Eigen::Matrix2d board_by_pixel;

  std::array<Band, 2> Bands() const {
    return {BandOf(board_by_pixel.row(0), left, right), BandOf(board_by_pixel.row(1), top, bottom)};
  }

 private:
  static Band BandOf(const Eigen::RowVector2d& by_pixel, double low, double high) {
    // Rows that run along the band: nearly so will do, as no board is 1e6 px wide.
    const double across = std::abs(by_pixel[0]) < 1e-6 ? std::copysign(1e-6, by_pixel[0]) : by_pixel[0];
    const double a = low / across, b = high / across;
    return {std::min(a, b), std::max(a, b), -by_pixel[1] / across};
  }
};

/// Which pixels of large cells are left out: whole 2 × 2 tiles, so that all parities stay balanced.
struct Thinning {
  int near_edges = 1, interior = 1;  ///< one tile in so many is kept
  float band_x = 0, band_y = 0;      ///< near an edge, cells

  bool Keeps(int x, int y, float board_x, float board_y) const {
    const int step = std::abs(board_x) > band_x && std::abs(board_y) > band_y ? interior : near_edges;
    return step == 1 || (x / 2 + (y / 2) * 3) % step == 0;
  }
};

Thinning ThinningOf(const Region& region, double px_x, double px_y, double blur_px) {
  Thinning thinning;
  const double width = region.right - region.left, height = region.bottom - region.top;
  if (px_x * px_y * width * height / 4 < kLaneCapacity * 0.8) return thinning;
  // Interior pixels say little but for the levels.
  const double band_px = std::max(0.5, 3.5 * blur_px);
  thinning.band_x = static_cast<float>(band_px / px_x);
  thinning.band_y = static_cast<float>(band_px / px_y);
  const double along = 2 * band_px * (px_y * height + px_x * width) / 4;
  thinning.near_edges = std::max(1, static_cast<int>(std::ceil(along / (kLaneCapacity * 0.85))));
  thinning.interior = 4 * thinning.near_edges;
  return thinning;
}

}  // namespace

void BoardPixels::RankCorners() {
  // Lanes that are evaluated together should have as many pixels: corners of the rim have more.
  int next = 0;
  for (int rims = 0; rims <= 4; ++rims)
    for (int corner = 0; corner < corners_; ++corner) {
      const int row = corner / (size_.cols - 1), col = corner % (size_.cols - 1);
      const int at = (row == 0) + (row == size_.rows - 2) + (col == 0) + (col == size_.cols - 2);
      if (at == rims) rank_[static_cast<std::size_t>(corner)] = next++;
    }
}

void BoardPixels::PlaceCorners(const Lens& lens, const BoardGeometry& geometry) {
  for (int corner = 0; corner < corners_; ++corner) {
    CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    Eigen::Matrix2d pixel_by_plane;
    place.pixel = lens.ToImage(geometry.ToPlane(place.board), &pixel_by_plane);
    place.pixel_by_board = pixel_by_plane * geometry.PlaneByBoard(place.board);
  }
}

int BoardPixels::Collect(const LightReader& reader, const Lens& lens, MarkerSize size, const BoardGeometry& geometry,
                         double blur_px) {
  if (corners_ == 0 || !(size == size_)) {
    size_ = size;
    corners_ = CornerCount(size);
    RankCorners();
  }
  for (int corner = 0; corner < corners_; ++corner)
    places_[static_cast<std::size_t>(corner)].board =
        CornerOnBoard(size_, corner / (size_.cols - 1), corner % (size_.cols - 1));
  PlaceCorners(lens, geometry);
  origin_ = geometry.ToPlane({0, 0});
  lanes_.Reset(4 * corners_, kLaneCapacity);
  if (!origin_.allFinite()) return 0;
  int inside = 0;
  for (int corner = 0; corner < corners_; ++corner) {
    CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    place.inside = place.pixel.allFinite() && place.pixel_by_board.allFinite() && place.pixel.x() > 1 &&
                   place.pixel.y() > 1 && place.pixel.x() < reader.width() - 2 &&
                   place.pixel.y() < reader.height() - 2 && place.pixel_by_board.determinant() > 1;
    if (!place.inside) continue;
    ++inside;
    CollectCorner(reader, lens, geometry, corner, blur_px);
  }
  return inside;
}

void BoardPixels::CollectCorner(const LightReader& reader, const Lens& lens, const BoardGeometry& geometry, int corner,
                                double blur_px) {
  CornerPlace& place = places_[static_cast<std::size_t>(corner)];
  const int corner_row = corner / (size_.cols - 1), corner_col = corner % (size_.cols - 1);
  Region region;
  region.board_by_pixel = place.pixel_by_board.inverse();
  const double px_x = 1 / region.board_by_pixel.row(0).norm(), px_y = 1 / region.board_by_pixel.row(1).norm();
  const double out_x = OutwardReach(px_x, blur_px), out_y = OutwardReach(px_y, blur_px);
  region.left = corner_col == 0 ? -out_x : -0.5;
  region.right = corner_col == size_.cols - 2 ? out_x : 0.5;
  region.top = corner_row == 0 ? -out_y : -0.5;
  region.bottom = corner_row == size_.rows - 2 ? out_y : 0.5;
  place.middle = {(region.left + region.right) / 2, (region.top + region.bottom) / 2};
  const std::optional<LocalLens> local = LensAround(lens, geometry.ToPlane(place.board));
  if (!local) return;
  const Thinning thinning = ThinningOf(region, px_x, px_y, blur_px);

  double y_min = 1e9, y_max = -1e9;
  for (const double x : {region.left, region.right})
    for (const double y : {region.top, region.bottom}) {
      const double dy = place.pixel_by_board(1, 0) * x + place.pixel_by_board(1, 1) * y;
      y_min = std::min(y_min, dy);
      y_max = std::max(y_max, dy);
    }
  const int first_row = std::max(0, static_cast<int>(std::ceil(place.pixel.y() + y_min)));
  const int last_row = std::min(reader.height() - 1, static_cast<int>(std::floor(place.pixel.y() + y_max)));
  const std::size_t stride = static_cast<std::size_t>(lanes_.padded());
  const std::size_t end = lanes_.Place(0, lanes_.capacity());
  float *const plane_u = lanes_.u_data(), *const plane_v = lanes_.v_data(), *const lights = lanes_.light_data();
  // Where the next pixel of each phase goes.
  std::array<std::size_t, 4> next{};
  for (int phase = 0; phase < 4; ++phase) next[static_cast<std::size_t>(phase)] = lanes_.Place(Lane(corner) + phase, 0);
  const std::array<Band, 2> bands = region.Bands();
  const Eigen::Vector2d start = local->plane - origin_;
  for (int y = first_row; y <= last_row; ++y) {
    const double dy = y - place.pixel.y();
    const double shift_x = place.pixel.x() + dy * bands[0].slope, shift_y = place.pixel.x() + dy * bands[1].slope;
    const double from = std::max({bands[0].low + shift_x, bands[1].low + shift_y, 0.0});
    const double to = std::min({bands[0].high + shift_x, bands[1].high + shift_y, reader.width() - 1.0});
    if (!(from <= to)) continue;
    const int first_col = static_cast<int>(std::ceil(from)), last_col = static_cast<int>(to);
    const LightReader::Row light = reader.RowAt(y);
    PlaneWalk walk = WalkFrom(*local, start, first_col - place.pixel.x(), dy);
    std::size_t* const next_of_row = &next[static_cast<std::size_t>(2 * (y & 1))];
    const auto add = [&](int x) {
      std::size_t& at = next_of_row[x & 1];
      if (at >= end) return;
      plane_u[at] = walk.u;
      plane_v[at] = walk.v;
      lights[at] = light[x];
      at += stride;
    };
    if (thinning.interior == 1) {
      for (int x = first_col; x <= last_col; ++x, walk.Next()) add(x);
      continue;
    }
    for (int x = first_col; x <= last_col; ++x, walk.Next()) {
      const Eigen::Vector2d board = region.board_by_pixel * Eigen::Vector2d(x - place.pixel.x(), dy);
      if (thinning.Keeps(x, y, static_cast<float>(board.x()), static_cast<float>(board.y()))) add(x);
    }
  }
  for (int phase = 0; phase < 4; ++phase) {
    const int lane = Lane(corner) + phase;
    lanes_.count(lane) =
        static_cast<int>((next[static_cast<std::size_t>(phase)] - static_cast<std::size_t>(lane)) / stride);
  }
}

}  // namespace chequer
