#include "tools/plan_estimate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "simulate/pose_bound.h"
#include "simulate/random.h"
#include "tools/marker_options.h"

namespace chequer {
namespace {

/// The bound takes fifty renderings a marker.
constexpr int kBoundTrials = 4;
/// Below that nearly none is read; between it and kSafeCellPx some are.
constexpr double kLeastCellPx = 3.5;
/// An ambiguous pose that is farther off took the other one.
constexpr double kMirroredRad = 0.035;

int LongerSide(const MarkerCode& code) { return std::max(code.size().rows, code.size().cols); }

/// Where the optical axis goes on, in units of the plane z = 1, the image's rims at their middles.
Eigen::Vector2d SeenAtOne(const CameraModel& camera) {
  const auto at = [&](double x, double y) { return camera.Undistort({x, y}).value_or(Eigen::Vector2d::Zero()); };
  const double right = camera.width - 0.5, bottom = camera.height - 0.5;
  return {at(right, camera.cy).x() - at(-0.5, camera.cy).x(), at(camera.cx, bottom).y() - at(camera.cx, -0.5).y()};
}

/// A marker before a camera that sees what is around it alone: the same lens, a smaller image.
struct PlanTrial {
  SceneMarker marker;
  RenderOptions view;
};

/// Cuts the camera's image down to a square around a pixel.
CameraModel WindowAround(const CameraModel& camera, const Eigen::Vector2d& center_px, double reach_px) {
  CameraModel window = camera;
  const int x = static_cast<int>(center_px.x() - reach_px), y = static_cast<int>(center_px.y() - reach_px);
  window.width = window.height = static_cast<int>(2 * reach_px);
  window.cx -= x;
  window.cy -= y;
  return window;
}

/// The board with its margin and some of what is around it, pixels from its centre.
double ReachPx(const PlanScene& scene) {
  const double side_px = scene.side_m / scene.distance_m * std::max(scene.view.camera.fx, scene.view.camera.fy);
  return 0.5 * std::sqrt(2.0) * side_px * (1 + 2.0 / LongerSide(scene.code)) + 16;
}

/// Somewhere in the image, whole.
PlanTrial MakePlanTrial(const PlanScene& scene, Random& random) {
  const CameraModel& camera = scene.view.camera;
  const double rim = ReachPx(scene);
  const auto place = [&](double length) {
    const double free = std::max(length - 2 * rim, 0.0);
    return 0.5 * (length - 1) + free * random.Uniform(-0.5, 0.5);
  };
  const Eigen::Vector2d pixel(place(camera.width), place(camera.height));
  const Eigen::Vector2d ray = camera.Undistort(pixel).value_or(Eigen::Vector2d::Zero());
  PlanTrial trial;
  trial.marker.board = MakeBoard(scene.code, random.Bits() % (scene.code.max_id() + 1));
  trial.marker.side_m = scene.side_m;
  trial.marker.margin_cells = 1;
  const Eigen::Vector3d position = scene.distance_m * Eigen::Vector3d(ray.x(), ray.y(), 1);
  const double heading = random.Uniform(0, 2 * M_PI), tilt = random.Uniform(0, scene.max_tilt_rad);
  trial.marker.camera_from_marker = FacingPose(position, heading, tilt, random.Uniform(0, 2 * M_PI));
  trial.view = scene.view;
  trial.view.camera = WindowAround(camera, camera.Distort(ray), rim);
  return trial;
}

/// Sums of squared errors.
struct ErrorSquares {
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), angle = Eigen::Vector3d::Zero();
  int count = 0;

  void Add(const Eigen::Vector3d& position_squared, const Eigen::Vector3d& angle_squared) {
    position += position_squared;
    angle += angle_squared;
    ++count;
  }
  Eigen::Vector3d RmsOf(const Eigen::Vector3d& sum) const { return (sum / std::max(count, 1)).cwiseSqrt(); }
};

Eigen::Vector3d RotationBetween(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  const Eigen::AngleAxisd turn(to * from.conjugate());
  return std::remainder(turn.angle(), 2 * M_PI) * turn.axis();
}

void CountTrial(const PlanTrial& trial, const std::vector<MarkerPose>& found, PlanEstimate& estimate,
                ErrorSquares& errors) {
  const RigidTransform& truth = trial.marker.camera_from_marker;
  for (const MarkerPose& marker : found) {
    if (!marker.id) continue;
    if (*marker.id != trial.marker.board.id) {
      ++estimate.wrong;
      continue;
    }
    ++estimate.read;
    const Eigen::Vector3d turn = RotationBetween(marker.camera_from_marker.rotation, truth.rotation);
    if (marker.Has(Warning::kAmbiguous) && turn.norm() > kMirroredRad) {
      ++estimate.mirrored;
      return;
    }
    const Eigen::Vector3d off = marker.camera_from_marker.translation - truth.translation;
    errors.Add(off.cwiseAbs2(), turn.cwiseAbs2());
    return;
  }
}

void RunTrials(const PlanScene& scene, PlanEstimate& estimate) {
  Random random(scene.seed);
  ErrorSquares errors, bounds;
  for (; estimate.trials < scene.trials; ++estimate.trials) {
    const PlanTrial trial = MakePlanTrial(scene, random);
    const Image image = Render(Scene{{trial.marker}, {}}, trial.view, DeriveSeed(scene.seed, random.Bits()));
    DetectorOptions options;
    options.families = {{.code = scene.code, .side_m = scene.side_m, .roster = {}}};
    options.camera = trial.view.camera;
    Detector detector(options);
    CountTrial(trial, detector.Detect(image.view()), estimate, errors);
    if (estimate.trials >= kBoundTrials) continue;
    const Eigen::Matrix<double, 6, 1> least = PoseBound(trial.marker, trial.view).diagonal();
    bounds.Add(least.head<3>(), least.tail<3>());
  }
  estimate.error_m = errors.RmsOf(errors.position);
  estimate.error_rad = errors.RmsOf(errors.angle);
  estimate.bound_m = bounds.RmsOf(bounds.position);
  estimate.bound_rad = bounds.RmsOf(bounds.angle);
}

}  // namespace

PlanVerdict PlanEstimate::Verdict() const {
  if (!fits || cell_px < kLeastCellPx || 2 * read < trials) return PlanVerdict::kNotRead;
  return cell_px < kSafeCellPx || read < trials ? PlanVerdict::kDoubtful : PlanVerdict::kRead;
}

PlanEstimate EstimatePlan(const PlanScene& scene) {
  const CameraModel& camera = scene.view.camera;
  const double focal_px = std::min(camera.fx, camera.fy), cell_m = scene.side_m / LongerSide(scene.code);
  PlanEstimate estimate;
  estimate.cell_px = focal_px * cell_m / scene.distance_m;
  estimate.seen_m = scene.distance_m * SeenAtOne(camera);
  estimate.smallest_side_m = kSafeCellPx / focal_px * scene.distance_m * LongerSide(scene.code);
  estimate.farthest_m = focal_px * cell_m / kSafeCellPx;
  // Turned at random, a board needs its diagonal.
  estimate.fits = std::sqrt(2.0) * scene.side_m < estimate.seen_m.minCoeff();
  if (estimate.fits) RunTrials(scene, estimate);
  return estimate;
}

Image RenderPlanned(const PlanScene& scene) {
  Random random(scene.seed);
  PlanTrial trial = MakePlanTrial(scene, random);
  trial.view.format = PixelFormat::kBgr8;
  return Render(Scene{{trial.marker}, {}}, trial.view, scene.seed);
}

}  // namespace chequer
