#include "world/drift_monitor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "core/length.h"
#include "core/number_text.h"

namespace chequer {
namespace {

/// A reference that has moved is taken to be back below this share of the limit, so that noise about the limit is told
/// once.
constexpr double kBack = 0.7;
/// Most that one frame counts, times the limit: with kMostShare, one wild pose in a row of good ones warns of nothing.
constexpr double kMostOffset = 3;
/// Most that one frame counts in the average, however long the frames are apart.
constexpr double kMostShare = 0.2;
/// Distances that are off by less may be the poses' noise, or a lens that was focused anew.
constexpr double kLeastWrongScale = 0.03;
/// References that look nearer by one cause do so by the same factor: most spread of its logarithm, as a share of it.
constexpr double kMostScaleSpread = 0.25;
/// Share of the average that frames have filled, before its scale is believed.
constexpr double kLeastWeight = 0.3;
/// Fewer may have been lifted.
constexpr std::size_t kFewestScaled = 2;

std::array<Eigen::Vector3d, 4> OuterCorners(const WorldReference& reference) {
  const double cell = reference.side_m / std::max(reference.size.rows, reference.size.cols);
  const double x = 0.5 * cell * reference.size.cols, y = 0.5 * cell * reference.size.rows;
  return {{{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}}};
}

/// How far a board's outer corners lie beside where they are expected, across the line of sight, root mean square.
/// Along it, poses are too noisy to tell.
double OffsetAcrossSight(const WorldReference& reference, const RigidTransform& expected, const RigidTransform& seen) {
  double square = 0;
  for (const Eigen::Vector3d& corner : OuterCorners(reference)) {
    const Eigen::Vector3d sight = (seen * corner).normalized(), point = expected * corner;
    square += (point - sight * sight.dot(point)).squaredNorm() / 4;
  }
  return std::sqrt(square);
}

std::string Millimetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f mm", metres * 1000);
  return text.data();
}

}  // namespace

std::string DriftOptions::Check() const {
  if (!(limit_m >= 0.0001 && limit_m <= 10)) return "the drift limit must be from 0.0001 to 10 m";
  if (window.count() < 1) return "the drift window must be at least 1 ms";
  return "";
}

DriftMonitor::DriftMonitor(WorldCalibration world, DriftOptions options)
    : world_(std::move(world)), camera_from_world_(world_.world_from_camera.Inverse()), options_(options) {
  if (const std::string wrong = options_.Check(); !wrong.empty()) throw std::runtime_error(wrong);
  for (const WorldReference& reference : world_.references) drifts_.push_back({.id = reference.id});
  last_seen_.resize(drifts_.size());
  scale_weights_.resize(drifts_.size());
}

std::optional<std::string> DriftMonitor::Take(std::span<const MarkerPose> markers, MonotonicTime captured) {
  for (const MarkerPose& marker : markers) {
    if (!marker.id || !marker.has_pose) continue;
    for (std::size_t i = 0; i < world_.references.size(); ++i) {
      const WorldReference& reference = world_.references[i];
      if (reference.id != *marker.id || !(reference.size == marker.size) || reference.variant != marker.variant)
        continue;
      Average(i, Measure(reference, marker.camera_from_marker), captured);
    }
  }
  return Judge(captured);
}

DriftMonitor::Sample DriftMonitor::Measure(const WorldReference& reference, const RigidTransform& seen) const {
  const RigidTransform expected = camera_from_world_ * reference.world_from_marker;
  const double was_m = expected.translation.norm(), is_m = seen.translation.norm();
  if (!(was_m > 0 && is_m > 0)) return {};
  return {OffsetAcrossSight(reference, expected, seen), std::log(is_m / was_m),
          (seen.translation * (was_m / is_m) - expected.translation).norm()};
}

void DriftMonitor::Average(std::size_t reference, const Sample& sample, MonotonicTime captured) {
  const std::chrono::duration<double> window = options_.window;
  // The first frame counts as one of many: the monitor starts from "all is well".
  const std::chrono::duration<double> since =
      last_seen_[reference] ? captured - *last_seen_[reference] : std::chrono::duration<double>(0);
  const double share = std::clamp(1 - std::exp(-since / window), 0.0, kMostShare);
  ReferenceDrift& drift = drifts_[reference];
  const double most_m = kMostOffset * options_.limit_m;
  drift.offset_m += share * (std::min(sample.offset_m, most_m) - drift.offset_m);
  // From its first frame on the mean of what was seen: a warning names it.
  double& weight = scale_weights_[reference];
  weight += share * (1 - weight);
  if (weight > 0) {
    drift.beside_m += share / weight * (std::min(sample.beside_m, most_m) - drift.beside_m);
    drift.farther_log += share / weight * (std::clamp(sample.farther_log, -1.0, 1.0) - drift.farther_log);
  }
  last_seen_[reference] = captured;
}

std::optional<std::string> DriftMonitor::Judge(MonotonicTime now) {
  std::vector<std::size_t> moved;
  std::size_t in_view = 0;
  for (std::size_t i = 0; i < drifts_.size(); ++i) {
    ReferenceDrift& drift = drifts_[i];
    drift.in_view = last_seen_[i] && now - *last_seen_[i] <= options_.window;
    drift.has_moved = drift.offset_m > (drift.has_moved ? kBack : 1.0) * options_.limit_m;
    if (!drift.in_view) continue;
    ++in_view;
    if (drift.has_moved) moved.push_back(i);
  }
  // Where none is in view nothing is known, so nothing has changed.
  const double scale = CommonScale();
  const bool has_wrong_side = scale != 1;
  if (in_view == 0 || (moved == moved_ && has_wrong_side == has_wrong_side_)) return std::nullopt;
  const bool said_so = has_wrong_side && has_wrong_side_;
  moved_ = std::move(moved);
  has_wrong_side_ = has_wrong_side;
  // With a wrong side they seem to move, too, the farther from the middle of their board: that says nothing more.
  if (said_so) return std::nullopt;
  if (has_wrong_side_) return SideWarning(scale);
  if (moved_.empty()) return "all world references in view are where they were when the world was set";
  return Warning();
}

double DriftMonitor::CommonScale() const {
  double sum = 0, least = 0, most = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < drifts_.size(); ++i) {
    const ReferenceDrift& drift = drifts_[i];
    // A wild pose or two in the first frames say nothing.
    if (!drift.in_view || scale_weights_[i] < kLeastWeight) continue;
    if (drift.beside_m > options_.limit_m) return 1;
    least = count == 0 ? drift.farther_log : std::min(least, drift.farther_log);
    most = count == 0 ? drift.farther_log : std::max(most, drift.farther_log);
    sum += drift.farther_log;
    ++count;
  }
  if (count < kFewestScaled) return 1;
  const double mean = sum / static_cast<double>(count);
  const double needed = std::log1p(kLeastWrongScale) * (has_wrong_side_ ? kBack : 1.0);
  return std::abs(mean) < needed || most - least > kMostScaleSpread * std::abs(mean) ? 1 : std::exp(mean);
}

std::string DriftMonitor::SideWarning(double scale) const {
  const auto seen = std::find_if(drifts_.begin(), drifts_.end(), [](const auto& drift) { return drift.in_view; });
  const double side_m = world_.references[static_cast<std::size_t>(seen - drifts_.begin())].side_m;
  std::array<char, 32> times{};
  std::snprintf(times.data(), times.size(), "%.2f", scale);
  return std::string("the side of the markers is wrong: all world references in view look ") + times.data() +
         " times as far away as when the world was set, each in its old direction, so nothing moved; prints of " +
         LengthText(side_m / scale) + ", not of " + LengthText(side_m) +
         " as in the world file, would look so: measure one, correct the side, and run chequer calibrate world again";
}

std::string DriftMonitor::Warning() const {
  std::string who;
  for (const std::size_t i : moved_)
    who.append(who.empty() ? "" : ", ") += std::to_string(drifts_[i].id) + " by " + Millimetres(drifts_[i].offset_m);
  const auto in_view = static_cast<std::size_t>(
      std::count_if(drifts_.begin(), drifts_.end(), [](const ReferenceDrift& drift) { return drift.in_view; }));
  std::string text = "world references have moved since the world was set: " + who + "; ";
  if (moved_.size() == in_view && in_view > 1)
    return text + "all that are in view, so the camera was moved: run chequer calibrate world again";
  if (moved_.size() == in_view) {
    const double scale = std::exp(drifts_[moved_.front()].farther_log);
    return text + "it is the only one in view, so it or the camera was moved" +
           (std::abs(std::log(scale)) > std::log1p(kLeastWrongScale)
                ? ", or, as it looks " + RoundText(scale, 2) + " times as far away, the side of the markers is wrong"
                : "") +
           ": put it back, or run chequer calibrate world again";
  }
  return text + std::to_string(in_view - moved_.size()) + " of " + std::to_string(in_view) +
         " in view are where they were: put the others back, or run chequer calibrate world again";
}

}  // namespace chequer
