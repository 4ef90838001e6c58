#include "detect/fit/board_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "detect/fit/corner_pixels.h"

namespace chequer {
namespace {

/// Lanes with more of the pixels that do are thinned out inside the cells. Thinning cells from 18 px on in the plain
/// fit saves little and costs 7 % of the linear RMS.
constexpr double kThinnedFrom = 0.8;
/// Of a lane, so much may be near edges, and inside cells: pixels there tell the levels alone, which the others tell
/// too. That is why they are thinned out by as much more, at least (guesses).
constexpr double kNearEdges = 0.65, kInside = 0.25, kInsideOfNear = 0.25;
/// Light of a saturated pixel: code 254 and up.
constexpr float kSaturation = 253.5f / 255;
/// Pixels do for a fit by some of them where corners lie no farther from where they were collected, px or cells, and
/// the blur is the same within this factor: those that finish a fit are chosen more closely (BoardFit).
constexpr double kAlikePx = 0.3, kAlikeCells = 0.03, kAlikeBlur = 1.2;
/// Steps from a pixel to the point of the paper that it shows: within half a cell of a corner, each leaves a twentieth
/// of what was left.
constexpr int kStepsToPaper = 3;

/// How far outwards, in cells, the pixels of the board's rim are used: the rim itself is blurred with a background
/// that nothing is known of.
double OutwardReach(double px_per_cell, double blur_px) {
  return std::clamp(1 - (2.2 * blur_px + 0.5) / px_per_cell, 0.4, 0.9);
}

/// Around that reach, the weight of pixels falls from all to none, from so many pixels before it to so many beyond. Of
/// pixels that are in or out, a board that begins a tenth of a pixel elsewhere has others, and ends 0.17 standard
/// deviations elsewhere.
constexpr double kFadeBeforePx = 0.3, kFadeBeyondPx = 0.5;
/// All of that from the second size of cells on, nothing at the first and below: there a board's start may be so far
/// off that pixels beyond the reach lead it astray.
constexpr double kHardCellPx = 4, kSoftCellPx = 8;

/// Which pixels are a corner's, along one axis of the board, cells from it.
struct Window {
  double low = -0.5, high = 0.5, middle = 0;
  WindowEnds ends;
};

/// @param at_start, at_end whether the corner lies at the board's rim. @param px of a cell.
Window WindowOf(bool at_start, bool at_end, double px, double blur_px) {
  Window window;
  if (!at_start && !at_end) return window;
  const double reach = OutwardReach(px, blur_px);
  if (at_start) window.low = -reach;
  if (at_end) window.high = reach;
  window.middle = (window.low + window.high) / 2;
  if (at_start == at_end || px <= kHardCellPx) return window;
  const double share = BoardPixels::RimSoftness(px), beyond_px = share * kFadeBeyondPx,
               fade_px = beyond_px + share * kFadeBeforePx;
  window.ends.slope = px / fade_px;
  (at_start ? window.ends.low : window.ends.high) = (at_start ? -1 : 1) * (reach + beyond_px / px);
  (at_start ? window.low : window.high) += (at_start ? -1 : 1) * beyond_px / px;
  return window;
}

/// How the derivative of the plane by the pixel changes, by a pixel along x and along y.
struct Bend {
  Eigen::Matrix2d by_x = Eigen::Matrix2d::Zero(), by_y = Eigen::Matrix2d::Zero();
};

/// By differences over a step along x and along y. Not finite where the lens has no inverse.
Bend BendAround(const Lens& lens, const Eigen::Vector2d& plane, const Eigen::Matrix2d& plane_by_pixel) {
  constexpr double kStep = 2;
  Eigen::Matrix2d at_x, at_y;
  lens.ToImage(plane + kStep * plane_by_pixel.col(0), &at_x);
  lens.ToImage(plane + kStep * plane_by_pixel.col(1), &at_y);
  return {(at_x.inverse() - plane_by_pixel) / kStep, (at_y.inverse() - plane_by_pixel) / kStep};
}

LocalPlane PlaneAround(const Eigen::Vector2d& from_origin, const Eigen::Matrix2d& plane_by_pixel, const Bend& bend) {
  const auto values = [](const Eigen::Vector2d& value) {
    return std::array<float, 2>{static_cast<float>(value.x()), static_cast<float>(value.y())};
  };
  return {.at = values(from_origin),
          .by_x = values(plane_by_pixel.col(0)),
          .by_y = values(plane_by_pixel.col(1)),
          .by_xx = values(0.5 * bend.by_x.col(0)),
          .by_xy = values(bend.by_x.col(1)),
          .by_yy = values(0.5 * bend.by_y.col(1))};
}

/// The slope of a value along a line of `count` ≥ 3 points at the point `at`, by the values there and at the points
/// beside it: exact for parabolas, at the line's ends too. @param step from a point's value to the next.
Eigen::Matrix2d SlopeAt(const CornerPlace* place, int at, int count, int step) {
  const auto value = [&](int steps) -> const Eigen::Matrix2d& { return place[steps * step].plane_by_pixel; };
  if (at == 0) return 2 * value(1) - 1.5 * value(0) - 0.5 * value(2);
  if (at == count - 1) return 1.5 * value(0) - 2 * value(-1) + 0.5 * value(-2);
  return 0.5 * (value(1) - value(-1));
}

/// How the plane bends around a corner, one of a board's of that size. Nothing where the lens does not tell.
/// @param neighbours_tell whether the corners beside it all have places.
std::optional<Bend> BendOf(const Lens& lens, MarkerSize size, const CornerPlace* place, int corner,
                           bool neighbours_tell) {
  if (!lens.calibrated()) return Bend{};
  if (!neighbours_tell) {
    const Bend bend = BendAround(lens, place->plane, place->plane_by_pixel);
    if (!bend.by_x.allFinite() || !bend.by_y.allFinite()) return std::nullopt;
    return bend;
  }
  const int row = corner / (size.cols - 1), col = corner % (size.cols - 1);
  const Eigen::Matrix2d by_col = SlopeAt(place, col, size.cols - 1, 1),
                        by_row = SlopeAt(place, row, size.rows - 1, size.cols - 1);
  const Eigen::Matrix2d& board_by_pixel = place->board_by_pixel;
  return Bend{by_col * board_by_pixel(0, 0) + by_row * board_by_pixel(1, 0),
              by_col * board_by_pixel(0, 1) + by_row * board_by_pixel(1, 1)};
}

/// The part of the board around a corner, in cells from it, and how it lies in the image.
struct Region {
  double left, right, top, bottom;
  Eigen::Matrix2d board_by_pixel = Eigen::Matrix2d::Zero();

  std::array<Band, 2> Bands() const {
    return {BandOf(board_by_pixel.row(0), left, right), BandOf(board_by_pixel.row(1), top, bottom)};
  }

 private:
  static Band BandOf(const Eigen::RowVector2d& by_pixel, double low, double high) {
    // Rows that run along the band: nearly so will do, as no board is 1e6 px wide.
    const double across = std::abs(by_pixel[0]) < 1e-6 ? std::copysign(1e-6, by_pixel[0]) : by_pixel[0];
    const double a = low / across, b = high / across;
    return {static_cast<float>(std::min(a, b)), static_cast<float>(std::max(a, b)),
            static_cast<float>(-by_pixel[1] / across)};
  }
};

Thinning ThinningOf(const Region& region, double px_x, double px_y, double blur_px, int of_lane) {
  Thinning thinning;
  const double width = region.right - region.left, height = region.bottom - region.top;
  if (px_x * px_y * width * height / 4 < kThinnedFrom * of_lane) return thinning;
  thinning.all = false;
  const double band_px = std::max(0.5, 3.5 * blur_px);
  thinning.band_x = static_cast<float>(band_px / px_x);
  thinning.band_y = static_cast<float>(band_px / px_y);
  const double all = px_x * px_y * width * height / 4,
               along = std::min(all, 2 * band_px * (px_y * height + px_x * width) / 4);
  const double near_edges = std::min(1.0, kNearEdges * of_lane / along);
  thinning.near_edges = Thinning::ShareOf(near_edges);
  thinning.inside = Thinning::ShareOf(std::min(kInsideOfNear * near_edges, kInside * of_lane / all));
  return thinning;
}

}  // namespace

double BoardPixels::RimSoftness(double cell_px) {
  return std::clamp((cell_px - kHardCellPx) / (kSoftCellPx - kHardCellPx), 0.0, 1.0);
}

void BoardPixels::RankCorners() {
  // Lanes that are evaluated together should have as many pixels: corners of the rim have more. Those left over that do
  // not fill a vector should have few.
  int next = 0;
  const auto is_spread = [](int at, int last) { return at % 2 == 0 || at == last; };
  for (const bool spread : {true, false}) {
    for (int rims = 4; rims >= 0; --rims)
      for (int corner = 0; corner < corners_; ++corner) {
        const int row = corner / (size_.cols - 1), col = corner % (size_.cols - 1), last_row = size_.rows - 2,
                  last_col = size_.cols - 2;
        const int at = (row == 0) + (row == last_row) + (col == 0) + (col == last_col);
        if (at == rims && (is_spread(row, last_row) && is_spread(col, last_col)) == spread)
          rank_[static_cast<std::size_t>(corner)] = next++;
      }
    if (spread) spread_ = next;
  }
}

BoardGeometry::Local BoardPixels::SeenAt(const BoardGeometry& geometry, const Eigen::Vector2d& board) const {
  BoardGeometry::Local local = geometry.At(board);
  if (const std::optional<BentPaper>& paper = collected_.paper) {
    local.plane += paper->Seen(board) - paper->middle().ToPlane(board);
    local.plane_by_board = paper->SeenByBoard(board);
  }
  return local;
}

void BoardPixels::PlaceCorners(const Lens& lens, const BoardGeometry& geometry) {
  Place(lens, geometry);
  MoveFours();
}

template <class Act>
void BoardPixels::ForFours(Act&& act) {
  for (int corner = 0; corner < corners_; ++corner) {
    const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    if (!place.inside) continue;
    const int rank = rank_[static_cast<std::size_t>(corner)];
    act(corner, place, fours_[static_cast<std::size_t>(rank / 4)],
        [rank](CornerFour::Values& values, double value) { values[rank % 4] = static_cast<float>(value); });
  }
}

void BoardPixels::FillFours() {
  std::fill_n(fours_.begin(), fours().size(), CornerFour{});
  ForFours([&](int corner, const CornerPlace& place, CornerFour& four, const auto& set) {
    four.corner[static_cast<std::size_t>(rank_[static_cast<std::size_t>(corner)] % 4)] = corner;
    set(four.board_x, place.board.x()), set(four.board_y, place.board.y());
  });
  MoveFours();
}

void BoardPixels::MoveFours() {
  ForFours([&](int, const CornerPlace& place, CornerFour& four, const auto& set) {
    const Eigen::Vector2d off = place.pixel - middle().pixel;
    set(four.off_x, off.x()), set(four.off_y, off.y());
    set(four.x_by_x, place.board_by_pixel(0, 0)), set(four.x_by_y, place.board_by_pixel(0, 1));
    set(four.y_by_x, place.board_by_pixel(1, 0)), set(four.y_by_y, place.board_by_pixel(1, 1));
  });
}

void BoardPixels::Place(const Lens& lens, const BoardGeometry& geometry) {
  for (int corner = 0; corner < corners_; ++corner) {
    CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    const BoardGeometry::Local local = SeenAt(geometry, place.board);
    Eigen::Matrix2d pixel_by_plane;
    place.plane = local.plane;
    place.pixel = lens.ToImage(local.plane, &pixel_by_plane);
    place.plane_by_pixel = pixel_by_plane.inverse();
    place.pixel_by_board = pixel_by_plane * local.plane_by_board;
    place.board_by_pixel = place.pixel_by_board.inverse();
  }
}

void BoardPixels::TakeOutBend() {
  const BentPaper& paper = *collected_.paper;
  for (int corner = 0; corner < corners_; ++corner) {
    if (!inside(corner)) continue;
    const Eigen::Vector2d printed = Printed(corner);
    const Eigen::Matrix2d board_by_plane = paper.SeenByBoard(printed).inverse();
    for (int lane = Lane(corner); lane < Lane(corner) + 4; ++lane)
      for (int i = 0; i < lanes_.count(lane); ++i) {
        const std::size_t at = lanes_.Place(lane, i);
        float &u = lanes_.u_data()[at], &v = lanes_.v_data()[at];
        const Eigen::Vector2d seen = origin_ + Eigen::Vector2d(u, v);
        Eigen::Vector2d board = printed;
        for (int step = 0; step < kStepsToPaper; ++step) board += board_by_plane * (seen - paper.Seen(board));
        const Eigen::Vector2d flat = paper.middle().ToPlane(board) - origin_;
        u = static_cast<float>(flat.x());
        v = static_cast<float>(flat.y());
      }
  }
}

Eigen::Matrix3d BoardPixels::BoardFromPlane(const BoardGeometry& geometry) const {
  Eigen::Matrix3d plane_from_lanes = Eigen::Matrix3d::Identity();
  plane_from_lanes.topLeftCorner<2, 2>() = by_lane_;
  plane_from_lanes.topRightCorner<2, 1>() = origin_;
  const Eigen::Matrix3d board_from_plane = geometry.plane_from_board().inverse() * plane_from_lanes;
  return board_from_plane / board_from_plane(2, 2);
}

int BoardPixels::Collect(const LightReader& reader, const Lens& lens, MarkerSize size, const BoardGeometry& geometry,
                         double blur_px, int of_lane, const std::optional<BentPaper>& paper) {
  if (corners_ == 0 || !(size == size_)) {
    size_ = size;
    corners_ = CornerCount(size);
    RankCorners();
  }
  for (int corner = 0; corner < corners_; ++corner) places_[static_cast<std::size_t>(corner)].board = Printed(corner);
  origin_ = geometry.ToPlane({0, 0});
  by_lane_.setIdentity();
  collected_ = {geometry, blur_px, of_lane, 0, 0, origin_, false, paper};
  Place(lens, geometry);
  lanes_.Reset(4 * corners_, kLaneCapacity);
  if (!origin_.allFinite()) return 0;
  LightReader::Rows rows = reader.AllRows();
  std::array<float, 256> light_of_code;
  if (!rows.are_mixed()) rows.Negate(kSaturation, light_of_code);
  collected_.inside = FindInside(reader);
  // Of a corner outside the image, the lens's model may say anything.
  const bool neighbours_tell = collected_.inside == corners_ && size.rows > 3 && size.cols > 3;
  for (int corner = 0; corner < corners_; ++corner) {
    const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    if (!place.inside) continue;
    const std::optional<Bend> bend = BendOf(lens, size, &place, corner, neighbours_tell);
    if (bend) CollectCorner(reader, rows, corner, PlaneAround(place.plane - origin_, place.plane_by_pixel, *bend));
    collected_.pixels += place.pixels;
  }
  FillFours();
  lanes_.Fold();
  // What is mixed of two codes, the codes' table does not mark.
  if (rows.are_mixed()) MarkSaturated(kSaturation, lanes_);
  if (paper) TakeOutBend();
  return collected_.inside;
}

int BoardPixels::FindInside(const LightReader& reader) {
  // Comparisons that no value passes which is not finite, nor a matrix with one.
  const auto turns_right = [](const Eigen::Matrix2d& matrix, double least) {
    const double determinant = matrix.determinant();
    return determinant > least && determinant < std::numeric_limits<double>::infinity();
  };
  int inside = 0;
  for (CornerPlace& place : std::span(places_).first(static_cast<std::size_t>(corners_))) {
    const Eigen::Vector2d& pixel = place.pixel;
    place.inside = pixel.x() > 1 && pixel.y() > 1 && pixel.x() < reader.width() - 2 &&
                   pixel.y() < reader.height() - 2 && turns_right(place.pixel_by_board, 1) &&
                   turns_right(place.plane_by_pixel, 0);
    place.pixels = 0;
    inside += place.inside;
  }
  return inside;
}

bool BoardPixels::HoldFor(const Lens& lens, const BoardGeometry& geometry, double blur_px, int of_lane) const {
  const double blurs = blur_px / collected_.blur_px;
  if (collected_.paper) return false;
  if (of_lane != collected_.of_lane || !(blurs < kAlikeBlur && blurs * kAlikeBlur > 1)) return false;
  for (int corner = 0; corner < corners_; ++corner) {
    const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    if (!place.inside) continue;
    const Eigen::Vector2d there = lens.ToImage(collected_.geometry.ToPlane(place.board)),
                          here = lens.ToImage(geometry.ToPlane(place.board));
    if (!((here - there).norm() < std::max(kAlikePx, kAlikeCells * place.CellPx()))) return false;
  }
  return true;
}

void BoardPixels::PrepareChange() {
  if (collected_.originals_kept) return;
  lanes_.KeepOriginals();
  collected_.originals_kept = true;
}

int BoardPixels::Reuse(const Lens& lens, const BoardGeometry& geometry) {
  if (collected_.originals_kept) lanes_.RestoreOriginals();
  origin_ = collected_.origin;
  by_lane_.setIdentity();
  PlaceCorners(lens, geometry);
  return collected_.inside;
}

void BoardPixels::CollectCorner(const LightReader& reader, const LightReader::Rows& rows, int corner,
                                const LocalPlane& plane) {
  CornerPlace& place = places_[static_cast<std::size_t>(corner)];
  const int corner_row = corner / (size_.cols - 1), corner_col = corner % (size_.cols - 1);
  const double blur_px = collected_.blur_px;
  Region region;
  region.board_by_pixel = place.board_by_pixel;
  const double px_x = 1 / region.board_by_pixel.row(0).norm(), px_y = 1 / region.board_by_pixel.row(1).norm();
  const Window across = WindowOf(corner_col == 0, corner_col == size_.cols - 2, px_x, blur_px),
               down = WindowOf(corner_row == 0, corner_row == size_.rows - 2, px_y, blur_px);
  region.left = across.low, region.right = across.high;
  region.top = down.low, region.bottom = down.high;
  place.middle = {across.middle, down.middle};
  place.ends = {across.ends, down.ends};

  // Of the region's corners, how far down the middle lies and the lowest lies below it.
  const double by_x = place.pixel_by_board(1, 0) / 2, by_y = place.pixel_by_board(1, 1) / 2;
  const double middle_y = place.pixel.y() + by_x * (region.left + region.right) + by_y * (region.top + region.bottom);
  const double half_y = std::abs(by_x) * (region.right - region.left) + std::abs(by_y) * (region.bottom - region.top);
  const int first_row = std::max(0, static_cast<int>(std::ceil(middle_y - half_y)));
  const int last_row = std::min(reader.height() - 1, static_cast<int>(std::floor(middle_y + half_y)));
  CornerPart part{.x = static_cast<int>(place.pixel.x()), .y = static_cast<int>(place.pixel.y())};
  part.corner_x = static_cast<float>(place.pixel.x() - part.x);
  part.corner_y = static_cast<float>(place.pixel.y() - part.y);
  part.first_row = first_row - part.y;
  part.rows = last_row + 1 - first_row;
  part.bands = region.Bands();
  part.plane = plane;
  part.thinning = ThinningOf(region, px_x, px_y, blur_px, collected_.of_lane);
  for (int axis = 0; axis < 2; ++axis) {
    part.board_by_x[static_cast<std::size_t>(axis)] = static_cast<float>(region.board_by_pixel(axis, 0));
    part.board_by_y[static_cast<std::size_t>(axis)] = static_cast<float>(region.board_by_pixel(axis, 1));
  }
  place.pixels = TakePixels(part, rows, reader.width(), Lane(corner), lanes_);
}

}  // namespace chequer
