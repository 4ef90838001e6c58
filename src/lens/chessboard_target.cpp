#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "detect/common/plane.h"
#include "lens/bounded_search.h"
#include "lens/edge_width.h"
#include "lens/lens_target.h"

namespace chequer {
namespace {

/// Half a window, as a share of the distance to the nearest corner.
constexpr double kWindow = 0.4;
/// A chessboard is found within a second in 12 megapixels; clutter can keep the search busy for minutes.
constexpr std::chrono::seconds kMostTime{4};

class ChessboardTarget final : public LensTarget {
 public:
  explicit ChessboardTarget(const Chessboard& chessboard) : chessboard_(chessboard) {}

  LensView Read(const ImageView& image) override {
    LensView view;
    BuildDetectionPlane(image, plane_);
    const auto searched = Find();
    view.gave_up = !searched;
    if (!searched || searched->empty()) return view;
    const std::vector<cv::Point2f>& found = *searched;
    std::vector<std::optional<Eigen::Vector2d>> corners;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const Eigen::Vector2d pixel =
          Eigen::Vector2d(found[i].x, found[i].y) + Eigen::Vector2d::Constant(plane_.offset_px);
      corners.emplace_back(pixel);
      const int col = static_cast<int>(i) % chessboard_.cols, row = static_cast<int>(i) / chessboard_.cols;
      view.points.push_back({0, {col * chessboard_.square_m, -row * chessboard_.square_m}, pixel});
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
    auto corners = SearchWithin(kMostTime, [&] {
      std::vector<cv::Point2f> found;
      const int how = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
      return cv::findChessboardCorners(grey, size, found, how) ? found : std::vector<cv::Point2f>();
    });
    if (corners && !corners->empty()) Refine(grey, *corners);
    return corners;
  }

  /// Each corner with as large a window as holds no other: more edge, less noise.
  void Refine(const cv::Mat& grey, std::vector<cv::Point2f>& corners) const {
    const std::vector<cv::Point2f> found = corners;
    std::vector<cv::Point2f> one(1);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const int half = std::clamp(static_cast<int>(kWindow * ToNearest(found, static_cast<int>(i))), 2, 11);
      one[0] = found[i];
      cv::cornerSubPix(grey, one, {half, half}, {-1, -1}, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 60, 1e-4});
      corners[i] = one[0];
    }
  }

  /// Distance of the nearest neighbour of a corner, pixels.
  double ToNearest(const std::vector<cv::Point2f>& corners, int i) const {
    double least = 1e9;
    const int row = i / chessboard_.cols, col = i % chessboard_.cols;
    const auto look = [&](int r, int c) {
      if (r < 0 || c < 0 || r >= chessboard_.rows || c >= chessboard_.cols) return;
      const cv::Point2f d =
          corners[static_cast<std::size_t>(r * chessboard_.cols + c)] - corners[static_cast<std::size_t>(i)];
      least = std::min(least, std::hypot(double{d.x}, double{d.y}));
    };
    look(row - 1, col);
    look(row + 1, col);
    look(row, col - 1);
    look(row, col + 1);
    return least;
  }

  Chessboard chessboard_;
  DetectionPlane plane_;
};

}  // namespace

std::unique_ptr<LensTarget> MakeChessboardTarget(const Chessboard& chessboard) {
  return std::make_unique<ChessboardTarget>(chessboard);
}

}  // namespace chequer
