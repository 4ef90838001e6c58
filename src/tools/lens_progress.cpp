#include "tools/lens_progress.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>
#include <vector>

namespace chequer {
namespace {

/// A calibration of fewer views seldom exists (CalibrateLens needs some that are tilted).
constexpr std::size_t kFewestViews = 6;
/// A fit goes over all views: one for each quarter more of them costs a bounded multiple of the last one.
constexpr std::size_t kFitAgainAt = 4;

std::optional<LensCalibration> TryToFit(const std::vector<LensView>& views, const LensCalibrationOptions& options) {
  try {
    return CalibrateLens(views, options);
  } catch (const std::runtime_error&) {
    return std::nullopt;  // these views do not determine the lens yet
  }
}

}  // namespace

void LensProgress::TakeCoverage(const ViewCollector& collector) {
  message_.kind = CalibrationMessage::Kind::kLens;
  message_.width = collector.options().width;
  message_.height = collector.options().height;
  message_.frames = static_cast<int>(collector.offered());
  message_.views = static_cast<int>(collector.views().size());
  message_.tilted = collector.tilted();
  message_.rows = Coverage::kRows;
  message_.cols = Coverage::kCols;
  message_.parts.clear();
  for (int row = 0; row < Coverage::kRows; ++row)
    for (int col = 0; col < Coverage::kCols; ++col) message_.parts.push_back(collector.coverage().CountAt(col, row));
}

void LensProgress::TakeResiduals(const LensCalibration& calibration) {
  message_.rms = calibration.record.rms_px;
  message_.residuals.clear();
  const std::size_t every = calibration.residuals.size() / kMostCalibrationResiduals + 1;
  for (std::size_t i = 0; i < calibration.residuals.size(); i += every) {
    const LensResidual& residual = calibration.residuals[i];
    message_.residuals.push_back({residual.pixel.cast<float>(), residual.error_px.cast<float>()});
  }
}

void LensProgress::FitSoFar(const ViewCollector& collector) {
  if (fit_.valid()) {
    if (fit_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    if (const Fit fit = fit_.get()) TakeResiduals(*fit);
  }
  const std::size_t views = collector.views().size();
  if (views < std::max(kFewestViews, fitted_views_ + fitted_views_ / kFitAgainAt)) return;
  if (views == fitted_views_) return;
  fitted_views_ = views;
  const LensCalibrationOptions options{message_.width, message_.height, kind_};
  fit_ = std::async(std::launch::async, [all = collector.views(), options] { return TryToFit(all, options); });
}

void LensProgress::Look(const ViewCollector& collector, double edge_px, const std::string& advice) {
  if (!watch_.IsDue()) return;
  TakeCoverage(collector);
  FitSoFar(collector);
  message_.edge_px = edge_px;
  message_.advice = advice;
  watch_.Send(message_);
}

void LensProgress::Solve(const ViewCollector& collector) {
  if (!watch_.IsWatched()) return;
  TakeCoverage(collector);
  message_.state = CalibrationMessage::State::kSolving;
  message_.advice = "the lens is being calculated";
  watch_.Send(message_);
}

void LensProgress::Finish(const ViewCollector& collector, const LensCalibration& calibration) {
  if (!watch_.IsWatched()) return;
  TakeCoverage(collector);
  TakeResiduals(calibration);
  message_.state = CalibrationMessage::State::kDone;
  const std::string lacking = collector.Lacking();
  message_.advice = lacking.empty() ? "enough" : "more views would make it more exact: " + lacking;
  watch_.Send(message_);
}

void LensProgress::Fail(const std::string& why) {
  if (!watch_.IsWatched()) return;
  message_.state = CalibrationMessage::State::kFailed;
  message_.advice = why;
  watch_.Send(message_);
}

}  // namespace chequer
