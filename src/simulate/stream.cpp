#include "simulate/stream.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "simulate/moving_background.h"
#include "simulate/random.h"
#include "simulate/robots.h"

namespace chequer {
namespace {

/// Distance of two instants of an exposure along a board's way, pixels: a mean over instants a quarter of a pixel apart
/// differs from the mean over all by less than the noise of any sensor.
constexpr double kInstantPx = 0.25;
constexpr double kAtRestPx = 0.02;

/// What a camera sees of a marker at some instants of an exposure: the corners, and how far they move.
double MotionPx(const SceneMarker& marker, const std::vector<RigidTransform>& poses, const CameraModel& camera) {
  double longest = 0;
  for (const int row : {0, marker.board.rows})
    for (const int col : {0, marker.board.cols}) {
      double way = 0;
      const Eigen::Vector3d corner = marker.PointAt(col, row);
      for (std::size_t i = 1; i < poses.size(); ++i)
        way += (camera.Project(poses[i] * corner) - camera.Project(poses[i - 1] * corner)).norm();
      longest = std::max(longest, way);
    }
  return longest;
}

/// Shares of a board that lie in the image, and that are seen.
void SetShares(const SceneMarker& marker, const CameraModel& camera, TrueMarker& truth) {
  constexpr int kSteps = 24;
  int inside = 0, visible = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const Eigen::Array2d at((j + 0.5) / kSteps, (i + 0.5) / kSteps);
      const Eigen::Vector2d pixel = camera.Project(
          marker.camera_from_marker * marker.PointAt(at.x() * marker.board.cols, at.y() * marker.board.rows));
      if (!(pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width - 0.5 &&
            pixel.y() < camera.height - 0.5))
        continue;
      ++inside;
      visible += std::none_of(marker.occluders.begin(), marker.occluders.end(), [&](const Occluder& hand) {
        return (at >= hand.from.array()).all() && (at <= hand.to.array()).all();
      });
    }
  truth.inside = static_cast<double>(inside) / (kSteps * kSteps);
  truth.visible = static_cast<double>(visible) / (kSteps * kSteps);
}

/// By how much later than its middle row a frame's row is exposed.
double RowLaterS(const CameraModel& camera, double row) {
  return camera.rows_read_ms / 1000 * ((row + 0.5) / camera.height - 0.5);
}

void Flicker(const FramePlan& plan, const CameraModel& camera, LinearImage& light) {
  if (plan.flicker.amplitude == 0) return;
  for (int y = 0; y < light.height; ++y) {
    const auto factor = static_cast<float>(plan.flicker.At(RowLaterS(camera, y)));
    float* row = light.Pixel(0, y);
    for (int i = 0; i < 3 * light.width; ++i) row[i] *= factor;
  }
}

}  // namespace

struct Stream::Impl {
  explicit Impl(Scenario given)
      : scenario(std::move(given)),
        options(Checked(scenario.camera.render)),
        plans(PlanStream(scenario)),
        robots(scenario),
        spread(options.blur_sigma_px),
        background(scenario.camera.background, options.camera, plans, spread) {}

  const CameraModel& camera() const { return options.camera; }

  /// At a share of a frame's exposure, so much later than the middle row's. A camera that is shaken stands still from
  /// row to row.
  RigidTransform PoseAt(const FramePlan& plan, std::size_t robot, double share, double later_s) const {
    const RigidTransform level = robots.PoseAt(robot, plan.time_s + later_s + (share - 0.5) * plan.exposure_s);
    const RigidTransform turned{plan.CameraAt(share), Eigen::Vector3d::Zero()};
    return turned * level;
  }

  /// The row in which a robot's middle is exposed.
  double MiddleRow(const FramePlan& plan, std::size_t robot) const {
    double row = 0.5 * camera().height;
    if (camera().rows_read_ms == 0) return row;
    constexpr int kRounds = 5;  // as where outlines are drawn
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::Vector3d middle = PoseAt(plan, robot, 0.5, RowLaterS(camera(), row)).translation;
      if (middle.z() > 0) row = std::clamp(camera().Project(middle).y(), 0.0, camera().height - 1.0);
    }
    return row;
  }
  double LaterS(const FramePlan& plan, std::size_t robot) const { return RowLaterS(camera(), MiddleRow(plan, robot)); }

  MotionByRow ByRow(const FramePlan& plan, std::size_t robot) const {
    MotionByRow by_row;
    if (camera().rows_read_ms == 0) return by_row;
    by_row.row = MiddleRow(plan, robot);
    constexpr double kRows = 20;  // about as many as a board has
    const RigidTransform before = PoseAt(plan, robot, 0.5, RowLaterS(camera(), by_row.row - kRows)),
                         after = PoseAt(plan, robot, 0.5, RowLaterS(camera(), by_row.row + kRows));
    by_row.step = (after.translation - before.translation) / (2 * kRows);
    by_row.turn = VectorFromRotation((after.rotation * before.rotation.conjugate()).normalized()) / (2 * kRows);
    return by_row;
  }

  /// The mean over a frame's exposure: what a picture can show. Where a robot brakes, it is some micrometres from the
  /// pose at the exposure's middle, which is more than the error of a large board.
  RigidTransform MeanPose(const FramePlan& plan, std::size_t robot) const {
    constexpr int kInstants = 16;
    const double later_s = LaterS(plan, robot);
    const Eigen::Quaterniond middle = PoseAt(plan, robot, 0.5, later_s).rotation;
    Eigen::Vector3d position(0, 0, 0), turned(0, 0, 0);
    for (int i = 0; i < kInstants; ++i) {
      const RigidTransform pose = PoseAt(plan, robot, (i + 0.5) / kInstants, later_s);
      position += pose.translation / kInstants;
      turned += VectorFromRotation(pose.rotation * middle.conjugate()) / kInstants;
    }
    return {Canonical(RotationFromVector(turned) * middle), position};
  }

  SceneMarker MarkerAt(const FramePlan& plan, std::size_t robot) const {
    SceneMarker marker = robots.Marker(robot);
    marker.camera_from_marker = MeanPose(plan, robot);
    if (!plan.hands.empty() && plan.hands[robot]) marker.occluders.push_back(*plan.hands[robot]);
    return marker;
  }

  double MotionOf(const FramePlan& plan, const SceneMarker& marker, std::size_t robot) const {
    std::vector<RigidTransform> poses;
    const double later_s = LaterS(plan, robot);
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) poses.push_back(PoseAt(plan, robot, share, later_s));
    return MotionPx(marker, poses, camera());
  }

  std::vector<MovingMarker> MovingMarkers(const FramePlan& plan) const {
    std::vector<MovingMarker> moving;
    for (std::size_t robot = 0; robot < robots.size(); ++robot) {
      SceneMarker marker = MarkerAt(plan, robot);
      if (!IsDrawable(marker, camera())) continue;
      const double motion_px = MotionOf(plan, marker, robot);
      const int instants = motion_px < kAtRestPx ? 1 : std::max(4, static_cast<int>(std::ceil(motion_px / kInstantPx)));
      MovingMarker entry{std::move(marker), {}, ByRow(plan, robot)};
      const double later_s = LaterS(plan, robot);
      for (int i = 0; i < instants; ++i)
        entry.camera_from_marker.push_back(PoseAt(plan, robot, (i + 0.5) / instants, later_s));
      moving.push_back(std::move(entry));
    }
    return moving;
  }

  RenderOptions OptionsOf(const FramePlan& plan) const {
    RenderOptions frame = options;
    const double longer = plan.exposure_s * 1000 / scenario.camera.exposure_ms;
    frame.sensor.exposure *= plan.light * longer * plan.gain;
    frame.sensor.full_well_electrons = std::max(1.0, frame.sensor.full_well_electrons / plan.gain);
    return frame;
  }

  Scenario scenario;
  RenderOptions options;
  std::vector<FramePlan> plans;
  Robots robots;
  PointSpread spread;
  MovingBackground background;
};

Stream::Stream(Scenario scenario) : impl_(std::make_unique<Impl>(std::move(scenario))) {}
Stream::~Stream() = default;
Stream::Stream(Stream&&) noexcept = default;

std::size_t Stream::size() const { return impl_->plans.size(); }
const Scenario& Stream::scenario() const { return impl_->scenario; }
const FramePlan& Stream::plan(std::size_t index) const { return impl_->plans.at(index); }

FrameTruth Stream::Truth(std::size_t index) const {
  const FramePlan& plan = impl_->plans.at(index);
  FrameTruth truth;
  truth.phase = impl_->scenario.phases[plan.phase].name;
  truth.time_s = plan.time_s;
  for (std::size_t robot = 0; robot < impl_->robots.size(); ++robot) {
    const SceneMarker marker = impl_->MarkerAt(plan, robot);
    if (!IsDrawable(marker, impl_->camera())) continue;
    TrueMarker entry = Describe(marker, impl_->camera());
    SetShares(marker, impl_->camera(), entry);
    entry.motion_px = impl_->MotionOf(plan, marker, robot);
    if (entry.inside > 0) truth.markers.push_back(std::move(entry));
  }
  return truth;
}

LinearImage Stream::Light(std::size_t index) const {
  const FramePlan& plan = impl_->plans.at(index);
  SeenBackground seen = impl_->background.At(plan);
  DrawLayers(*seen.drawn, impl_->background.rim(), MakeMovingLayers(impl_->MovingMarkers(plan), impl_->camera()),
             impl_->spread, plan.shadow, seen.light);
  Flicker(plan, impl_->camera(), seen.light);
  return std::move(seen.light);
}

RenderOptions Stream::CameraOf(std::size_t index) const { return impl_->OptionsOf(impl_->plans.at(index)); }

Image Stream::Draw(std::size_t index, std::uint64_t round) const {
  return Capture(Light(index), CameraOf(index), DeriveSeed(DeriveSeed(impl_->scenario.seed, 1 + index), round));
}

}  // namespace chequer
