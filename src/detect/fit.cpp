#include "detect/fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace chequer {
namespace {

/// The most pixels of a lane: large cells are thinned out to that.
constexpr int kLaneCapacity = 400;
constexpr int kMaxIterations = 8;
/// A step that moves no corner farther ends the fit: Gauss-Newton leaves a hundredth of it.
constexpr double kSettledPx = 0.02;
/// Standard deviations beyond which a pixel counts with less weight.
constexpr float kRobustLimit = 4;
/// Fewer corners do not determine a board with something to spare.
constexpr int kFewestCorners = 6;
/// Blur, pixels: half a pixel's own integration up to what still shows cells.
constexpr double kLeastBlur = 0.25, kMostBlur = 12;
/// A corner whose pixels disagree so much more than the median corner's is hidden.
constexpr double kHiddenRatio = 8;

/// How far outwards, in cells, the pixels of the board's rim are used: the rim itself is blurred with a background
/// that nothing is known of.
double OutwardReach(double px_per_cell, double blur_px) {
  return std::clamp(1 - (2.2 * blur_px + 0.5) / px_per_cell, 0.4, 0.9);
}

/// The first-order inverse of a lens around one pixel, with its curvature.
struct LocalLens {
  Eigen::Vector2d pixel, plane;
  Eigen::Matrix2d by_pixel;             ///< d plane / d pixel
  Eigen::Matrix2d by_xx_and_xy, by_yy;  ///< columns: ½ d²/dx², d²/dxdy; ½ d²/dy²  (by_yy uses its first column)
};

/// Plane coordinates, from an origin, of the pixels of one row as parabolas over the distance from the local lens's
/// pixel.
class RowOfPlane {
 public:
  RowOfPlane(const LocalLens& lens, const Eigen::Vector2d& origin, int y) {
    const double dy = y - lens.pixel.y();
    const Eigen::Vector2d at = lens.plane - origin + dy * lens.by_pixel.col(1) + dy * dy * lens.by_yy.col(0);
    const Eigen::Vector2d slope = lens.by_pixel.col(0) + dy * lens.by_xx_and_xy.col(1);
    const Eigen::Vector2d bend = lens.by_xx_and_xy.col(0);
    for (int i = 0; i < 2; ++i) {
      at_[i] = static_cast<float>(at[i]);
      slope_[i] = static_cast<float>(slope[i]);
      bend_[i] = static_cast<float>(bend[i]);
    }
  }
  float u(float dx) const { return at_[0] + dx * (slope_[0] + dx * bend_[0]); }
  float v(float dx) const { return at_[1] + dx * (slope_[1] + dx * bend_[1]); }

 private:
  float at_[2], slope_[2], bend_[2];
};

/// Nothing where the lens has no inverse.
std::optional<LocalLens> LensAround(const Lens& lens, const Eigen::Vector2d& plane) {
  LocalLens local;
  local.plane = plane;
  if (!lens.calibrated()) {
    local.pixel = plane;
    local.by_pixel.setIdentity();
    local.by_xx_and_xy.setZero();
    local.by_yy.setZero();
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
  local.by_xx_and_xy.col(0) = 0.5 * by_x.col(0);
  local.by_xx_and_xy.col(1) = by_x.col(1);
  local.by_yy.col(0) = 0.5 * by_y.col(1);
  local.by_yy.col(1).setZero();
  return local;
}

}  // namespace

bool PhotometricFit::Prepare(const LightReader& reader, const Lens& lens, const Start& start) {
  size_ = start.size;
  corners_ = CornerCount(size_);
  cells_ = size_.rows * size_.cols;
  channels_ = reader.channels();
  for (int phase = 0; phase < 4; ++phase)
    channel_of_phase_[static_cast<std::size_t>(phase)] = reader.ChannelOf(phase & 1, phase >> 1);
  blur_px_ = start.blur_px;
  hidden_.fill(false);
  result_.geometry = start.geometry;
  origin_ = start.geometry.ToPlane({0, 0});
  if (!origin_.allFinite()) return false;
  PlaceCorners(reader, lens);
  block_.Reset(4 * corners_, kLaneCapacity);
  int inside = 0;
  for (int corner = 0; corner < corners_; ++corner) {
    if (!places_[static_cast<std::size_t>(corner)].inside) continue;
    ++inside;
    CollectPixels(reader, lens, corner);
  }
  if (inside < kFewestCorners) return false;
  StartLevels();
  return true;
}

void PhotometricFit::PlaceCorners(const LightReader& reader, const Lens& lens) {
  local_by_geometry_.resize(static_cast<std::size_t>(corners_));
  for (int corner = 0; corner < corners_; ++corner) {
    CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    place.board = CornerOnBoard(size_, corner / (size_.cols - 1), corner % (size_.cols - 1));
    Eigen::Matrix2d pixel_by_plane;
    place.pixel = lens.ToImage(result_.geometry.ToPlane(place.board), &pixel_by_plane);
    place.pixel_by_board = pixel_by_plane * result_.geometry.PlaneByBoard(place.board);
    place.inside = place.pixel.allFinite() && place.pixel_by_board.allFinite() && place.pixel.x() > 1 &&
                   place.pixel.y() > 1 && place.pixel.x() < reader.width() - 2 &&
                   place.pixel.y() < reader.height() - 2 && place.pixel_by_board.determinant() > 1;
  }
}

void PhotometricFit::CollectPixels(const LightReader& reader, const Lens& lens, int corner) {
  const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
  const int row = corner / (size_.cols - 1), col = corner % (size_.cols - 1);
  const Eigen::Matrix2d board_by_pixel = place.pixel_by_board.inverse();
  const double px_x = 1 / board_by_pixel.row(0).norm(), px_y = 1 / board_by_pixel.row(1).norm();
  const std::optional<LocalLens> plane_at = LensAround(lens, result_.geometry.ToPlane(place.board));
  if (!plane_at) return;
  const double out_x = OutwardReach(px_x, blur_px_), out_y = OutwardReach(px_y, blur_px_);
  const double left = col == 0 ? -out_x : -0.5, right = col == size_.cols - 2 ? out_x : 0.5;
  const double top = row == 0 ? -out_y : -0.5, bottom = row == size_.rows - 2 ? out_y : 0.5;

  // Interior pixels of large cells say little; they are thinned out.
  const double band_x = std::max(0.5, 3.5 * blur_px_ / 1) / px_x, band_y = std::max(0.5, 3.5 * blur_px_) / px_y;
  const double pixels = px_x * px_y * (right - left) * (bottom - top);
  const int thinning = pixels / 4 < kLaneCapacity * 0.8 ? 1 : 4;
  const double along = 2 * (band_x * (bottom - top) + band_y * (right - left)) * px_x * px_y / 4;
  const int edge_thinning = std::max(1, static_cast<int>(std::ceil(along / (kLaneCapacity * 0.85))));

  const float pixel_x = static_cast<float>(place.pixel.x());
  const float x_by_dx = static_cast<float>(board_by_pixel(0, 0)), x_by_dy = static_cast<float>(board_by_pixel(0, 1));
  const float y_by_dx = static_cast<float>(board_by_pixel(1, 0)), y_by_dy = static_cast<float>(board_by_pixel(1, 1));
  double y_min = 1e9, y_max = -1e9;
  for (const double x : {left, right})
    for (const double y : {top, bottom}) {
      const double dy = place.pixel_by_board.row(1).dot(Eigen::Vector2d(x, y));
      y_min = std::min(y_min, dy);
      y_max = std::max(y_max, dy);
    }
  const int first_row = std::max(0, static_cast<int>(std::ceil(place.pixel.y() + y_min)));
  const int last_row = std::min(reader.height() - 1, static_cast<int>(std::floor(place.pixel.y() + y_max)));
  for (int y = first_row; y <= last_row; ++y) {
    const double dy = y - place.pixel.y();
    // The columns where both board coordinates stay within the corner's region.
    double from = -1e9, to = 1e9;
    const auto clip = [&](const Eigen::RowVector2d& by_pixel, double low, double high) {
      const double offset = by_pixel[1] * dy;
      if (std::abs(by_pixel[0]) < 1e-9) {
        if (offset < low || offset >= high) to = -1e9;
        return;
      }
      double a = (low - offset) / by_pixel[0], b = (high - offset) / by_pixel[0];
      if (a > b) std::swap(a, b);
      from = std::max(from, a);
      to = std::min(to, b);
    };
    clip(board_by_pixel.row(0), left, right);
    clip(board_by_pixel.row(1), top, bottom);
    const int first_col = std::max(0, static_cast<int>(std::ceil(std::max(from, -1e6) + place.pixel.x())));
    const int last_col =
        std::min(reader.width() - 1, static_cast<int>(std::floor(std::min(to, 1e6) + place.pixel.x())));
    const LightReader::Row light = reader.RowAt(y);
    const RowOfPlane plane(*plane_at, origin_, y);
    const int lane = Lane(2 * (y & 1), corner);
    for (int x = first_col; x <= last_col; ++x) {
      const float dx = static_cast<float>(x) - pixel_x;
      if (thinning > 1) {
        const bool interior = std::abs(x_by_dx * dx + x_by_dy * static_cast<float>(dy)) > static_cast<float>(band_x) &&
                              std::abs(y_by_dx * dx + y_by_dy * static_cast<float>(dy)) > static_cast<float>(band_y);
        const int step = interior ? thinning * edge_thinning : edge_thinning;
        // Whole 2 × 2 tiles are kept, so that all parities stay balanced.
        if (step > 1 && (x / 2 + (y / 2) * 3) % step != 0) continue;
      }
      block_.Add(lane + (x & 1) * corners_, plane.u(dx), plane.v(dx), light[x]);
    }
  }
}

void PhotometricFit::StartLevels() {
  // Means of the pixels at least a quarter cell from the edges, or of the four of a cell's corner that are farthest.
  const Eigen::Matrix3d to_origin = (Eigen::Matrix3d() << 1, 0, origin_.x(), 0, 1, origin_.y(), 0, 0, 1).finished();
  const Eigen::Matrix3d board_from_plane = (result_.geometry.plane_from_board()).inverse() * to_origin;
  std::array<std::vector<double>, 3> weight;
  for (int channel = 0; channel < channels_; ++channel) {
    levels_[static_cast<std::size_t>(channel)].assign(static_cast<std::size_t>(cells_), 0.0f);
    weight[static_cast<std::size_t>(channel)].assign(static_cast<std::size_t>(cells_), 0.0);
  }
  for (int phase = 0; phase < 4; ++phase) {
    const std::size_t channel = static_cast<std::size_t>(channel_of_phase_[static_cast<std::size_t>(phase)]);
    for (int corner = 0; corner < corners_; ++corner) {
      const Eigen::Vector2d& at = places_[static_cast<std::size_t>(corner)].board;
      const int row = corner / (size_.cols - 1), col = corner % (size_.cols - 1);
      const int lane = Lane(phase, corner);
      for (int i = 0; i < block_.count(lane); ++i) {
        const Eigen::Vector2d board =
            (board_from_plane * Eigen::Vector3d(block_.u(lane, i), block_.v(lane, i), 1)).hnormalized() - at;
        const double inner = std::min(std::abs(board.x()), std::abs(board.y()));
        const double w = inner * inner * inner + 1e-6;  // the farther from the edges, the better
        const std::size_t cell =
            static_cast<std::size_t>((row + (board.y() > 0 ? 1 : 0)) * size_.cols + col + (board.x() > 0 ? 1 : 0));
        levels_[channel][cell] += static_cast<float>(w * block_.light(lane, i));
        weight[channel][cell] += w;
      }
    }
  }
  float lightest = 0;
  for (int channel = 0; channel < channels_; ++channel)
    for (std::size_t cell = 0; cell < static_cast<std::size_t>(cells_); ++cell) {
      float& level = levels_[static_cast<std::size_t>(channel)][cell];
      const double w = weight[static_cast<std::size_t>(channel)][cell];
      level = w > 0 ? level / static_cast<float>(w) : 0.0f;
      lightest = std::max(lightest, level);
    }
  // Before anything is known of the noise: shot noise above a floor of read noise and rounding.
  for (std::size_t channel = 0; channel < 3; ++channel) {
    noise_floor_[channel] = std::max(2e-5f * lightest, 1e-7f);
    noise_slope_[channel] = 3e-4f;
  }
  input_.saturation = 253.5f / 255;
  input_.robust_limit = 1e9f;
}

void PhotometricFit::SetLanes() {
  const Eigen::Matrix3d to_origin = (Eigen::Matrix3d() << 1, 0, origin_.x(), 0, 1, origin_.y(), 0, 0, 1).finished();
  Eigen::Matrix3d board_from_plane = result_.geometry.plane_from_board().inverse() * to_origin;
  board_from_plane /= board_from_plane(2, 2);
  for (int i = 0; i < 9; ++i) input_.board_from_plane[i] = static_cast<float>(board_from_plane(i / 3, i % 3));
  input_.blur_px = static_cast<float>(blur_px_);
  for (int corner = 0; corner < corners_; ++corner) {
    const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    const Eigen::Matrix2d board_by_pixel =
        place.inside ? Eigen::Matrix2d(place.pixel_by_board.inverse()) : Eigen::Matrix2d::Identity();
    const double length_x = board_by_pixel.row(0).norm(), length_y = board_by_pixel.row(1).norm();
    const double correlation = board_by_pixel.row(0).dot(board_by_pixel.row(1)) / (length_x * length_y);
    const int cell = corner / (size_.cols - 1) * size_.cols + corner % (size_.cols - 1);
    for (int phase = 0; phase < 4; ++phase) {
      const int lane = Lane(phase, corner);
      const std::size_t channel = static_cast<std::size_t>(channel_of_phase_[static_cast<std::size_t>(phase)]);
      const float* level = &levels_[channel][static_cast<std::size_t>(cell)];
      block_.parameter(LaneBlock::kCornerX, lane) = static_cast<float>(place.board.x());
      block_.parameter(LaneBlock::kCornerY, lane) = static_cast<float>(place.board.y());
      block_.parameter(LaneBlock::kPxPerCellX, lane) = static_cast<float>(1 / length_x);
      block_.parameter(LaneBlock::kPxPerCellY, lane) = static_cast<float>(1 / length_y);
      block_.parameter(LaneBlock::kCorrelation, lane) = static_cast<float>(correlation);
      block_.parameter(LaneBlock::kL00, lane) = level[0];
      block_.parameter(LaneBlock::kL10, lane) = level[1];
      block_.parameter(LaneBlock::kL01, lane) = level[size_.cols];
      block_.parameter(LaneBlock::kL11, lane) = level[size_.cols + 1];
      block_.parameter(LaneBlock::kNoiseFloor, lane) = noise_floor_[channel];
      block_.parameter(LaneBlock::kNoiseSlope, lane) = noise_slope_[channel];
    }
  }
}

void PhotometricFit::AssembleGeometry() {
  // Moves of a board coordinate at a fixed pixel, by the geometry's parameters: −(d plane/d board)⁻¹ d plane/d
  // parameters.
  const BoardGeometry& geometry = result_.geometry;
  const auto move = [&](const Eigen::Vector2d& board) -> BoardGeometry::Derivative {
    return -(geometry.PlaneByBoard(board).inverse() * geometry.PlaneByParameters(board));
  };
  constexpr double h = 0.25;
  for (int corner = 0; corner < corners_; ++corner) {
    const Eigen::Vector2d& board = places_[static_cast<std::size_t>(corner)].board;
    auto& local = local_by_geometry_[static_cast<std::size_t>(corner)];
    const BoardGeometry::Derivative center = move(board);
    local.row(kShiftX) = center.row(0);
    local.row(kShiftXAlongY) = (move(board + Eigen::Vector2d(0, h)).row(0) - center.row(0)) / h;
    local.row(kShiftY) = center.row(1);
    local.row(kShiftYAlongX) = (move(board + Eigen::Vector2d(h, 0)).row(1) - center.row(1)) / h;
  }
}

void PhotometricFit::AddCorner(int corner) {
  // Place of (a, b) in the upper triangle by rows.
  static constexpr auto kIndex = [] {
    std::array<std::array<int, kLaneParameters>, kLaneParameters> index{};
    for (int a = 0, next = 0; a < kLaneParameters; ++a)
      for (int b = a; b < kLaneParameters; ++b, ++next)
        index[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)] =
            index[static_cast<std::size_t>(b)][static_cast<std::size_t>(a)] = next;
    return index;
  }();
  const auto& local = local_by_geometry_[static_cast<std::size_t>(corner)];
  const int cell = corner / (size_.cols - 1) * size_.cols + corner % (size_.cols - 1);
  const std::array<int, 4> cell_of{cell, cell + 1, cell + size_.cols, cell + size_.cols + 1};
  // Geometry and blur: all lanes of the corner together.
  Eigen::Matrix<double, 5, 5> shape = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> shape_gradient = Eigen::Matrix<double, 5, 1>::Zero();
  std::array<Eigen::Matrix<double, 4, 5, Eigen::RowMajor>, 3> cross;
  for (int channel = 0; channel < channels_; ++channel) cross[static_cast<std::size_t>(channel)].setZero();
  for (int phase = 0; phase < 4; ++phase) {
    const int lane = Lane(phase, corner);
    const std::size_t channel = static_cast<std::size_t>(channel_of_phase_[static_cast<std::size_t>(phase)]);
    BandedSystem& levels = level_systems_[channel];
    for (std::size_t a = 0; a < 5; ++a) {
      for (std::size_t b = a; b < 5; ++b)
        shape(static_cast<int>(a), static_cast<int>(b)) += block_.sum(kIndex[a][b], lane);
      shape_gradient[static_cast<int>(a)] += block_.sum(kGradient + static_cast<int>(a), lane);
      for (std::size_t b = 0; b < 4; ++b)
        cross[channel](static_cast<int>(b), static_cast<int>(a)) += block_.sum(kIndex[a][kLevel00 + b], lane);
    }
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b <= a; ++b)
        levels.At(cell_of[a], cell_of[b]) += block_.sum(kIndex[kLevel00 + a][kLevel00 + b], lane);
      levels.Rhs(cell_of[a])[kResidualColumn] += block_.sum(kGradient + int{kLevel00} + static_cast<int>(a), lane);
    }
  }
  shape.triangularView<Eigen::StrictlyLower>() = shape.transpose();
  constexpr int kGeometry = BoardGeometry::kMaxParameters;
  const Eigen::Matrix<double, 4, kGeometry> half = shape.topLeftCorner<4, 4>() * local;
  normal_.topLeftCorner<kGeometry, kGeometry>().noalias() += local.transpose() * half;
  normal_.block<1, kGeometry>(kBlurUnknown, 0).noalias() += shape.block<1, 4>(4, 0) * local;
  normal_(kBlurUnknown, kBlurUnknown) += shape(4, 4);
  gradient_.head<kGeometry>().noalias() += local.transpose() * shape_gradient.head<4>();
  gradient_[kBlurUnknown] += shape_gradient[4];
  for (int channel = 0; channel < channels_; ++channel) {
    const auto& by_local = cross[static_cast<std::size_t>(channel)];
    const Eigen::Matrix<double, 4, kGeometry, Eigen::RowMajor> by_geometry = by_local.leftCols<4>() * local;
    for (std::size_t a = 0; a < 4; ++a) {
      double* rhs = level_systems_[static_cast<std::size_t>(channel)].Rhs(cell_of[a]);
      for (int c = 0; c < kGeometry; ++c) rhs[c] += by_geometry(static_cast<int>(a), c);
      rhs[kBlurUnknown] += by_local(static_cast<int>(a), 4);
    }
  }
}

void PhotometricFit::AssembleNormal() {
  normal_.setZero();
  gradient_.setZero();
  for (int channel = 0; channel < channels_; ++channel)
    level_systems_[static_cast<std::size_t>(channel)].Reset(cells_, size_.cols + 1);
  for (int corner = 0; corner < corners_; ++corner)
    if (places_[static_cast<std::size_t>(corner)].inside && !hidden_[static_cast<std::size_t>(corner)])
      AddCorner(corner);
  for (int unused = result_.geometry.parameters(); unused < kBlurUnknown; ++unused) normal_(unused, unused) = 1;
}

void PhotometricFit::EliminateLevels() {
  // Schur complement, in the lower triangle.
  for (int channel = 0; channel < channels_; ++channel) {
    BandedSystem& levels = level_systems_[static_cast<std::size_t>(channel)];
    levels.Factor(1e-3);
    levels.SolveLower();
    for (int cell = 0; cell < cells_; ++cell) {
      const Eigen::Map<const Eigen::Matrix<double, kUnknowns, 1>> by_unknowns(levels.Rhs(cell));
      const double residual = levels.Rhs(cell)[kResidualColumn];
      normal_.noalias() -= by_unknowns * by_unknowns.transpose();
      gradient_.noalias() -= residual * by_unknowns;
    }
  }
}

void PhotometricFit::MoveLevels(const Eigen::Matrix<double, kUnknowns, 1>& step) {
  for (int channel = 0; channel < channels_; ++channel) {
    BandedSystem& levels = level_systems_[static_cast<std::size_t>(channel)];
    for (int cell = 0; cell < cells_; ++cell) {
      const Eigen::Map<const Eigen::Matrix<double, kUnknowns, 1>> by_unknowns(levels.Rhs(cell));
      levels.Rhs(cell)[kResidualColumn] -= by_unknowns.dot(step);
    }
    levels.SolveUpper(kResidualColumn);
    for (int cell = 0; cell < cells_; ++cell)
      levels_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(cell)] +=
          static_cast<float>(levels.Rhs(cell)[kResidualColumn]);
  }
}

bool PhotometricFit::Step(double* largest_move_px) {
  SetLanes();
  AccumulateLanes(input_, block_);
  AssembleGeometry();
  AssembleNormal();
  EliminateLevels();
  // Only the lower triangle is complete (the blur's column is not filled).
  const Eigen::LDLT<Eigen::Matrix<double, kUnknowns, kUnknowns>> solver(normal_);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return false;
  const Eigen::Matrix<double, kUnknowns, 1> step = solver.solve(gradient_);
  if (!step.allFinite()) return false;
  MoveLevels(step);
  result_.geometry.Add(step.head(result_.geometry.parameters()));
  const double blur = std::clamp(blur_px_ + step[kBlurUnknown], std::max(kLeastBlur, 0.6 * blur_px_),
                                 std::min(kMostBlur, 1.6 * blur_px_));
  *largest_move_px = std::abs(blur - blur_px_);
  blur_px_ = blur;
  for (int corner = 0; corner < corners_; ++corner) {
    const auto& local = local_by_geometry_[static_cast<std::size_t>(corner)];
    const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    if (!place.inside) continue;
    const auto geometry_step = step.head<BoardGeometry::kMaxParameters>();
    const Eigen::Vector2d board_move(local.row(kShiftX).dot(geometry_step), local.row(kShiftY).dot(geometry_step));
    *largest_move_px = std::max(*largest_move_px, (place.pixel_by_board * board_move).norm());
  }
  return true;
}

void PhotometricFit::EstimateNoise() {
  // Two points of the line variance = floor + slope · light, one from the dark pixels, one from the light ones.
  double all_square = 0, all_count = 0;
  std::array<double, 3> dark_square{}, dark_light{}, dark_count{}, light_square{}, light_light{}, light_count{};
  for (int phase = 0; phase < 4; ++phase) {
    const std::size_t channel = static_cast<std::size_t>(channel_of_phase_[static_cast<std::size_t>(phase)]);
    for (int corner = 0; corner < corners_; ++corner) {
      if (hidden_[static_cast<std::size_t>(corner)] || !places_[static_cast<std::size_t>(corner)].inside) continue;
      const int lane = Lane(phase, corner);
      dark_square[channel] += block_.sum(kDarkSquare, lane);
      dark_light[channel] += block_.sum(kDarkLight, lane);
      dark_count[channel] += block_.sum(kDarkCount, lane);
      light_square[channel] += block_.sum(kLightSquare, lane);
      light_light[channel] += block_.sum(kLightLight, lane);
      light_count[channel] += block_.sum(kLightCount, lane);
    }
  }
  for (std::size_t c = 0; c < static_cast<std::size_t>(channels_); ++c) {
    all_square += dark_square[c] + light_square[c];
    all_count += dark_count[c] + light_count[c];
    if (dark_count[c] < 20 || light_count[c] < 20) continue;
    // Cells' levels and the geometry were fitted to the same pixels.
    const double n = dark_count[c] + light_count[c];
    const double freedom = n / std::max(n - cells_ - 3.0, 0.3 * n);
    const double dark_variance = std::max(freedom * dark_square[c] / dark_count[c], 1e-9);
    const double light_variance = std::max(freedom * light_square[c] / light_count[c], 1e-9);
    const double x0 = dark_light[c] / dark_count[c], x1 = light_light[c] / light_count[c];
    double slope = std::clamp((light_variance - dark_variance) / std::max(x1 - x0, 1e-6), 0.0,
                              light_variance / std::max(x1, 1e-6));
    const double floor = std::max(dark_variance - slope * x0, 0.02 * dark_variance);
    noise_floor_[c] = static_cast<float>(floor);
    noise_slope_[c] = static_cast<float>(slope);
  }
  input_.robust_limit = kRobustLimit;
}

void PhotometricFit::DropHiddenCorners() {
  std::array<double, kMaxCorners> misfit{};
  std::vector<double> sorted;
  sorted.reserve(static_cast<std::size_t>(corners_));
  for (int corner = 0; corner < corners_; ++corner) {
    if (!places_[static_cast<std::size_t>(corner)].inside) continue;
    double square = 0, count = 0;
    for (int phase = 0; phase < 4; ++phase) {
      square += block_.sum(kChiSquare, Lane(phase, corner));
      count += block_.count(Lane(phase, corner));
    }
    misfit[static_cast<std::size_t>(corner)] = count > 0 ? square / count : 1e9;
    sorted.push_back(misfit[static_cast<std::size_t>(corner)]);
  }
  if (sorted.empty()) return;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (int corner = 0; corner < corners_; ++corner)
    hidden_[static_cast<std::size_t>(corner)] = misfit[static_cast<std::size_t>(corner)] > kHiddenRatio * *middle;
}

void PhotometricFit::EvenOutShading(const Start& start) {
  if (start.saturated.empty()) return;
  // Least squares of log level = ink + gx x + gy y over the light cells, an ink a channel and saturation.
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (int channel = 0; channel < channels_; ++channel)
    for (const bool saturated : {false, true}) {
      // Blue hardly comes back from yellow.
      if (channel == 2 && saturated) continue;
      double n = 0, value_mean = 0;
      Eigen::Vector2d mean = Eigen::Vector2d::Zero();
      const auto each = [&](auto&& visit) {
        for (int cell = 0; cell < cells_; ++cell) {
          const int row = cell / size_.cols, col = cell % size_.cols;
          const float level = levels_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(cell)];
          if (IsDark(row, col) || start.saturated[static_cast<std::size_t>(cell)] != saturated || level < 1e-4f)
            continue;
          if (level > 0.97f) continue;  // saturated: says nothing
          visit(Eigen::Vector2d(col + 0.5 - 0.5 * size_.cols, row + 0.5 - 0.5 * size_.rows),
                std::log(static_cast<double>(level)));
        }
      };
      each([&](const Eigen::Vector2d& at, double value) { n += 1, value_mean += value, mean += at; });
      if (n < 4) continue;
      value_mean /= n;
      mean /= n;
      each([&](const Eigen::Vector2d& at, double value) {
        const Eigen::Vector2d d = at - mean;
        normal += d * d.transpose();
        right += d * (value - value_mean);
      });
    }
  if (!(normal.determinant() > 1)) return;
  const Eigen::Vector2d per_cell = normal.ldlt().solve(right);
  if (!per_cell.allFinite() || per_cell.norm() > 0.2) return;
  // The same gradient over plane coordinates, taken out of every pixel; levels then are those at the board's centre.
  const Eigen::Vector2d per_px = result_.geometry.PlaneByBoard({0, 0}).inverse().transpose() * per_cell;
  const float by_u = static_cast<float>(per_px.x()), by_v = static_cast<float>(per_px.y());
  for (int lane = 0; lane < block_.lanes(); ++lane)
    for (int i = 0; i < block_.count(lane); ++i) {
      float& light = block_.light(lane, i);
      if (light >= input_.saturation) continue;
      // e^−s by its Padé approximant: to 1e-5 for the gradients that pass above, at a tenth of the cost.
      const float s = by_u * block_.u(lane, i) + by_v * block_.v(lane, i), even = 1 + s * s / 12;
      light *= (even - s / 2) / (even + s / 2);
    }
  for (int channel = 0; channel < channels_; ++channel)
    for (int cell = 0; cell < cells_; ++cell) {
      const Eigen::Vector2d at(cell % size_.cols + 0.5 - 0.5 * size_.cols, cell / size_.cols + 0.5 - 0.5 * size_.rows);
      levels_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(cell)] *=
          static_cast<float>(std::exp(-per_cell.dot(at)));
    }
}

void PhotometricFit::Finish() {
  const int p = result_.geometry.parameters();
  double chi_square = 0, weight = 0, shift_square = 0, variance_px = 0;
  double dark_square = 0, dark_count = 0, light_square = 0, light_count = 0;
  result_.corners_used = 0;
  result_.corner_used.fill(false);
  double contrast = 0;
  for (int corner = 0; corner < corners_; ++corner) {
    const CornerPlace& place = places_[static_cast<std::size_t>(corner)];
    if (!place.inside || hidden_[static_cast<std::size_t>(corner)]) continue;
    Eigen::Matrix2d local = Eigen::Matrix2d::Zero();
    Eigen::Vector2d local_gradient = Eigen::Vector2d::Zero();
    for (int phase = 0; phase < 4; ++phase) {
      const int lane = Lane(phase, corner);
      chi_square += block_.sum(kChiSquare, lane);
      weight += block_.sum(kWeight, lane);
      dark_square += block_.sum(kDarkSquare, lane);
      dark_count += block_.sum(kDarkCount, lane);
      light_square += block_.sum(kLightSquare, lane);
      light_count += block_.sum(kLightCount, lane);
      local(0, 0) += block_.sum(0, lane);
      local(0, 1) += block_.sum(2, lane);
      local(1, 1) += block_.sum(17, lane);
      local_gradient[0] += block_.sum(kGradient + int{kShiftX}, lane);
      local_gradient[1] += block_.sum(kGradient + int{kShiftY}, lane);
    }
    local(1, 0) = local(0, 1);
    if (!(local.determinant() > 0)) continue;
    result_.corner_used[static_cast<std::size_t>(corner)] = true;
    ++result_.corners_used;
    const Eigen::Matrix2d local_covariance = local.inverse();
    shift_square += (place.pixel_by_board * local_covariance * local_gradient).squaredNorm();
    variance_px += (place.pixel_by_board * local_covariance * place.pixel_by_board.transpose()).trace() / 2;
    contrast += std::abs(block_.parameter(LaneBlock::kL00, Lane(1, corner)) -
                         block_.parameter(LaneBlock::kL10, Lane(1, corner)));
  }
  const double unknowns = p + 1 + channels_ * cells_;
  const double per_pixel = chi_square / std::max(weight - unknowns, 1.0);
  const double n = std::max(result_.corners_used, 1);
  result_.corner_deviation_px = std::sqrt(variance_px / n * per_pixel);
  result_.misfit = dark_count * std::log(std::max(dark_square, 1e-12) / std::max(dark_count, 1.0)) +
                   light_count * std::log(std::max(light_square, 1e-12) / std::max(light_count, 1.0));
  result_.blur_px = blur_px_;
  const Eigen::Matrix<double, kUnknowns, kUnknowns> information = normal_.selfadjointView<Eigen::Lower>();
  const Eigen::Matrix<double, kUnknowns, kUnknowns> covariance =
      information.ldlt().solve(Eigen::Matrix<double, kUnknowns, kUnknowns>::Identity());
  result_.covariance = covariance.topLeftCorner(p, p) * std::max(per_pixel, 0.0);
  result_.reprojection_rms_px = std::sqrt(shift_square / n);
  const double sigma = std::sqrt((dark_square + light_square) / std::max(dark_count + light_count, 1.0));
  result_.signal_to_noise = contrast / n / std::max(sigma, 1e-6);
  result_.levels.assign(static_cast<std::size_t>(cells_), Eigen::Vector3f::Zero());
  for (int channel = 0; channel < channels_; ++channel)
    for (int cell = 0; cell < cells_; ++cell)
      result_.levels[static_cast<std::size_t>(cell)][channel] =
          levels_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(cell)];
}

const FittedBoard* PhotometricFit::Fit(const LightReader& reader, const Lens& lens, const Start& start) {
  if (!Prepare(reader, lens, start)) return nullptr;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    double move_px = 0;
    // The first step only has to come near: half the pixels do.
    input_.stride = iteration == 0 ? 2 : 1;
    if (!Step(&move_px)) return nullptr;
    if (move_px > 3) return nullptr;
    PlaceCorners(reader, lens);
    if (iteration == 0) EvenOutShading(start);
    if (iteration >= 1) {
      EstimateNoise();
      DropHiddenCorners();
    }
    if (iteration >= 2 && move_px < kSettledPx) break;
  }
  Finish();
  if (result_.corners_used < kFewestCorners || !result_.covariance.allFinite()) return nullptr;
  return &result_;
}

}  // namespace chequer
