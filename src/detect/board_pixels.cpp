#include "detect/board_pixels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// The most pixels of a lane: large cells are thinned out to that.
constexpr int kLaneCapacity = 400;
/// Lanes of as many pixels are thinned out inside the cells. Thinning cells from 18 px on saves little and costs 7 % of
/// the linear RMS.
constexpr double kThinnedFrom = 0.8 * kLaneCapacity;

/// How far outwards, in cells, the pixels of the board's rim are used: the rim itself is blurred with a background
/// that nothing is known of.
double OutwardReach(double px_per_cell, double blur_px) {
  return std::clamp(1 - (2.2 * blur_px + 0.5) / px_per_cell, 0.4, 0.9);
}

/// The plane coordinates of the pixels around one, from an origin, to second order.
struct LocalPlane {
  /// Of u and v: the value, the slopes by x and y, ½ d²/dx², d²/dxdy, ½ d²/dy².
  std::array<float, 2> at, by_x, by_y, by_xx, by_xy, by_yy;
};

/// Nothing where the lens has no inverse. @param plane of the pixel. @param pixel_by_plane derivative there.
std::optional<LocalPlane> PlaneAround(const Lens& lens, const Eigen::Vector2d& plane,
                                      const Eigen::Matrix2d& pixel_by_plane, const Eigen::Vector2d& origin) {
  LocalPlane local{};
  const auto set = [](std::array<float, 2>& to, const Eigen::Vector2d& value) {
    to = {static_cast<float>(value.x()), static_cast<float>(value.y())};
  };
  set(local.at, plane - origin);
  if (!lens.calibrated()) {
    local.by_x = {1, 0};
    local.by_y = {0, 1};
    return local;
  }
  if (!(pixel_by_plane.determinant() > 1e-6)) return std::nullopt;
  const Eigen::Matrix2d by_pixel = pixel_by_plane.inverse();
  // Change of the inverse Jacobian over a step of h pixels along x and along y.
  constexpr double h = 2;
  Eigen::Matrix2d at_x, at_y;
  lens.ToImage(plane + h * by_pixel.col(0), &at_x);
  lens.ToImage(plane + h * by_pixel.col(1), &at_y);
  const Eigen::Matrix2d by_x = (at_x.inverse() - by_pixel) / h, by_y = (at_y.inverse() - by_pixel) / h;
  set(local.by_x, by_pixel.col(0));
  set(local.by_y, by_pixel.col(1));
  set(local.by_xx, 0.5 * by_x.col(0));
  set(local.by_xy, by_x.col(1));
  set(local.by_yy, 0.5 * by_y.col(1));
  return local;
}

/// The plane coordinates of the pixels of a row: parabolas, by differences.
struct PlaneWalk {
  /// From the pixel that lies (dx, dy) from the local plane's.
  PlaneWalk(const LocalPlane& local, float dx, float dy) {
    for (std::size_t i = 0; i < 2; ++i) {
      const float slope = local.by_x[i] + dy * local.by_xy[i], bend = local.by_xx[i];
      at[i] = local.at[i] + dy * (local.by_y[i] + dy * local.by_yy[i]) + dx * (slope + dx * bend);
      step[i] = slope + (2 * dx + 1) * bend;
      change[i] = 2 * bend;
    }
  }
  void Next() {
    for (std::size_t i = 0; i < 2; ++i) {
      at[i] += step[i];
      step[i] += change[i];
    }
  }

  float at[2], step[2], change[2];
};

/// Pixels of a row.
struct Span {
  int y, first, pixels;
};

/// The next places of the lanes of a row's first pixel and second pixel, in turn.
struct Lanes {
  float *first, *second;
};

void Put(const PlaneWalk& walk, float light, float*& lane) {
  lane[0] = walk.at[0];
  lane[LaneBlock::kGroup] = walk.at[1];
  lane[2 * LaneBlock::kGroup] = light;
  lane += LaneBlock::kNextPixel;
}

/// Pixels of a row that are put in one go: as many as it takes for the processor to guess right how often to go round.
constexpr int kTogether = 4;

constexpr int WholeGoes(int count) { return (count + kTogether - 1) / kTogether * kTogether; }

/// Puts the next `count` pixels of a row, an even number, into their lanes. @tparam kMean is what run.is_mean() says.
template <bool kMean>
void PutPairs(const LightReader::Run& run, int count, PlaneWalk walk, Lanes lanes) {
  const std::uint8_t *first = run.first, *second = run.second;
  const float* const table = run.table;
  for (; count > 0; count -= 2, first += run.step, second += run.step) {
    Put(walk, kMean ? run.Mean(first) : table[*first], lanes.first);
    walk.Next();
    Put(walk, kMean ? run.Mean(second) : table[*second], lanes.second);
    walk.Next();
  }
}

/// Puts the next `count` pixels of a row, and what comes after them up to whole goes, which is not counted and which
/// the next row overwrites: there must be room for it, and it must lie in the image.
template <bool kMean>
void PutWhole(const LightReader::Run& run, int count, PlaneWalk walk, Lanes lanes) {
  if (count <= kTogether) return PutPairs<kMean>(run, kTogether, walk, lanes);
  PutPairs<kMean>(run, WholeGoes(count), walk, lanes);
}

/// Those of them that keeps(index in the row) tells. Returns how many.
template <class Keeps>
std::array<int, 2> PutSome(const LightReader::Run& run, int count, const Keeps& keeps, PlaneWalk walk, Lanes lanes) {
  std::array<int, 2> put{};
  for (int i = 0; i < count; ++i, walk.Next()) {
    if (!keeps(i)) continue;
    const std::uint8_t* at = (i % 2 ? run.second : run.first) + i / 2 * run.step;
    Put(walk, run.is_mean() ? run.Mean(at) : run.table[*at], i % 2 ? lanes.second : lanes.first);
    ++put[static_cast<std::size_t>(i % 2)];
  }
  return put;
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
  /// Inside cells: pixels there tell the levels alone, which the others tell too.
  static constexpr int kLeastInside = 4;

  bool all = true;                            ///< nothing is left out
  int near_edges = 1, inside = kLeastInside;  ///< one tile in so many is kept
  float band_x = 0, band_y = 0;               ///< near an edge, cells

  bool KeepsRow(float from_y, float to_y) const {
    return near_edges == 1 && std::abs(from_y) <= band_y && std::abs(to_y) <= band_y;
  }
  bool Keeps(int x, int y, float board_x, float board_y) const {
    const int tile = x / 2 + (y / 2) * 3;
    if (std::abs(board_x) <= band_x || std::abs(board_y) <= band_y) return near_edges == 1 || tile % near_edges == 0;
    // Nearly always, and a tenth of a division.
    return inside == kLeastInside ? tile % kLeastInside == 0 : tile % inside == 0;
  }
};

/// @pre x ≥ 0. The library's costs a call where the processor may be of any age.
int CeilOf(double x) {
  const int whole = static_cast<int>(x);
  return whole + (whole < x);
}

/// Parity of x + 2 · parity of y.
std::size_t PhaseOf(int x, int y) { return static_cast<std::size_t>((x & 1) + 2 * (y & 1)); }

Thinning ThinningOf(const Region& region, double px_x, double px_y, double blur_px) {
  Thinning thinning;
  const double width = region.right - region.left, height = region.bottom - region.top;
  if (px_x * px_y * width * height / 4 < kThinnedFrom) return thinning;
  thinning.all = false;
  const double band_px = std::max(0.5, 3.5 * blur_px);
  thinning.band_x = static_cast<float>(band_px / px_x);
  thinning.band_y = static_cast<float>(band_px / px_y);
  // Of each lane, so that both together fit.
  const double along = 2 * band_px * (px_y * height + px_x * width) / 4, all = px_x * px_y * width * height / 4;
  thinning.near_edges = std::max(1, static_cast<int>(std::ceil(along / (kLaneCapacity * 0.65))));
  thinning.inside =
      std::max(Thinning::kLeastInside * thinning.near_edges, static_cast<int>(std::ceil(all / (kLaneCapacity * 0.25))));
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
    const BoardGeometry::Local local = geometry.At(place.board);
    place.pixel = lens.ToImage(local.plane, &place.pixel_by_plane);
    place.pixel_by_board = place.pixel_by_plane * local.plane_by_board;
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
  const LightReader::Rows rows = reader.AllRows();
  int inside = 0;
  for (int corner = 0; corner < corners_; ++corner) {
    CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    place.inside = place.pixel.allFinite() && place.pixel_by_board.allFinite() && place.pixel.x() > 1 &&
                   place.pixel.y() > 1 && place.pixel.x() < reader.width() - 2 &&
                   place.pixel.y() < reader.height() - 2 && place.pixel_by_board.determinant() > 1;
    if (!place.inside) continue;
    ++inside;
    CollectCorner(reader, rows, lens, geometry, corner, blur_px);
  }
  return inside;
}

void BoardPixels::CollectCorner(const LightReader& reader, const LightReader::Rows& rows, const Lens& lens,
                                const BoardGeometry& geometry, int corner, double blur_px) {
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
  const std::optional<LocalPlane> local =
      PlaneAround(lens, geometry.ToPlane(place.board), place.pixel_by_plane, origin_);
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
  float* const pixels = lanes_.u_data() + lanes_.Place(Lane(corner), 0);
  std::array<int, 4> count{};  // by phase
  const std::array<Band, 2> bands = region.Bands();
  const double right_edge = reader.width() - 1.0;
  const auto take_row = [&](const Span& span) {
    const double first_dx = span.first - place.pixel.x(), dy = span.y - place.pixel.y();
    const PlaneWalk walk(*local, static_cast<float>(first_dx), static_cast<float>(dy));
    // Of the row's first and second pixel, in turn.
    int &first_taken = count[PhaseOf(span.first, span.y)], &second_taken = count[PhaseOf(span.first + 1, span.y)];
    const Lanes lanes{pixels + PhaseOf(span.first, span.y) + first_taken * LaneBlock::kNextPixel,
                      pixels + PhaseOf(span.first + 1, span.y) + second_taken * LaneBlock::kNextPixel};
    const LightReader::Run run = rows.From(span.first, span.y);
    const int room = 2 * (lanes_.capacity() - std::max(first_taken, second_taken));
    if (!thinning.all) {
      const Eigen::Vector2f at = (region.board_by_pixel * Eigen::Vector2d(first_dx, dy)).cast<float>(),
                            step = region.board_by_pixel.col(0).cast<float>();
      if (!thinning.KeepsRow(at.y(), at.y() + static_cast<float>(span.pixels - 1) * step.y())) {
        const auto keeps = [&](int i) {
          const Eigen::Vector2f there = at + static_cast<float>(i) * step;
          return thinning.Keeps(span.first + i, span.y, there.x(), there.y());
        };
        const auto [in_first, in_second] = PutSome(run, std::min(span.pixels, room), keeps, walk, lanes);
        first_taken += in_first;
        second_taken += in_second;
        return;
      }
    }
    const int whole = WholeGoes(span.pixels);
    if (whole > room || span.first + whole > reader.width()) {
      const auto [in_first, in_second] = PutSome(
          run, std::min(span.pixels, room), [](int) { return true; }, walk, lanes);
      first_taken += in_first;
      second_taken += in_second;
      return;
    }
    run.is_mean() ? PutWhole<true>(run, span.pixels, walk, lanes) : PutWhole<false>(run, span.pixels, walk, lanes);
    first_taken += (span.pixels + 1) / 2;
    second_taken += span.pixels / 2;
  };
  // All ends of some rows first: none waits for the pixels of another.
  std::array<Span, 32> spans;
  for (int y = first_row; y <= last_row;) {
    std::size_t filled = 0;
    for (; filled < spans.size() && y <= last_row; ++y) {
      const double dy = y - place.pixel.y();
      const double shift_x = place.pixel.x() + dy * bands[0].slope, shift_y = place.pixel.x() + dy * bands[1].slope;
      const double from = std::max(std::max(bands[0].low + shift_x, bands[1].low + shift_y), 0.0);
      const double to =
          std::max(std::min(std::min(bands[0].high + shift_x, bands[1].high + shift_y), right_edge), -1.0);
      const int first_col = CeilOf(std::min(from, right_edge + 1)), past = static_cast<int>(to + 1);
      spans[filled] = {y, first_col, past - first_col};
      filled += first_col < past;
    }
    for (std::size_t i = 0; i < filled; ++i) take_row(spans[i]);
  }
  for (int phase = 0; phase < 4; ++phase) lanes_.count(Lane(corner) + phase) = count[static_cast<std::size_t>(phase)];
}

}  // namespace chequer
