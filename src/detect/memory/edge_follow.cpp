#include "detect/memory/edge_follow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// Side of the windows whose light is asked. Over an edge it changes by the edge's place as far as that lies within.
constexpr int kWindowPx = 4;
/// Smaller cells have no room for them.
constexpr float kLeastCellPx = 6;
/// An edge nearer to its window's rim than by a tenth of it tells little (a guess).
constexpr float kMostOffMiddle = 0.4f;
/// Of the board's edges that are asked, those that must agree, and how well, px (guesses).
constexpr float kMostMustAgree = 2.0f / 3, kAgreePx = 0.25f;
/// Boards that are nearer are fitted with the pixels that were chosen (see board_fit.cpp); those that are farther,
/// cells, may lie elsewhere.
constexpr float kLeastMovePx = 0.1f, kMostMoveCells = 0.25f;
/// A board that is nearer by the edges along its rim is not asked further: of boards that the others would have moved,
/// by up to 0.18 px, one in two hundred stays (measured).
constexpr float kLeastMoveOfRimPx = 0.08f;

/// Edges that tell one direction by so much less than another do not tell it (rounding).
constexpr double kLeastShare = 1e-6;

/// Windows of pixels around points of a board.
class Windows {
 public:
  Windows(const AnchoredBoard& board, const LightReader& reader, const Lens& lens)
      : width_(reader.width()), height_(reader.height()), rows_(reader.AllRows()) {
    const BoardPoint middle(BoardGeometry(board.plane_from_board), lens);
    Eigen::Matrix3d pixel_from_plane = Eigen::Matrix3d::Identity();
    pixel_from_plane.topLeftCorner<2, 2>() = middle.pixel_by_plane;
    pixel_from_plane.topRightCorner<2, 1>() = middle.pixel - middle.pixel_by_plane * middle.plane;
    pixel_from_board_ = (pixel_from_plane * board.plane_from_board).cast<float>();
    pixel_by_board_ = middle.pixel_by_board.cast<float>();
  }

  const Eigen::Matrix2f& pixel_by_board() const { return pixel_by_board_; }
  Eigen::Vector2f PixelOf(const Eigen::Vector2f& board) const {
    const Eigen::Matrix3f& h = pixel_from_board_;
    const float x = board.x(), y = board.y();
    const float w = 1 / (h(2, 0) * x + h(2, 1) * y + h(2, 2));
    return {(h(0, 0) * x + h(0, 1) * y + h(0, 2)) * w, (h(1, 0) * x + h(1, 1) * y + h(1, 2)) * w};
  }

  /// Light around a pixel: of a colour image the green; negative where the window is not all in the image.
  /// @param middle_px set to the window's middle.
  float Around(const Eigen::Vector2f& pixel, Eigen::Vector2f& middle_px) const {
    constexpr float kToFirst = 0.5f * kWindowPx - 1;
    // Also false of what is no number, or too large for one.
    if (!(pixel.x() >= kToFirst && pixel.y() >= kToFirst && pixel.x() < static_cast<float>(width_) - kToFirst - 1 &&
          pixel.y() < static_cast<float>(height_) - kToFirst - 1))
      return -1;
    const int x0 = static_cast<int>(pixel.x() - kToFirst), y0 = static_cast<int>(pixel.y() - kToFirst);
    middle_px = {static_cast<float>(x0) + 0.5f * (kWindowPx - 1), static_cast<float>(y0) + 0.5f * (kWindowPx - 1)};
    float sum = 0;
    for (int parity = 0; parity < 2; ++parity) {
      LightReader::Run run = rows_.From(x0, y0 + parity);
      for (int y = parity; y < kWindowPx; y += 2, rows_.NextButOne(run))
        sum += (run.table[*run.first] + run.table[*run.second]) +
               (run.table[run.first[run.step]] + run.table[run.second[run.step]]);
    }
    return sum * (1.0f / (kWindowPx * kWindowPx));
  }

 private:
  const int width_, height_;
  const LightReader::Rows rows_;
  Eigen::Matrix3f pixel_from_board_ = Eigen::Matrix3f::Identity();
  Eigen::Matrix2f pixel_by_board_ = Eigen::Matrix2f::Identity();
};

/// How far an edge lies from where it is expected, along one of the board's axes: cells.
struct Offset {
  float x, y, cells;  ///< board coordinates, and how far
  int axis;
  float towards_light;  ///< 1 where the cell farther on is the light one, else -1
};

/// A way along both axes, and a turn, cells and rad; and how far all edges lie towards dark cells, as those of
/// overexposed light ones do, or of dark ones without dot gain.
struct Move {
  Eigen::Vector4f values = Eigen::Vector4f::Zero();

  static Eigen::Vector4f By(const Offset& offset) {
    return offset.axis == 0 ? Eigen::Vector4f(1, 0, -offset.y, -offset.towards_light)
                            : Eigen::Vector4f(0, 1, offset.x, -offset.towards_light);
  }
  float Of(const Offset& offset) const { return By(offset).dot(values); }
  float x() const { return values[0]; }
  float y() const { return values[1]; }
  float turn() const { return values[2]; }
};

/// Of least squares; infinite where the edges do not tell.
Move MoveOf(std::span<const Offset> offsets) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
  for (const Offset& offset : offsets) {
    const Eigen::Vector4d by = Move::By(offset).cast<double>();
    normal += by * by.transpose();
    gradient += double{offset.cells} * by;
  }
  const SmallCholesky<4> factor(normal);
  if (!factor.IsSound(kLeastShare)) return {Eigen::Vector4f::Constant(std::numeric_limits<float>::infinity())};
  return {factor.Solve(gradient).cast<float>()};
}

/// What edges tell of where the board lies.
class EdgeOffsets {
 public:
  EdgeOffsets(const AnchoredBoard& board, const LightReader& reader, const Lens& lens)
      : size_(board.size), windows_(board, reader, lens) {
    light_.fill(kNotAsked);
  }

  float cell_px() const { return windows_.pixel_by_board().colwise().norm().minCoeff(); }
  std::span<const Offset> offsets() const { return std::span(offsets_).first(count_); }
  /// Asks half of the edges along the board's rim, or of all others. Whether most that were asked, by now, show within
  /// their windows.
  bool Ask(bool on_rim) {
    for (const int axis : {0, 1})
      ForCells(size_, [&](std::size_t cell, int row, int col) {
        const bool is_last = axis == 0 ? col + 1 == size_.cols : row + 1 == size_.rows;
        if (is_last || (row + col / 2) % 2 != 0) return;  // half of them, dark to light and light to dark
        const bool is_on_rim = axis == 0 ? row == 0 || row + 1 == size_.rows : col == 0 || col + 1 == size_.cols;
        if (is_on_rim != on_rim) return;
        ++asked_;
        AskEdge(axis, cell, row, col);
      });
    return static_cast<float>(count_) >= kMostMustAgree * static_cast<float>(asked_);
  }

 private:
  Eigen::Vector2f MiddleOf(std::size_t cell) const { return MiddleOfCell(size_, static_cast<int>(cell)).cast<float>(); }

  float LightOf(std::size_t cell) {
    Eigen::Vector2f middle;
    if (light_[cell] == kNotAsked) light_[cell] = windows_.Around(windows_.PixelOf(MiddleOf(cell)), middle);
    return light_[cell];
  }

  void AskEdge(int axis, std::size_t cell, int row, int col) {
    const float here = LightOf(cell), next = LightOf(cell + (axis == 0 ? 1u : static_cast<std::size_t>(size_.cols)));
    if (here < 0 || next < 0 || (next > here) != IsDark(row, col)) return;
    Eigen::Vector2f at = MiddleOf(cell);
    at[axis] += 0.5f;
    const Eigen::Vector2f pixel = windows_.PixelOf(at);
    Eigen::Vector2f middle;
    const float light = windows_.Around(pixel, middle), off = (light - here) / (next - here) - 0.5f;
    if (light < 0 || !(std::abs(off) < kMostOffMiddle)) return;
    const Eigen::Vector2f across = windows_.pixel_by_board().col(axis);
    const float per_cell = 1 / across.norm();
    // The window's middle lies beside the edge, too.
    const float reach_px = kWindowPx * across.cwiseAbs().maxCoeff() * per_cell;
    offsets_[count_++] = {at.x(), at.y(), (across.dot(middle - pixel) * per_cell - reach_px * off) * per_cell, axis,
                          next > here ? 1.0f : -1.0f};
  }

  static constexpr float kNotAsked = -2;

  const MarkerSize size_;
  const Windows windows_;
  std::array<float, kMaxCells> light_;
  std::array<Offset, kMaxCells> offsets_;
  std::size_t count_ = 0, asked_ = 0;
};

}  // namespace

bool HasEdgesToFollow(const AnchoredBoard& board, const Lens& lens) {
  const BoardPoint middle(BoardGeometry(board.plane_from_board), lens);
  return middle.pixel_by_board.colwise().norm().minCoeff() >= double{kLeastCellPx};
}

std::optional<Eigen::Matrix3d> FollowEdges(const AnchoredBoard& board, const LightReader& reader, const Lens& lens) {
  EdgeOffsets edges(board, reader, lens);
  const float cell_px = edges.cell_px(), half = 0.5f * static_cast<float>(std::max(board.size.rows, board.size.cols));
  const auto farthest = [&](const Move& move) { return std::hypot(move.x(), move.y()) + half * std::abs(move.turn()); };
  if (!(cell_px >= kLeastCellPx)) return std::nullopt;
  if (edges.Ask(true) && farthest(MoveOf(edges.offsets())) * cell_px < kLeastMoveOfRimPx) return std::nullopt;
  if (!edges.Ask(false)) return std::nullopt;
  const Move move = MoveOf(edges.offsets());
  float square = 0;
  for (const Offset& offset : edges.offsets()) square += std::pow(offset.cells - move.Of(offset), 2.0f);
  const float left_px = std::sqrt(square / static_cast<float>(edges.offsets().size())) * cell_px;
  const float most = farthest(move);
  if (!(left_px < kAgreePx) || !(most < kMostMoveCells) || most * cell_px < kLeastMovePx) return std::nullopt;
  Eigen::Matrix3d moved = Eigen::Matrix3d::Identity();
  moved(0, 1) = -double{move.turn()};
  moved(1, 0) = double{move.turn()};
  moved(0, 2) = double{move.x()};
  moved(1, 2) = double{move.y()};
  moved = board.plane_from_board * moved;
  return moved / moved(2, 2);
}

}  // namespace chequer
