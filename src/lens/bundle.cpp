#include "lens/bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/lens_parameters.h"
#include "core/small_cholesky.h"

namespace chequer {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Poses6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// Columns of the lens parameters, those that a model does not have included: their derivatives are zero, so they stay,
/// and sums over points are of fixed size.
constexpr int kLens = kMostLensParameters;

/// Columns of the sheet's bend, and of all that comes before the boards' places.
constexpr int kBend = 3, kBeforeBoards = kLens + kBend;

/// Paper that is glued to something bends to radii of some metres, either way, 1/m. Views that show how it bends
/// outweigh that; where they do not, it keeps the bend from growing, and the lens's uncertainty holds what the bend may
/// be.
constexpr double kUsualBend = 0.3;
/// How far corners lie from where they should be, for the weight of that against points, pixels.
constexpr double kUsualNoisePx = 0.05;
constexpr double kBendWeight = kUsualNoisePx * kUsualNoisePx / (kUsualBend * kUsualBend);

/// A pixel that a point behind the camera counts as being off: a step that goes there is refused.
constexpr double kBehindPx = 1e4;

/// The normal equations of one view's pose and what it shares with others.
struct ViewEquations {
  Matrix6d pose = Matrix6d::Zero();
  Vector6d pose_gradient = Vector6d::Zero();
  Poses6 pose_by_shared;
  Eigen::VectorXd shared_gradient;  ///< of this view alone
};

/// The normal equations of all.
struct Equations {
  Eigen::MatrixXd shared;
  Eigen::VectorXd shared_gradient;
  std::vector<ViewEquations> views;
  double cost = 0;
  double square = 0;  ///< of all distances, not robust
  std::size_t points = 0;
};

int SharedCount(const Bundle& bundle) { return kBeforeBoards + 3 * (static_cast<int>(bundle.boards.size()) - 1); }

Eigen::Vector3d OnSheet(const Bundle& bundle, const SeenPoint& point) {
  return bundle.bend * (bundle.boards[static_cast<std::size_t>(point.board)] * point.on_board_m);
}

double Huber(double distance, double limit) {
  return limit <= 0 || distance <= limit ? distance * distance : limit * (2 * distance - limit);
}

double Cost(std::span<const LensView> views, const Bundle& bundle, double robust_px) {
  double cost = kBendWeight * bundle.bend.curvature.squaredNorm();
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const SeenPoint& point : views[v].points) {
      const auto pixel = PredictPixel(bundle, v, point);
      cost += Huber(pixel ? (*pixel - point.pixel).norm() : kBehindPx, robust_px);
    }
  return cost;
}

/// Derivatives of one point's pixel by what is shared, at most 15 columns that are not zero.
struct SharedDerivative {
  /// By the lens's numbers, then by the bend's.
  Eigen::Matrix<double, 2, kBeforeBoards> lens = Eigen::Matrix<double, 2, kBeforeBoards>::Zero();
  Eigen::Matrix<double, 2, 3> board = Eigen::Matrix<double, 2, 3>::Zero();
  int board_column = -1;  ///< −1: the board that stays
};

/// How a point's height over the sheet follows the bend; what it moves within the sheet is of second order.
Eigen::RowVector3d HeightByBend(const Eigen::Vector2d& flat) {
  return {flat.x() * flat.x() / 2, flat.x() * flat.y(), flat.y() * flat.y() / 2};
}

void AddPoint(const SharedDerivative& by, const Eigen::Matrix<double, 2, 6>& by_pose, const Eigen::Vector2d& residual,
              double weight, Equations& equations, ViewEquations& view) {
  const Eigen::Matrix<double, kBeforeBoards, 2> lens = weight * by.lens.transpose();
  const Eigen::Matrix<double, 6, 2> pose = weight * by_pose.transpose();
  equations.shared.topLeftCorner<kBeforeBoards, kBeforeBoards>().noalias() += lens * by.lens;
  view.shared_gradient.head<kBeforeBoards>().noalias() += lens * residual;
  view.pose_by_shared.leftCols<kBeforeBoards>().noalias() += pose * by.lens;
  if (by.board_column >= 0) {
    const int column = by.board_column;
    const Eigen::Matrix<double, 3, 2> board = weight * by.board.transpose();
    equations.shared.block<kBeforeBoards, 3>(0, column).noalias() += lens * by.board;
    equations.shared.block<3, 3>(column, column).noalias() += board * by.board;
    view.shared_gradient.segment<3>(column).noalias() += board * residual;
    view.pose_by_shared.middleCols<3>(column).noalias() += pose * by.board;
  }
  view.pose.noalias() += pose * by_pose;
  view.pose_gradient.noalias() += pose * residual;
}

void AddView(const LensView& seen, const Bundle& bundle, std::size_t index, const BundleOptions& options,
             Equations& equations) {
  const RigidTransform& pose = bundle.camera_from_sheet[index];
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  ViewEquations& view = equations.views[index];
  view.pose_by_shared = Poses6::Zero(6, equations.shared.cols());
  view.shared_gradient = Eigen::VectorXd::Zero(equations.shared.cols());
  for (const SeenPoint& point : seen.points) {
    const Eigen::Vector3d turned = rotation * OnSheet(bundle, point);
    const auto projected = ProjectWithDerivatives(bundle.camera, turned + pose.translation);
    if (!projected) continue;
    const Eigen::Vector2d residual = projected->pixel - point.pixel;
    const double distance = residual.norm();
    equations.square += distance * distance;
    ++equations.points;
    SharedDerivative by;
    const Eigen::Vector2d flat = bundle.boards[static_cast<std::size_t>(point.board)] * point.on_board_m;
    by.lens.leftCols<kLens>() = projected->by_lens;
    if (options.bends) by.lens.rightCols<kBend>() = projected->by_point * rotation.col(2) * HeightByBend(flat);
    if (point.board > 0) {
      const double heading = bundle.boards[static_cast<std::size_t>(point.board)].heading_rad;
      const Eigen::Vector2d spun = Eigen::Rotation2Dd(heading + M_PI / 2) * point.on_board_m;
      Eigen::Matrix3d sheet_by_board = Eigen::Matrix3d::Zero();
      sheet_by_board(0, 0) = sheet_by_board(1, 1) = 1;
      sheet_by_board.topRightCorner<2, 1>() = spun;
      sheet_by_board.row(2) = bundle.bend.Slope(flat).transpose() * sheet_by_board.topRows<2>();
      by.board = projected->by_point * rotation * sheet_by_board;
      by.board_column = kBeforeBoards + 3 * (point.board - 1);
    }
    Eigen::Matrix<double, 2, 6> by_pose;
    by_pose.leftCols<3>() = projected->by_point;
    Eigen::Matrix3d cross;
    cross << 0, turned.z(), -turned.y(), -turned.z(), 0, turned.x(), turned.y(), -turned.x(), 0;
    by_pose.rightCols<3>() = projected->by_point * cross;
    const double limit = options.robust_px, weight = limit > 0 && distance > limit ? limit / distance : 1;
    AddPoint(by, by_pose, residual, weight, equations, view);
  }
  equations.shared_gradient += view.shared_gradient;
}

Equations Assemble(std::span<const LensView> views, const Bundle& bundle, const BundleOptions& options) {
  Equations equations;
  const int count = SharedCount(bundle);
  equations.shared = Eigen::MatrixXd::Zero(count, count);
  equations.shared_gradient = Eigen::VectorXd::Zero(count);
  equations.views.resize(views.size());
  equations.shared.diagonal().segment<kBend>(kLens).setConstant(kBendWeight);
  equations.shared_gradient.segment<kBend>(kLens) = kBendWeight * bundle.bend.curvature;
  for (std::size_t v = 0; v < views.size(); ++v) AddView(views[v], bundle, v, options, equations);
  equations.shared.triangularView<Eigen::StrictlyLower>() = equations.shared.transpose();
  equations.cost = Cost(views, bundle, options.robust_px);
  return equations;
}

/// What is left for the shared unknowns when each pose follows them.
struct Reduced {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd gradient;
};

Matrix6d Damped(const Matrix6d& matrix, double damping) {
  Matrix6d damped = matrix;
  damped.diagonal() += damping * matrix.diagonal() + Vector6d::Constant(1e-12);
  return damped;
}

Reduced Reduce(const Equations& equations, double damping) {
  Reduced reduced{equations.shared, equations.shared_gradient};
  reduced.matrix.diagonal() +=
      damping * equations.shared.diagonal() + Eigen::VectorXd::Constant(equations.shared.rows(), 1e-12);
  for (const ViewEquations& view : equations.views) {
    const Poses6 solved = SmallCholesky<6>(Damped(view.pose, damping)).SolveEach(view.pose_by_shared);
    reduced.matrix.noalias() -= view.pose_by_shared.transpose() * solved;
    reduced.gradient.noalias() -= solved.transpose() * view.pose_gradient;
  }
  return reduced;
}

Bundle Moved(const Bundle& bundle, const Equations& equations, const Eigen::VectorXd& shared, double damping) {
  Bundle moved = bundle;
  const int lens_count = LensParameterCount(bundle.camera.kind);
  for (int i = 0; i < lens_count; ++i) LensParameter(moved.camera, i) += shared[i];
  moved.bend.curvature += shared.segment<kBend>(kLens);
  for (std::size_t board = 1; board < moved.boards.size(); ++board) {
    const Eigen::Index column = kBeforeBoards + 3 * (static_cast<Eigen::Index>(board) - 1);
    moved.boards[board].position_m += shared.segment<2>(column);
    moved.boards[board].heading_rad += shared[column + 2];
  }
  for (std::size_t v = 0; v < moved.camera_from_sheet.size(); ++v) {
    const ViewEquations& view = equations.views[v];
    const Vector6d step =
        -SmallCholesky<6>(Damped(view.pose, damping)).Solve(view.pose_gradient + view.pose_by_shared * shared);
    RigidTransform& pose = moved.camera_from_sheet[v];
    pose.translation += step.head<3>();
    pose.rotation = (RotationFromVector(step.tail<3>()) * pose.rotation).normalized();
  }
  return moved;
}

bool IsSane(const Bundle& bundle) {
  const CameraModel& c = bundle.camera;
  return c.fx > 0 && c.fy > 0 && std::isfinite(c.fx + c.fy + c.cx + c.cy) &&
         std::all_of(c.distortion.begin(), c.distortion.end(), [](double k) { return std::isfinite(k); });
}

/// The cluster-robust ("sandwich") estimate (Liang and Zeger 1986), views being the clusters.
Eigen::MatrixXd CovarianceOfLens(std::span<const LensView> views, const Bundle& bundle, bool bends) {
  const int lens_count = LensParameterCount(bundle.camera.kind);
  const Equations equations = Assemble(views, bundle, {.bends = bends});
  const Reduced reduced = Reduce(equations, 0);
  const Eigen::MatrixXd inverse =
      reduced.matrix.ldlt().solve(Eigen::MatrixXd::Identity(reduced.matrix.rows(), reduced.matrix.cols()));
  Eigen::MatrixXd meat = Eigen::MatrixXd::Zero(inverse.rows(), inverse.cols());
  for (const ViewEquations& view : equations.views) {
    const Eigen::VectorXd gradient =
        view.shared_gradient -
        view.pose_by_shared.transpose() * SmallCholesky<6>(Damped(view.pose, 0)).Solve(view.pose_gradient);
    meat += gradient * gradient.transpose();
  }
  // What is usual of the bend is an observation, too.
  if (bends) meat.diagonal().segment<kBend>(kLens).array() += kUsualNoisePx * kUsualNoisePx * kBendWeight;
  // Each view's gradient has been fitted away in part: the usual correction for few clusters.
  const double count = static_cast<double>(views.size()), unknowns = static_cast<double>(lens_count);
  const double correction = count / std::max(count - unknowns, 1.0);
  return (correction * inverse * meat * inverse).topLeftCorner(lens_count, lens_count);
}

}  // namespace

std::optional<Eigen::Vector2d> PredictPixel(const Bundle& bundle, std::size_t view, const SeenPoint& point) {
  const Eigen::Vector3d x = bundle.camera_from_sheet[view] * OnSheet(bundle, point);
  if (!(x.z() > 1e-6)) return std::nullopt;
  return bundle.camera.Project(x);
}

BundleFit FitBundle(std::span<const LensView> views, const BundleOptions& options, Bundle& bundle) {
  BundleFit fit;
  double damping = 1e-3;
  Equations equations = Assemble(views, bundle, options);
  for (int pass = 0; pass < options.max_passes && !fit.converged; ++pass) {
    const Reduced reduced = Reduce(equations, damping);
    const Eigen::VectorXd step = -reduced.matrix.ldlt().solve(reduced.gradient);
    Bundle moved;
    double cost = 0;
    bool better = step.allFinite();
    if (better) {
      moved = Moved(bundle, equations, step, damping);
      better = IsSane(moved);
    }
    if (better) {
      cost = Cost(views, moved, options.robust_px);
      better = cost <= equations.cost;
    }
    if (!better) {
      damping = std::max(damping * 8, 1e-6);
      // No step of any length helps: this is the bottom.
      fit.converged = damping > 1e8;
      continue;
    }
    fit.converged = equations.cost - cost <= 1e-9 * equations.cost;
    bundle = std::move(moved);
    damping = damping > 1e-9 ? damping / 6 : damping;
    equations = Assemble(views, bundle, options);
  }
  fit.rms_px = std::sqrt(equations.square / std::max<double>(1, static_cast<double>(equations.points)));
  fit.lens_covariance = CovarianceOfLens(views, bundle, options.bends);
  return fit;
}

}  // namespace chequer
