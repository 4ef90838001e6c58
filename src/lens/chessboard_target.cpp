#include <algorithm>
#include <chrono>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "core/median.h"
#include "detect/toolbox.h"
#include "lens/bounded_search.h"
#include "lens/crossing_fit.h"
#include "lens/edge_width.h"
#include "lens/lens_target.h"

namespace chequer {
namespace {

/// Radius of the pixels that a corner is fitted to, as a share of the distance to the nearest corner. What lies beyond
/// is left to the blur of the next edges. Measured on photographs: .4 to .7 are alike to 1 %.
constexpr double kRadius = 0.6;
/// More pixels take longer and tell little: the lens bends edges that long.
constexpr double kMostRadiusPx = 25;
/// A corner lies this near the middle of its neighbours, as a share of their distance, if all are where they should be:
/// perspective and lenses move it by less. A guess.
constexpr double kOnItsPlace = 0.15;
/// Times the median misfit of a view: something covers the corner, or shines on it. A guess.
constexpr double kMostMisfit = 4;
/// A chessboard is found within a second in 12 megapixels; clutter can keep the search busy for minutes.
constexpr std::chrono::seconds kMostTime{4};

/// Corners as the search has them, and what they say of each other.
class CornerGrid {
 public:
  CornerGrid(const std::vector<cv::Point2f>& corners, int rows, int cols)
      : corners_(corners), rows_(rows), cols_(cols) {}

  Eigen::Vector2d At(int row, int col) const {
    const cv::Point2f& at = corners_[static_cast<std::size_t>(row * cols_ + col)];
    return {at.x, at.y};
  }

  /// Where the search has a corner, with the directions to its neighbours.
  CrossingStart StartOf(int row, int col) const {
    const Eigen::Vector2d along = At(row, std::min(col + 1, cols_ - 1)) - At(row, std::max(col - 1, 0)),
                          down = At(std::min(row + 1, rows_ - 1), col) - At(std::max(row - 1, 0), col);
    return {At(row, col), along, down, std::min(kMostRadiusPx, kRadius * ToNearest(row, col))};
  }

  /// Where its neighbours have it.
  Eigen::Vector2d Expected(int row, int col) const {
    return (Between(row, col, 0, 1, col, cols_) + Between(row, col, 1, 0, row, rows_)) / 2;
  }

  /// Distance of the nearest neighbour, pixels.
  double ToNearest(int row, int col) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [down, right] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int r = row + down, c = col + right;
      if (r >= 0 && c >= 0 && r < rows_ && c < cols_) least = std::min(least, (At(r, c) - At(row, col)).norm());
    }
    return least;
  }

 private:
  /// The middle of the neighbours on both sides; at a rim, on from the two on the one side. Itself where there are
  /// none.
  Eigen::Vector2d Between(int row, int col, int down, int right, int at, int count) const {
    const auto neighbour = [&](int steps) { return At(row + steps * down, col + steps * right); };
    if (at > 0 && at + 1 < count) return (neighbour(-1) + neighbour(1)) / 2;
    if (count < 3) return At(row, col);
    return at == 0 ? 2 * neighbour(1) - neighbour(2) : 2 * neighbour(-1) - neighbour(-2);
  }

  const std::vector<cv::Point2f>& corners_;
  int rows_, cols_;
};

class ChessboardTarget final : public LensTarget {
 public:
  explicit ChessboardTarget(const Chessboard& chessboard) : chessboard_(chessboard) {}

  LensView Read(const ImageView& image) override {
    LensView view;
    BuildDetectionPlane(image, plane_);
    const auto searched = Find();
    view.gave_up = !searched;
    if (!searched || searched->empty()) return view;
    std::vector<std::optional<Eigen::Vector2d>> corners = Fit(*searched);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (!corners[i]) continue;
      *corners[i] += Eigen::Vector2d::Constant(plane_.offset_px);
      const int col = static_cast<int>(i) % chessboard_.cols, row = static_cast<int>(i) / chessboard_.cols;
      view.points.push_back({0, {col * chessboard_.square_m, -row * chessboard_.square_m}, *corners[i]});
    }
    view.edge_px = EdgeWidthPx(plane_, corners, chessboard_.rows, chessboard_.cols);
    return view;
  }

  void SetCamera(const CameraModel&) override {}
  bool WantsCamera() const override { return false; }

 private:
  /// Row by row; empty where the board is not seen whole. Nothing where it took too long.
  std::optional<std::vector<cv::Point2f>> Find() {
    BytePlane& plane = plane_.plane;
    if (plane.width() < 16 || plane.height() < 16) return std::vector<cv::Point2f>();
    const cv::Mat grey(plane.height(), plane.width(), CV_8UC1, plane.row(0), static_cast<std::size_t>(plane.stride()));
    const cv::Size size(chessboard_.cols, chessboard_.rows);
    return SearchWithin(kMostTime, [&] {
      std::vector<cv::Point2f> found;
      const int how = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
      return cv::findChessboardCorners(grey, size, found, how) ? found : std::vector<cv::Point2f>();
    });
  }

  /// Fits every corner; empty where the pixels show none, or hardly one.
  std::vector<std::optional<Eigen::Vector2d>> Fit(const std::vector<cv::Point2f>& found) const {
    const CornerGrid grid(found, chessboard_.rows, chessboard_.cols);
    std::vector<std::optional<Crossing>> crossings;
    std::vector<double> misfits;
    for (int row = 0; row < chessboard_.rows; ++row)
      for (int col = 0; col < chessboard_.cols; ++col) {
        crossings.push_back(FitCorner(grid, row, col));
        if (crossings.back()) misfits.push_back(crossings.back()->misfit);
      }
    const double most = kMostMisfit * Median(misfits);
    std::vector<std::optional<Eigen::Vector2d>> corners;
    for (const auto& crossing : crossings)
      corners.push_back(crossing && crossing->misfit <= most ? std::optional(crossing->at) : std::nullopt);
    return corners;
  }

  /// From where the search has a corner; where its neighbours have it elsewhere, from there, too: the search can be off
  /// by some pixels where cells are small and blurred.
  std::optional<Crossing> FitCorner(const CornerGrid& grid, int row, int col) const {
    CrossingStart start = grid.StartOf(row, col);
    const Eigen::Vector2d expected = grid.Expected(row, col);
    const std::optional<Crossing> there = FitCrossing(plane_.plane, start);
    if (there && (there->at - expected).norm() <= kOnItsPlace * grid.ToNearest(row, col)) return there;
    start.at = expected;
    const std::optional<Crossing> beside = FitCrossing(plane_.plane, start);
    return !there || (beside && beside->misfit < there->misfit) ? beside : there;
  }

  Chessboard chessboard_;
  DetectionPlane plane_;
};

}  // namespace

std::unique_ptr<LensTarget> MakeChessboardTarget(const Chessboard& chessboard) {
  return std::make_unique<ChessboardTarget>(chessboard);
}

}  // namespace chequer
