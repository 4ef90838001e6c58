#pragma once

#include <cstddef>
#include <future>
#include <optional>
#include <string>

#include "lens/calibrate_lens.h"
#include "lens/view_collector.h"
#include "tools/calibration_watch.h"

namespace chequer {

/// Shows the calibration of a lens while it runs (CalibrationWatch): coverage, what is still lacking, and, as views
/// come, the residuals of a calibration from those there are. That is fitted in a thread of its own, and only while
/// somebody looks: frames do not wait for it.
class LensProgress {
 public:
  LensProgress(const std::optional<CameraSetup>& setup, CameraModel::Kind kind) : watch_(setup), kind_(kind) {}

  /// After each frame. @param advice what to do next.
  void Look(const ViewCollector& collector, double edge_px, const std::string& advice);
  /// All views are there.
  void Solve(const ViewCollector& collector);
  void Finish(const ViewCollector& collector, const LensCalibration& calibration);
  void Fail(const std::string& why);

 private:
  using Fit = std::optional<LensCalibration>;

  void FitSoFar(const ViewCollector& collector);
  void TakeResiduals(const LensCalibration& calibration);
  void TakeCoverage(const ViewCollector& collector);

  CalibrationWatch watch_;
  CameraModel::Kind kind_;
  CalibrationMessage message_;
  std::size_t fitted_views_ = 0;
  std::future<Fit> fit_;
};

}  // namespace chequer
