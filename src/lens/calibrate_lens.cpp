#include "lens/calibrate_lens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/lens_parameters.h"
#include "core/median.h"
#include "lens/bundle.h"
#include "lens/lens_start.h"

namespace chequer {
namespace {

constexpr std::size_t kFewestViews = 4;
constexpr std::size_t kFewestPoints = 8;
/// A view or a board in it is bad whose RMS is this many times the median one's and farther from it than kGoodPx: blur
/// and bent paper show as two and more, well-kept views differ by less.
constexpr double kBadRatio = 3;
constexpr double kGoodPx = 0.15;
constexpr int kMostRounds = 6;
/// A focal length known no better than that is not known.
constexpr double kMostFocalError = 0.03;
/// Points this far off on average are no calibration: the sheet is bent, or its boards are not fixed to it.
constexpr double kMostRmsPx = 3;

/// Views under calibration: what is still used of the views that were given.
struct Working {
  std::vector<LensView> views;
  std::vector<std::size_t> index;  ///< of each in the views that were given
  Bundle bundle;
};

/// Numbers the boards anew, the one seen in most views first: the others are placed by it.
void RenumberBoards(std::vector<LensView>& views) {
  std::map<int, int> seen;
  for (const LensView& view : views) {
    std::map<int, bool> here;
    for (const SeenPoint& point : view.points) here[point.board] = true;
    for (const auto& [board, yes] : here) ++seen[board];
  }
  std::vector<std::pair<int, int>> order(seen.begin(), seen.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::map<int, int> renumbered;
  for (std::size_t i = 0; i < order.size(); ++i) renumbered[order[i].first] = static_cast<int>(i);
  for (LensView& view : views)
    for (SeenPoint& point : view.points) point.board = renumbered[point.board];
}

/// Leaves out the views that show too little.
Working Gather(std::vector<LensView> views, LensCalibration& calibration) {
  RenumberBoards(views);
  Working working;
  for (std::size_t i = 0; i < views.size(); ++i) {
    calibration.views.push_back({.name = views[i].name, .why_not = ""});
    if (views[i].points.size() < kFewestPoints) {
      calibration.views[i].why_not =
          fmt::format("shows {} points, at least {} are needed", views[i].points.size(), kFewestPoints);
      continue;
    }
    working.views.push_back(std::move(views[i]));
    working.index.push_back(i);
  }
  return working;
}

void CheckEnoughViews(const Working& working, const char* left) {
  if (working.views.size() < kFewestViews)
    throw std::runtime_error(
        fmt::format("{} view{}{}; at least {} are needed, better 20, with the target in all parts "
                    "of the image and tilted",
                    working.views.size(), working.views.size() == 1 ? "" : "s", left, kFewestViews));
}

void Begin(Working& working, const LensCalibrationOptions& options, LensCalibration& calibration) {
  const auto start = StartBundle(working.views, options.width, options.height, options.kind);
  if (!start)
    throw std::runtime_error(
        "no lens explains the views: the markers must all be fixed to one flat sheet and have the side that was said; "
        "of markers that move one by one, say --loose");
  working.bundle = start->bundle;
  calibration.boards = static_cast<int>(start->placed.size());
  calibration.loose_boards = static_cast<int>(std::count(start->placed.begin(), start->placed.end(), false));
  for (LensView& view : working.views)
    std::erase_if(view.points,
                  [&](const SeenPoint& point) { return !start->placed[static_cast<std::size_t>(point.board)]; });
}

/// A board as one view shows it.
struct BoardView {
  std::size_t view = 0;
  int board = 0;
  double square = 0;
  std::size_t points = 0;
  double Rms() const { return std::sqrt(square / static_cast<double>(points)); }
};

std::vector<BoardView> BoardViews(const Working& working) {
  std::vector<BoardView> found;
  for (std::size_t v = 0; v < working.views.size(); ++v) {
    std::map<int, BoardView> here;
    for (const SeenPoint& point : working.views[v].points) {
      const auto pixel = PredictPixel(working.bundle, v, point);
      BoardView& board = here[point.board];
      board.view = v;
      board.board = point.board;
      board.square += pixel ? (*pixel - point.pixel).squaredNorm() : 1e6;
      ++board.points;
    }
    for (const auto& [number, board] : here) found.push_back(board);
  }
  return found;
}

double RmsOf(const Working& working, std::size_t view) {
  double square = 0;
  for (const SeenPoint& point : working.views[view].points) {
    const auto pixel = PredictPixel(working.bundle, view, point);
    square += pixel ? (*pixel - point.pixel).squaredNorm() : 1e6;
  }
  return std::sqrt(square / std::max<double>(1, static_cast<double>(working.views[view].points.size())));
}

/// Takes out boards of views that disagree; whether there were any.
bool DropBadBoards(Working& working) {
  const std::vector<BoardView> boards = BoardViews(working);
  std::vector<double> all;
  for (const BoardView& board : boards) all.push_back(board.Rms());
  const double limit = std::max(kBadRatio * Median(all), Median(all) + kGoodPx);
  bool dropped = false;
  for (const BoardView& board : boards) {
    if (board.Rms() <= limit) continue;
    dropped = true;
    std::erase_if(working.views[board.view].points, [&](const SeenPoint& point) { return point.board == board.board; });
  }
  return dropped;
}

void Erase(Working& working, std::size_t view) {
  const auto at = static_cast<std::ptrdiff_t>(view);
  working.views.erase(working.views.begin() + at);
  working.index.erase(working.index.begin() + at);
  working.bundle.camera_from_sheet.erase(working.bundle.camera_from_sheet.begin() + at);
}

/// Takes out views of which too little is left.
void DropEmptyViews(Working& working, LensCalibration& calibration, const std::vector<double>& rms_px) {
  for (std::size_t v = working.views.size(); v-- > 0;) {
    if (working.views[v].points.size() >= kFewestPoints) continue;
    CalibratedView& view = calibration.views[working.index[v]];
    view.rms_px = rms_px[v];
    view.why_not = fmt::format("does not fit the others: {:.2f} px off", rms_px[v]);
    Erase(working, v);
  }
}

std::vector<double> RmsOfViews(const Working& working) {
  std::vector<double> rms;
  for (std::size_t v = 0; v < working.views.size(); ++v) rms.push_back(RmsOf(working, v));
  return rms;
}

/// Fits with little weight on what is far off, leaves out what disagrees, and again, until nothing does.
BundleFit FitWithoutBadViews(Working& working, LensCalibration& calibration) {
  std::vector<double> rms = RmsOfViews(working);
  DropEmptyViews(working, calibration, rms);
  BundleFit fit;
  for (int round = 0; round < kMostRounds; ++round) {
    CheckEnoughViews(working, " agree");
    FitBundle(working.views, {.robust_px = std::max(0.1, 2 * Median(RmsOfViews(working)))}, working.bundle);
    rms = RmsOfViews(working);
    if (!DropBadBoards(working)) break;
    DropEmptyViews(working, calibration, rms);
  }
  CheckEnoughViews(working, " agree");
  // Views of something else than a flat sheet are gone: what is left tells how flat it is.
  return FitBundle(working.views, {.bends = true}, working.bundle);
}

void CheckResult(const BundleFit& fit, const CameraModel& camera) {
  if (fit.rms_px > kMostRmsPx)
    throw std::runtime_error(fmt::format(
        "the best lens leaves {:.1f} px; the sheet is not flat, its markers are not fixed to it, or the model is wrong "
        "(brown_conrady, fisheye)",
        fit.rms_px));
  const double error = std::sqrt(fit.lens_covariance(0, 0)) / camera.fx;
  if (!(error < kMostFocalError))
    throw std::runtime_error(fmt::format(
        "the focal length is known only to {:.0f} %: tilt the target against the camera, by 20 to 45 degrees, to all "
        "sides",
        std::min(error, 9.99) * 100));
}

void Report(const Working& working, const BundleFit& fit, LensCalibration& calibration) {
  calibration.camera = working.bundle.camera;
  const Eigen::Index count = fit.lens_covariance.rows();
  calibration.camera.covariance.topLeftCorner(count, count) =
      (fit.lens_covariance + fit.lens_covariance.transpose()) / 2;
  calibration.bend = working.bundle.bend;
  CalibrationRecord& record = calibration.record;
  record.rms_px = fit.rms_px;
  record.views = static_cast<int>(working.views.size());
  for (Eigen::Index i = 0; i < fit.lens_covariance.rows(); ++i)
    record.uncertainty[static_cast<std::size_t>(i)] = std::sqrt(std::max(fit.lens_covariance(i, i), 0.0));
  for (std::size_t v = 0; v < working.views.size(); ++v) {
    CalibratedView& view = calibration.views[working.index[v]];
    view.used = true;
    view.rms_px = RmsOf(working, v);
    for (const SeenPoint& point : working.views[v].points)
      if (const auto pixel = PredictPixel(working.bundle, v, point))
        calibration.residuals.push_back({point.pixel, point.pixel - *pixel});
  }
}

}  // namespace

LensCalibration CalibrateLens(const std::vector<LensView>& views, const LensCalibrationOptions& options) {
  LensCalibration calibration;
  Working working = Gather(views, calibration);
  CheckEnoughViews(working, " can be used");
  Begin(working, options, calibration);
  BundleFit fit = FitWithoutBadViews(working, calibration);
  calibration.print = FindPrintStretch(working.views, working.bundle, fit);
  if (calibration.print.matters()) {
    working.views = Stretched(working.views, calibration.print.stretch);
    fit = FitBundle(working.views, {.bends = true}, working.bundle);
  }
  CheckResult(fit, working.bundle.camera);
  Report(working, fit, calibration);
  return calibration;
}

}  // namespace chequer
