#include "synthetic_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "chequer/geometry.h"
#include "simulate/random.h"
#include "simulate/scene.h"

namespace chequer::test {

CameraModel TypicalCamera(CameraModel::Kind kind) {
  CameraModel camera{.width = 1280, .height = 960, .fx = 1003, .fy = 1007, .cx = 652, .cy = 470};
  camera.kind = kind;
  if (kind == CameraModel::Kind::kBrownConrady) camera.distortion = {-0.24, 0.09, 0.0007, -0.0004, -0.015};
  if (kind == CameraModel::Kind::kFisheye) {
    camera.fx = 520;
    camera.fy = 522;
    camera.distortion = {-0.02, 0.004, -0.001, 0.0002, 0};
  }
  return camera;
}

std::vector<LensView> MakeViews(const ViewPlan& plan) {
  Random random(plan.seed);
  const double pitch = plan.board_side_m * 1.4, cell = plan.board_side_m / 6;
  const Eigen::Vector2d middle(pitch * (plan.board_columns - 1) / 2, pitch * (plan.board_rows - 1) / 2);
  std::vector<LensView> views;
  while (static_cast<int>(views.size()) < plan.count) {
    const auto aim =
        plan.camera.Undistort({random.Uniform(0, plan.camera.width), random.Uniform(0, plan.camera.height)});
    if (!aim) continue;
    // So far away that the sheet fills about a third of a 1000 px frame, nearer and farther.
    const double distance = pitch * plan.board_columns * plan.camera.fx / plan.camera.width * random.Uniform(1.2, 2.5);
    const double axis = random.Uniform(0, 2 * M_PI), tilt = random.Uniform(0.2, 1) * plan.max_tilt_rad;
    RigidTransform camera_from_sheet;
    camera_from_sheet.rotation = RotationFromVector(tilt * Eigen::Vector3d(std::cos(axis), std::sin(axis), 0)) *
                                 RotationFromVector({M_PI, 0, 0}) *
                                 RotationFromVector({0, 0, random.Uniform(0, 2 * M_PI)});
    camera_from_sheet.translation = distance * Eigen::Vector3d(aim->x(), aim->y(), 1).normalized();
    LensView view;
    view.name = "view " + std::to_string(views.size());
    for (int board = 0; board < plan.board_columns * plan.board_rows; ++board) {
      const Eigen::Vector2d at(pitch * (board % plan.board_columns), pitch * (board / plan.board_columns));
      for (int i = 0; i < 25; ++i) {
        const Eigen::Vector2d on_board(cell * (i % 5 - 2), cell * (2 - i / 5));
        // Glued on by hand: each a little turned.
        const Eigen::Vector2d on_sheet = at - middle + Eigen::Rotation2Dd(0.02 * board) * on_board;
        const Eigen::Vector3d x = camera_from_sheet * OnBentPaper(on_sheet, plan.bend_per_m, M_PI / 4).translation;
        if (x.z() < 0.02) continue;
        const Eigen::Vector2d normalized = x.head<2>() / x.z();
        const Eigen::Vector2d pixel = plan.camera.Distort(normalized);
        const bool inside =
            pixel.x() > 2 && pixel.y() > 2 && pixel.x() < plan.camera.width - 3 && pixel.y() < plan.camera.height - 3;
        const auto back = plan.camera.Undistort(pixel);
        if (!inside || !back || (*back - normalized).norm() > 1e-6) continue;
        const float noise_y = random.Normal(), noise_x = random.Normal();  // one by one: arguments have no order
        view.points.push_back({board, on_board, pixel + plan.noise_px * Eigen::Vector2d(noise_x, noise_y)});
      }
    }
    if (view.points.size() >=
        std::min<std::size_t>(40, 25 * static_cast<std::size_t>(plan.board_columns * plan.board_rows)))
      views.push_back(std::move(view));
  }
  return views;
}

}  // namespace chequer::test
