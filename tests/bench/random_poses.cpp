// One 50 mm marker at random poses, as FMAC's protocol has them: 0.5 to 1.5 m away, tilted by up to 45° about either
// axis, anywhere in a frame of 640 × 480. How exact poses are, how many are found, and how near errors are to the least
// that any estimate can have.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "simulate/pose_bound.h"
#include "simulate/random.h"
#include "simulate/render.h"

namespace chequer::bench {
namespace {

constexpr double kSideM = 0.05;

struct Setting {
  double focal_px = 990, least_m = 0.5, most_m = 1.5, tilt_deg = 45;
  /// Few bounds show no tail: of 200, none was of the steepest poses, which had most of the squared error.
  int poses = 5000, bounds = 1500;
  std::uint64_t seed = 1;
  bool missed = false;
};

/// A marker all of which, with its margin, lies in the frame.
SceneMarker MarkerOf(const Setting& setting, const MarkerCode& code, const CameraModel& camera, Random& random) {
  SceneMarker marker;
  marker.board = MakeBoard(code, random.Bits() % (code.max_id() + 1));
  marker.side_m = kSideM;
  marker.margin_cells = 1;
  const double most = setting.tilt_deg * std::numbers::pi / 180;
  const double z = random.Uniform(setting.least_m, setting.most_m), around = 0.75 * kSideM * camera.fx / z;
  const double u = random.Uniform(around, camera.width - around), v = random.Uniform(around, camera.height - around);
  const double heading = random.Uniform(0, 2 * std::numbers::pi), about_x = random.Uniform(-most, most),
               about_y = random.Uniform(-most, most);
  marker.camera_from_marker =
      FacingPose({(u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z}, heading, 0, 0);
  marker.camera_from_marker.rotation = Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                                       Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()) *
                                       marker.camera_from_marker.rotation;
  return marker;
}

void Run(const Setting& setting) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  RenderOptions render;
  render.camera = {
      .width = 640, .height = 480, .fx = setting.focal_px, .fy = setting.focal_px, .cx = 319.5, .cy = 239.5};
  DetectorOptions options;
  options.families = {{.code = code, .side_m = kSideM, .roster = {}}};
  options.camera = render.camera;
  Detector detector(options);
  int found = 0, read = 0, wrong = 0, ambiguous = 0, bounds = 0;
  Eigen::Vector3d square = Eigen::Vector3d::Zero(), bounded = Eigen::Vector3d::Zero(), bound = Eigen::Vector3d::Zero();
  double turn_bounded = 0, turn_bound = 0;
  std::vector<double> turns;
  std::vector<MarkerPose> poses;
  for (int i = 0; i < setting.poses; ++i) {
    Random random(DeriveSeed(setting.seed, static_cast<std::uint64_t>(i)));
    const SceneMarker marker = MarkerOf(setting, code, render.camera, random);
    const Image image = Render({.markers = {marker}, .background = {}}, render, random.Bits());
    DetectTrace trace;
    detector.Detect(image.view(), poses, setting.missed ? &trace : nullptr);
    const RigidTransform& truth = marker.camera_from_marker;
    if (poses.empty() || !poses[0].has_pose) {
      if (!setting.missed) continue;
      Refusal farthest = Refusal::kNone;
      for (const TraceCandidate& candidate : trace.candidates) farthest = std::max(farthest, candidate.refusal);
      const Eigen::Vector3d normal = truth.rotation * Eigen::Vector3d::UnitZ();
      fmt::print("  missed: {} at {:.2f} m, slant {:.0f} deg, {} corners: {}\n", i, truth.translation.z(),
                 std::acos(std::abs(normal.dot(truth.translation.normalized()))) * 180 / std::numbers::pi,
                 trace.corners.size(), RefusalName(farthest));
      continue;
    }
    ++found;
    const MarkerPose& pose = poses[0];
    if (pose.id) ++(*pose.id == marker.board.id ? read : wrong);
    ambiguous += pose.Has(Warning::kAmbiguous);
    const Eigen::Vector3d off = 1e3 * (pose.camera_from_marker.translation - truth.translation);
    const double turn =
        VectorFromRotation((truth.rotation * pose.camera_from_marker.rotation.conjugate()).normalized()).norm() * 180 /
        std::numbers::pi;
    square += off.cwiseAbs2();
    turns.push_back(turn);
    // Every so many poses: a bound takes far longer than a pose. The other of two poses is an error of its own kind.
    if (bounds >= setting.bounds || turn > 5) continue;
    ++bounds;
    const Matrix6d least = PoseBound(marker, render);
    bounded += off.cwiseAbs2();
    bound += 1e6 * least.diagonal().head<3>();
    turn_bounded += turn * turn;
    turn_bound += least.diagonal().tail<3>().sum() * std::pow(180 / std::numbers::pi, 2);
  }
  std::sort(turns.begin(), turns.end());
  const auto at = [&](double share) {
    return turns.empty()
               ? 0
               : turns[std::min(turns.size() - 1, static_cast<std::size_t>(share * static_cast<double>(turns.size())))];
  };
  const Eigen::Vector3d rms = (square / std::max(found, 1)).cwiseSqrt(),
                        over = bounded.cwiseQuotient(bound).cwiseSqrt();
  fmt::print("{} poses: found {:.2f} %, read {:.2f} %, {} wrong, {} ambiguous\n", setting.poses,
             100.0 * found / setting.poses, 100.0 * read / setting.poses, wrong, ambiguous);
  fmt::print("RMS x {:.3f} y {:.3f} z {:.3f} mm; rotation median {:.3f}, 99 % {:.3f}, 99.9 % {:.3f} deg\n", rms.x(),
             rms.y(), rms.z(), at(0.5), at(0.99), at(0.999));
  fmt::print("over the bound, of {}: x {:.2f} y {:.2f} z {:.2f} rotation {:.2f}\n", bounds, over.x(), over.y(),
             over.z(), std::sqrt(turn_bounded / turn_bound));
}

}  // namespace
}  // namespace chequer::bench

int main(int argc, char** argv) {
  CLI::App app("A 50 mm marker at random poses.");
  chequer::bench::Setting setting;
  app.add_option("--poses", setting.poses)->capture_default_str();
  app.add_option("--bounds", setting.bounds, "Poses whose errors are held against the least possible")
      ->capture_default_str();
  app.add_option("--seed", setting.seed)->capture_default_str();
  app.add_option("--focal", setting.focal_px, "Pixels")->capture_default_str();
  app.add_option("--tilt", setting.tilt_deg, "At most, about either axis, degrees")->capture_default_str();
  app.add_flag("--missed", setting.missed, "What became of each marker that was not found");
  CLI11_PARSE(app, argc, argv);
  chequer::bench::Run(setting);
}
