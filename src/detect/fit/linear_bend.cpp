#include "detect/fit/linear_bend.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/small_cholesky.h"

namespace chequer {
namespace {

/// Products of the columns for corners that are off by their shifts, four corners at a time. Most of a homography's
/// moves are of x or of y alone, by 1, x or y: their products are sums of information times powers.
class ShiftProducts {
 public:
  using Four = Eigen::Array4f;
  struct Corners {
    Four x = Four::Zero(), y = Four::Zero(), shift_x = Four::Zero(), shift_y = Four::Zero();
    Four xx = Four::Zero(), xy = Four::Zero(), yy = Four::Zero();  ///< information
  };

  /// @param camera where it is, from the board's middle and along its axes: in cells, its z in widths of one, negative.
  ShiftProducts(const Eigen::Vector3d& camera, double cell_ratio)
      : camera_x_(static_cast<float>(camera.x())),
        camera_y_(static_cast<float>(camera.y())),
        by_depth_(static_cast<float>(-std::sqrt(cell_ratio) / camera.z())) {}

  void Add(const Corners& at) {
    const Four &x = at.x, &y = at.y, square_x = x * x, product = x * y, square_y = y * y;
    // A point behind the plane is seen where its ray meets the plane, nearer to below the camera: there, coordinates
    // are too small by as much.
    const Four lower_x = by_depth_ * (x - camera_x_), lower_y = by_depth_ * (y - camera_y_);
    const float mean = static_cast<float>(kAlongEdge);
    const Four by_x[]{square_x,  product, lower_x * square_x, lower_x * product, lower_x * (square_y + mean),
                      at.shift_x};
    const Four by_y[]{product,           square_y,           lower_y * (square_x + mean),
                      lower_y * product, lower_y * square_y, at.shift_y};
    const Four powers[]{Four::Ones(), x, y, square_x, product, square_y};
    for (int i = 0; i < 6; ++i) {
      xx_.col(i) += at.xx * powers[i];
      xy_.col(i) += at.xy * powers[i];
      yy_.col(i) += at.yy * powers[i];
    }
    for (int row = 0; row < kColumns; ++row) {
      const Four pull_x = at.xx * by_x[row] + at.xy * by_y[row], pull_y = at.xy * by_x[row] + at.yy * by_y[row];
      for (int i = 0; i < 3; ++i) {
        x_.col(3 * row + i) += pull_x * powers[i];
        y_.col(3 * row + i) += pull_y * powers[i];
      }
      for (int col = 0; col <= row; ++col) both_.col(kColumns * row + col) += by_x[col] * pull_x + by_y[col] * pull_y;
    }
  }

  /// The lower triangle.
  LinearBend::Products Sum() const {
    constexpr int kPower[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    LinearBend::Products products = LinearBend::Products::Zero();
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 3; ++col) {
        const int power = kPower[row][col];
        products(row, col) = double{xx_.col(power).sum()};
        products(3 + row, col) = double{xy_.col(power).sum()};
        products(3 + row, 3 + col) = double{yy_.col(power).sum()};
      }
    for (int row = 0; row < kColumns; ++row) {
      for (int col = 0; col < 3; ++col) {
        products(6 + row, col) = double{x_.col(3 * row + col).sum()};
        products(6 + row, 3 + col) = double{y_.col(3 * row + col).sum()};
      }
      for (int col = 0; col <= row; ++col) products(6 + row, 6 + col) = double{both_.col(kColumns * row + col).sum()};
    }
    return products;
  }

 private:
  static constexpr int kBoth = 2 + LinearBend::kBends;  ///< columns that move x and y: two moves, and the bend
  static constexpr int kColumns = kBoth + 1;            ///< these, and the shifts
  template <int kCount>
  using Fours = Eigen::Array<float, 4, kCount>;

  float camera_x_, camera_y_, by_depth_;
  /// By 1, x, y, x², xy, y².
  Fours<6> xx_ = Fours<6>::Zero(), xy_ = Fours<6>::Zero(), yy_ = Fours<6>::Zero();
  /// Of columns that move both, and of the shifts, with those that move x or y alone: by 1, x, y.
  Fours<3 *kColumns> x_ = Fours<3 * kColumns>::Zero(), y_ = Fours<3 * kColumns>::Zero();
  Fours<kColumns* kColumns> both_ = Fours<kColumns * kColumns>::Zero();  ///< with each other
};

}  // namespace

std::optional<LinearBend> LinearBend::Of(const Products& products) {
  const SmallCholesky<kMoves> factor(products.topLeftCorner<kMoves, kMoves>());
  if (!factor.positive()) return std::nullopt;
  const Eigen::Matrix<double, kBends, kMoves> common = products.block<kBends, kMoves>(kMoves, 0);
  LinearBend linear;
  for (int bend = 0; bend < kBends; ++bend) linear.moves_by_bend.col(bend) = -factor.Solve(common.row(bend));
  const Eigen::Matrix3d of_bends = products.block<kBends, kBends>(kMoves, kMoves);
  linear.information = of_bends.selfadjointView<Eigen::Lower>();
  linear.information += common.lazyProduct(linear.moves_by_bend);
  linear.information.diagonal().array() += 1 / (kBendKnownTo * kBendKnownTo);
  const Eigen::Matrix<double, kMoves, 1> of_moves = products.row(kColumns - 1).head<kMoves>();
  Eigen::Vector3d gradient = products.row(kColumns - 1).segment<kBends>(kMoves);
  gradient += linear.moves_by_bend.transpose().lazyProduct(of_moves);
  const SmallCholesky<kBends> bends(linear.information);
  if (!bends.positive()) return std::nullopt;
  linear.bend = bends.Solve(gradient);
  linear.gain = gradient.dot(linear.bend);
  linear.square = products(kColumns - 1, kColumns - 1);
  return linear;
}

Eigen::Matrix<double, LinearBend::kMoves, LinearBend::kBends> LinearBend::UncertainMoves() const {
  const Eigen::LLT<Eigen::Matrix3d> covariance(SmallCholesky<kBends>(information).Inverse());
  return moves_by_bend.lazyProduct(Eigen::Matrix3d(covariance.matrixL()));
}

std::optional<LinearBend> FindLinearBend(const RigidTransform& camera_from_board, double cell_ratio,
                                         std::span<const ShiftedCorner> corners) {
  Eigen::Vector3d camera = -(camera_from_board.rotation.conjugate() * camera_from_board.translation);
  camera.y() /= cell_ratio;
  ShiftProducts products(camera, cell_ratio);
  for (; !corners.empty(); corners = corners.subspan(std::min<std::size_t>(4, corners.size()))) {
    ShiftProducts::Corners four;
    for (std::size_t i = 0; i < std::min<std::size_t>(4, corners.size()); ++i) {
      const ShiftedCorner& corner = corners[i];
      const Eigen::Index lane = static_cast<Eigen::Index>(i);
      const auto set = [&](ShiftProducts::Four& to, double value) { to[lane] = static_cast<float>(value); };
      set(four.x, corner.board.x()), set(four.y, corner.board.y());
      set(four.shift_x, corner.shift.x()), set(four.shift_y, corner.shift.y());
      set(four.xx, corner.information(0, 0)), set(four.xy, corner.information(0, 1));
      set(four.yy, corner.information(1, 1));
    }
    products.Add(four);
  }
  return LinearBend::Of(products.Sum());
}

}  // namespace chequer
