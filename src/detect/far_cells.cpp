#include "detect/far_cells.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/smear.h"

namespace chequer {
namespace {

/// Of the blur over a cell's shorter way across: the edges beyond are half a cell away from a corner's farthest pixels.
constexpr double kLeastBlurOfCell = 0.14, kLeastBlurInShadow = 0.1;
/// The same from where on what the cells beyond do when the board moves counts against what the four around do.
constexpr double kMovingBlurOfCell = 0.22;
/// How far beyond the rim the light beside the board is looked up, cells, and half the width of the window.
constexpr double kBeside = 0.75, kBesideHalf = 0.25;

/// Between the points of a smear that are looked at, in blurs: their sum is even to 1 %.
constexpr double kTapBlurs = 1.5;
constexpr int kMostTaps = 16;
/// Of the derivatives by a smear, px, and every how many pixels tell it.
constexpr float kSmearStepPx = 0.2f;
constexpr int kSmearStride = 3;
/// Of the derivatives by moves, cells, and every how many pixels tell how much those count where nothing is smeared.
constexpr float kMoveStep = 0.02f;
constexpr int kMoveStride = 7;
/// The channel of that phase stands for all, which answer alike.
constexpr std::size_t kToldPhase = 1;
/// What pixels tell of the levels of cells that none shows.
constexpr double kLeastInformation = 1e-3;
/// Of the derivative by the ink's spread, cells.
constexpr float kSpreadStep = 0.01f;
/// Edges that spread to either side do so within as many of the spread at least: turned sooner, they would fold.
constexpr float kTurnSpreads = 1;

/// Shares of the four cells along one axis, from the one before the corner's two on.
using Shares = std::array<float, 4>;

/// Of the four cells around a corner, the one that is as dark or light as a cell of the 4 × 4 around it, and near.
std::size_t QuadrantOfColour(int row, int col) {
  const int near_row = std::clamp(row, 1, 2), near_col = std::clamp(col, 1, 2);
  const bool same = (row + col + near_row + near_col) % 2 == 0;
  return static_cast<std::size_t>(2 * (near_row - 1) + (same ? near_col - 1 : 2 - near_col));
}

}  // namespace

bool FarCells::ReachAcross(double share, const BoardPixels& pixels, double blur_px) {
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (!pixels.inside(corner)) continue;
    const Eigen::Matrix2d& pixel_by_board = pixels.place(corner).pixel_by_board;
    const double across =
        pixel_by_board.determinant() / std::max(pixel_by_board.col(0).norm(), pixel_by_board.col(1).norm());
    if (blur_px > share * across) return true;
  }
  return false;
}

bool FarCells::Matter(const BoardPixels& pixels, double blur_px, bool shadowed) {
  return ReachAcross(shadowed ? kLeastBlurInShadow : kLeastBlurOfCell, pixels, blur_px);
}

bool FarCells::MoveWithBoard(const Known& known, const BoardPixels& pixels) {
  return !known.smear_px.isZero() || known.ink_spread != 0 || ReachAcross(kMovingBlurOfCell, pixels, known.blur_px);
}

void FarCells::Start(const LightReader& reader, const Lens& lens, const BoardGeometry& geometry,
                     const std::array<int, 4>& channel_of_phase, const ShadowEdge* shadow, const BoardPixels& pixels) {
  channel_of_phase_ = channel_of_phase;
  taken_.resize(static_cast<std::size_t>(pixels.lanes().lanes() * pixels.lanes().capacity()));
  Forget(pixels);
  const int rows = pixels.size().rows + 2, cols = pixels.size().cols + 2;
  beside_.resize(static_cast<std::size_t>(rows * cols));
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      if (row > 0 && col > 0 && row < rows - 1 && col < cols - 1) continue;
      const auto along = [](int i, int count) {
        const double middle = i + 0.5 - 0.5 * count, rim = 0.5 * count - 1;
        return std::clamp(middle, -rim - kBeside, rim + kBeside);
      };
      const Eigen::Vector2d board(along(col, cols), along(row, rows));
      Eigen::Matrix2d pixel_by_plane;
      const Eigen::Vector2d pixel = lens.ToImage(geometry.ToPlane(board), &pixel_by_plane);
      const double half_px =
          kBesideHalf * std::sqrt(std::abs((pixel_by_plane * geometry.PlaneByBoard(board)).determinant()));
      const float lit = shadow ? static_cast<float>(shadow->At(board)) : 1;
      const Eigen::Vector3f light =
          reader.Rgb(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), static_cast<float>(half_px)) / lit;
      for (std::size_t phase = 0; phase < 4; ++phase)
        beside_[static_cast<std::size_t>(row * cols + col)][phase] =
            reader.channels() == 3 ? light[channel_of_phase[phase]] : RedAndGreen::Of(light[0], light[1]);
    }
}

Eigen::Vector2f FarCells::Around::From(float u, float v) const {
  return (board_from_plane * Eigen::Vector3f(u, v, 1)).hnormalized() - corner;
}

FarCells::Around FarCells::AroundCorner(const Known& known, const BoardPixels& pixels, int corner) const {
  const MarkerSize size = pixels.size();
  const CornerPlace& place = pixels.place(corner);
  const Eigen::Matrix2d board_by_pixel = place.pixel_by_board.inverse();
  Around around;
  around.board_from_plane = pixels.BoardFromPlane(*known.geometry).cast<float>();
  around.board_by_pixel = board_by_pixel.cast<float>();
  around.plane_by_board = (place.plane_by_pixel * place.pixel_by_board).cast<float>();
  around.corner = place.board.cast<float>();
  around.scale_x = static_cast<float>(1 / (board_by_pixel.row(0).norm() * known.blur_px));
  around.scale_y = static_cast<float>(1 / (board_by_pixel.row(1).norm() * known.blur_px));
  around.near_scale_x =
      around.scale_x / static_cast<float>(WiderBySmear(board_by_pixel.row(0), known.smear_px, known.blur_px));
  around.near_scale_y =
      around.scale_y / static_cast<float>(WiderBySmear(board_by_pixel.row(1), known.smear_px, known.blur_px));
  around.smear = (board_by_pixel * known.smear_px).cast<float>();
  around.taps =
      std::clamp(static_cast<int>(std::ceil(known.smear_px.norm() / (kTapBlurs * known.blur_px))), 1, kMostTaps);
  const int row = corner / (size.cols - 1), col = corner % (size.cols - 1), cols = size.cols + 2;
  around.row = row;
  around.col = col;
  around.falling = IsDark(row, col);
  const QuadrantLevels quadrants = LevelsAround(size, corner, known.own_levels);
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) {
      const bool on_board = row + r > 0 && row + r <= size.rows && col + c > 0 && col + c <= size.cols;
      around.light[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] =
          known.own_levels && on_board ? known.levels[static_cast<std::size_t>(quadrants[QuadrantOfColour(r, c)])]
                                       : cells_[static_cast<std::size_t>((row + r) * cols + col + c)];
    }
  return around;
}

float FarCells::Near(const Around& around, int phase, const Eigen::Vector2f& from, float spread) const {
  const auto light = [&](std::size_t row, std::size_t col) {
    return around.light[1 + row][1 + col][static_cast<std::size_t>(phase)];
  };
  // Mirrored so that the dark cells are those up left and down right.
  const std::size_t left = around.falling ? 0 : 1, right = 1 - left;
  const float x = (around.falling ? from.x() : -from.x()), y = from.y();
  const float at_right = Integral((x - spread) * around.scale_x), at_left = Integral((-x - spread) * around.scale_x);
  const float below = Integral((y - spread) * around.scale_y), above = Integral((-y - spread) * around.scale_y);
  const float both = (1 - at_right - at_left) * (1 - below - above);
  return light(0, right) * at_right * above + light(1, left) * at_left * below +
         light(0, left) * ((1 - at_right) * (1 - below) - both / 2) +
         light(1, right) * ((1 - at_left) * (1 - above) - both / 2);
}

float FarCells::Far(const Around& around, int phase, const Eigen::Vector2f& from, float spread) const {
  const auto shares = [&](float x, float scale, Shares& all, Shares& near) {
    const float before = Integral((x + 1) * scale), here = Integral(x * scale), after = Integral((x - 1) * scale);
    all = {1 - before, before - here, here - after, after};
    near = {0, 1 - here, here, 0};
  };
  Shares all_x, near_x, all_y, near_y;
  shares(from.x(), around.scale_x, all_x, near_x);
  shares(from.y(), around.scale_y, all_y, near_y);
  float far = 0;
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t col = 0; col < 4; ++col)
      far += (all_y[row] * all_x[col] - near_y[row] * near_x[col]) *
             around.light[row][col][static_cast<std::size_t>(phase)];
  if (spread == 0) return far;
  return far + Near(around, phase, from, spread) - Near(around, phase, Unspread(around, from, spread), 0);
}

Eigen::Vector2f FarCells::Unspread(const Around& around, const Eigen::Vector2f& from, float spread) const {
  const float most_scale = 1 / (kTurnSpreads * std::abs(spread)), side = around.falling ? spread : -spread;
  const auto turn = [&](float at, float scale) { return side * (2 * Integral(at * std::min(scale, most_scale)) - 1); };
  return from + Eigen::Vector2f(turn(from.y(), around.scale_y), turn(from.x(), around.scale_x));
}

float FarCells::FarOfSmeared(const Around& around, int phase, const Eigen::Vector2f& from) const {
  return Smeared(around, phase, from, around.smear) - NearOfSmeared(around, phase, from);
}

FarCells::CellShares FarCells::SharesOfSmeared(const Around& around, const Eigen::Vector2f& from,
                                               const Eigen::Vector2f& smear) const {
  CellShares all{};
  for (int tap = 0; tap < around.taps; ++tap) {
    const float part = (static_cast<float>(tap) + 0.5f) / static_cast<float>(around.taps) - 0.5f;
    const float x = from.x() + part * smear.x(), y = from.y() + part * smear.y();
    const auto shares = [&](float at, float scale) {
      const float before = Integral((at + 1) * scale), here = Integral(at * scale), after = Integral((at - 1) * scale);
      return Shares{1 - before, before - here, here - after, after};
    };
    const Shares along = shares(x, around.scale_x), down = shares(y, around.scale_y);
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t col = 0; col < 4; ++col) all[4 * row + col] += down[row] * along[col];
  }
  for (float& share : all) share /= static_cast<float>(around.taps);
  return all;
}

FarCells::CellShares FarCells::SharesOfModel(const Around& around, const Eigen::Vector2f& from) const {
  const float right = Integral(from.x() * around.near_scale_x), below = Integral(from.y() * around.near_scale_y);
  CellShares shares{};
  shares[5] = (1 - below) * (1 - right);
  shares[6] = (1 - below) * right;
  shares[9] = below * (1 - right);
  shares[10] = below * right;
  return shares;
}

float FarCells::Smeared(const Around& around, int phase, const Eigen::Vector2f& from,
                        const Eigen::Vector2f& smear) const {
  const CellShares all = SharesOfSmeared(around, from, smear);
  float light = 0;
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t col = 0; col < 4; ++col)
      light += all[4 * row + col] * around.light[row][col][static_cast<std::size_t>(phase)];
  return light;
}

float FarCells::NearOfSmeared(const Around& around, int phase, const Eigen::Vector2f& from) const {
  const CellShares shares = SharesOfModel(around, from);
  float light = 0;
  for (std::size_t row = 1; row < 3; ++row)
    for (std::size_t col = 1; col < 3; ++col)
      light += shares[4 * row + col] * around.light[row][col][static_cast<std::size_t>(phase)];
  return light;
}

void FarCells::SetCells(const Known& known, MarkerSize size) {
  cells_ = beside_;
  if (known.own_levels) return;
  for (int row = 0; row < size.rows; ++row)
    std::copy_n(known.levels.begin() + row * size.cols, size.cols, cells_.begin() + (row + 1) * (size.cols + 2) + 1);
}

void FarCells::TakeOut(const Known& known, BoardPixels& pixels) {
  SetCells(known, pixels.size());
  const float spread = static_cast<float>(known.ink_spread);
  const bool smeared = !known.smear_px.isZero();
  LaneBlock& lanes = pixels.lanes();
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (!pixels.inside(corner)) continue;
    const Around around = AroundCorner(known, pixels, corner);
    for (int phase = 0; phase < 4; ++phase) {
      const int lane = pixels.Lane(corner) + phase;
      for (int i = 0; i < lanes.count(lane); ++i) {
        const std::size_t at = lanes.Place(lane, i);
        float &u = lanes.u_data()[at], &v = lanes.v_data()[at], &light = lanes.light_data()[at];
        if (light >= known.saturation) continue;
        Taken& taken = taken_[static_cast<std::size_t>(lane * lanes.capacity() + i)];
        u -= taken.u;
        v -= taken.v;
        light += taken.light;
        const Eigen::Vector2f from = around.From(u, v);
        taken = {smeared ? FarOfSmeared(around, phase, from) : Far(around, phase, from, spread), 0, 0};
        if (spread != 0) {
          const Eigen::Vector2f move = around.plane_by_board * (Unspread(around, from, spread) - from);
          taken.u = move.x();
          taken.v = move.y();
        }
        u += taken.u;
        v += taken.v;
        light -= taken.light;
      }
    }
  }
}

void FarCells::PutBack(BoardPixels& pixels) {
  LaneBlock& lanes = pixels.lanes();
  for (int lane = 0; lane < lanes.lanes(); ++lane)
    for (int i = 0; i < lanes.count(lane); ++i) {
      Taken& taken = taken_[static_cast<std::size_t>(lane * lanes.capacity() + i)];
      const std::size_t at = lanes.Place(lane, i);
      lanes.u_data()[at] -= taken.u;
      lanes.v_data()[at] -= taken.v;
      lanes.light_data()[at] += taken.light;
      taken = {};
    }
}

void FarCells::Forget(const BoardPixels& pixels) {
  const LaneBlock& lanes = pixels.lanes();
  for (int lane = 0; lane < lanes.lanes(); ++lane)
    std::fill_n(taken_.begin() + lane * lanes.capacity(), lanes.count(lane), Taken{});
}

template <class Visit>
void FarCells::ForPixels(const Known& known, std::span<const bool> used, const BoardPixels& pixels, int stride,
                         const Visit& visit) const {
  const LaneBlock& lanes = pixels.lanes();
  for (int corner = 0; corner < pixels.corners(); ++corner) {
    if (!used[static_cast<std::size_t>(corner)]) continue;
    const Around around = AroundCorner(known, pixels, corner);
    for (int phase = 0; phase < 4; ++phase) {
      const int lane = pixels.Lane(corner) + phase;
      for (int i = 0; i < lanes.count(lane); i += stride) {
        const std::size_t at = lanes.Place(lane, i);
        const float light = lanes.light_data()[at];
        if (light >= known.saturation) continue;
        const Taken& taken = taken_[static_cast<std::size_t>(lane * lanes.capacity() + i)];
        visit(around, phase, around.From(lanes.u_data()[at] - taken.u, lanes.v_data()[at] - taken.v), light);
      }
    }
  }
}

double FarCells::MoreInkSpread(const Known& known, std::span<const bool> used, const BoardPixels& pixels, int stride) {
  SetCells(known, pixels.size());
  const float spread = static_cast<float>(known.ink_spread);
  double slope_residual = 0, slope_square = 0;
  ForPixels(known, used, pixels, stride,
            [&](const Around& around, int phase, const Eigen::Vector2f& from, float light) {
              const float slope =
                  (Near(around, phase, from, spread + kSpreadStep) - Near(around, phase, from, spread - kSpreadStep)) /
                  (2 * kSpreadStep);
              const Eigen::Vector2f unspread = spread == 0 ? from : Unspread(around, from, spread);
              slope_residual += slope * (light - Near(around, phase, unspread, 0));
              slope_square += slope * slope;
            });
  return slope_square > 0 ? slope_residual / slope_square : 0;
}

Eigen::Vector2d FarCells::MoreSmear(const Known& known, std::span<const bool> used, const BoardPixels& pixels) const {
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  Eigen::Vector2d products = Eigen::Vector2d::Zero();
  const auto add = [&](const Around& around, int phase, const Eigen::Vector2f& from, float light) {
    Eigen::Vector2d slope;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2f step = kSmearStepPx * around.board_by_pixel.col(axis);
      slope[axis] = static_cast<double>(Smeared(around, phase, from, around.smear + step) -
                                        Smeared(around, phase, from, around.smear - step)) /
                    (2 * static_cast<double>(kSmearStepPx));
    }
    squares += slope * slope.transpose();
    products += slope * static_cast<double>(light - NearOfSmeared(around, phase, from));
  };
  ForPixels(known, used, pixels, kSmearStride, add);
  return squares.determinant() > 0 ? Eigen::Vector2d(squares.inverse() * products) : Eigen::Vector2d::Zero();
}

/// Of a pixel's light, by the geometry's parameters and by the levels around, as far as those are not zero.
struct FarCells::PixelDerivatives {
  PixelDerivatives(const Around& around, MarkerSize size, const BoardGeometry::Parameters& by_geometry,
                   const CellShares& by_levels) {
    for (int i = 0; i < BoardGeometry::kParameters; ++i) Add(i, by_geometry[i]);
    for (int i = 0; i < 16; ++i) {
      const int row = around.row - 1 + i / 4, col = around.col - 1 + i % 4;
      const float share = by_levels[static_cast<std::size_t>(i)];
      if (share == 0 || row < 0 || col < 0 || row >= size.rows || col >= size.cols) continue;
      Add(BoardGeometry::kParameters + row * size.cols + col, static_cast<double>(share));
    }
  }
  void Add(int unknown, double by) {
    of[count] = unknown;
    value[count++] = by;
  }

  std::array<double, BoardGeometry::kParameters + 16> value;
  std::array<int, BoardGeometry::kParameters + 16> of;
  std::size_t count = 0;
};

BoardGeometry::Information FarCells::ResponseToMoves(const Known& known, std::span<const bool> used,
                                                     const BoardPixels& pixels) {
  constexpr int kParameters = BoardGeometry::kParameters;
  const MarkerSize size = pixels.size();
  const int unknowns = kParameters + size.rows * size.cols;
  const float spread = static_cast<float>(known.ink_spread);
  // The steps solve own · step = modelᵀ residual; what is there answers with both · truth.
  Eigen::MatrixXd &own = moves_.own, &both = moves_.both;
  own.setIdentity(unknowns, unknowns);
  own *= kLeastInformation;
  both = own;
  const auto add = [&](const Around& around, int phase, const Eigen::Vector2f& from, float) {
    if (channel_of_phase_[static_cast<std::size_t>(phase)] != channel_of_phase_[kToldPhase]) return;
    const Eigen::Vector2d board = (around.corner + from).cast<double>();
    const Eigen::Vector2f seen_at = spread == 0 ? from : Unspread(around, from, spread);
    BoardGeometry::Parameters by_model = BoardGeometry::Parameters::Zero(), by_image = by_model;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2f step = kMoveStep * Eigen::Vector2f::Unit(axis);
      const BoardGeometry::Parameters move =
          BoardGeometry::MoveByParameters(board, axis) / (2 * static_cast<double>(kMoveStep));
      const auto slope = [&](const auto& light) { return static_cast<double>(light(step) - light(-step)); };
      by_model += slope([&](const Eigen::Vector2f& by) { return NearOfSmeared(around, phase, seen_at + by); }) * move;
      by_image += slope([&](const Eigen::Vector2f& by) {
                    return spread == 0 ? Smeared(around, phase, from + by, around.smear)
                                       : Near(around, phase, from + by, spread);
                  }) *
                  move;
    }
    const CellShares shares = SharesOfModel(around, seen_at);
    const PixelDerivatives model(around, size, by_model, shares);
    const PixelDerivatives image(around, size, by_image,
                                 spread == 0 ? SharesOfSmeared(around, from, around.smear) : shares);
    for (std::size_t i = 0; i < model.count; ++i) {
      for (std::size_t j = 0; j < model.count; ++j) own(model.of[j], model.of[i]) += model.value[i] * model.value[j];
      for (std::size_t j = 0; j < image.count; ++j) both(model.of[i], image.of[j]) += model.value[i] * image.value[j];
    }
  };
  ForPixels(known, used, pixels, known.smear_px.isZero() ? kMoveStride : kSmearStride, add);
  // Of a pixel noise of one, the geometry's covariances.
  Moves& m = moves_;
  m.geometry.setIdentity(unknowns, kParameters);
  m.own_factor.compute(own);
  m.of_own = m.own_factor.solve(m.geometry);
  both.transposeInPlace();
  m.both_factor.compute(both);
  m.answer = m.both_factor.solve(m.geometry);
  m.product.noalias() = own * m.answer;
  const auto root = [](const BoardGeometry::Information& covariance) {
    return BoardGeometry::Information(covariance.llt().matrixL());
  };
  return root(m.of_own.topRows<kParameters>()) * root(m.answer.transpose() * m.product).inverse();
}

}  // namespace chequer
