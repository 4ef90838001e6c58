#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "core/median.h"
#include "detect/toolbox.h"
#include "lens/edge_width.h"
#include "lens/lens_target.h"

namespace chequer {
namespace {

class MarkerTarget final : public LensTarget {
 public:
  MarkerTarget(std::vector<MarkerFamily> families, bool loose) : loose_(loose) {
    options_.families = std::move(families);
    detector_ = std::make_unique<Detector>(options_);
  }

  LensView Read(const ImageView& image) override {
    LensView view;
    std::vector<MarkerPose> markers = detector_->Detect(image);
    std::erase_if(markers, [](const MarkerPose& marker) { return !marker.id; });
    if (loose_ && markers.size() > 1) markers = {*std::max_element(markers.begin(), markers.end(), Smaller)};
    BuildDetectionPlane(image, plane_);
    std::vector<double> widths, flat;
    for (const MarkerPose& marker : markers) {
      AddPoints(marker, view);
      flat.push_back(marker.reprojection_rms_px);
      if (const double width = EdgeWidthOf(marker); width > 0) widths.push_back(width);
    }
    view.edge_px = Median(widths);
    view.flat_rms_px = Median(flat);
    return view;
  }

  void SetCamera(const CameraModel& camera) override {
    options_.camera = camera;
    detector_ = std::make_unique<Detector>(options_);
  }
  bool WantsCamera() const override { return true; }

 private:
  static double SpanPx(const MarkerPose& marker) {
    Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9f), high = -low;
    for (int i = 0; i < CornerCount(marker.size); ++i) {
      const Eigen::Vector2f& corner = marker.corners[static_cast<std::size_t>(i)];
      if (!corner.allFinite()) continue;
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    return (high - low).norm();
  }
  static bool Smaller(const MarkerPose& a, const MarkerPose& b) { return SpanPx(a) < SpanPx(b); }

  /// The same number for the same marker in all images.
  int BoardOf(const MarkerPose& marker) {
    // Loose ones are all of the same make, each alone in its view.
    if (loose_) return 0;
    const auto next = static_cast<int>(boards_.size());
    return boards_.try_emplace({marker.family, *marker.id}, next).first->second;
  }

  void AddPoints(const MarkerPose& marker, LensView& view) {
    const MarkerSize size = marker.size;
    const Eigen::Vector2d cell_m = options_.families[static_cast<std::size_t>(marker.family)].CellM();
    const int board = BoardOf(marker), cols = size.cols - 1;
    for (int i = 0; i < CornerCount(size); ++i) {
      const Eigen::Vector2f& corner = marker.corners[static_cast<std::size_t>(i)];
      if (!corner.allFinite()) continue;
      const Eigen::Vector2d on_board(cell_m.x() * (i % cols + 1 - 0.5 * size.cols),
                                     cell_m.y() * (0.5 * size.rows - (i / cols + 1)));
      view.points.push_back({board, on_board, corner.cast<double>()});
    }
  }

  double EdgeWidthOf(const MarkerPose& marker) const {
    std::vector<std::optional<Eigen::Vector2d>> corners;
    for (int i = 0; i < CornerCount(marker.size); ++i) {
      const Eigen::Vector2f& corner = marker.corners[static_cast<std::size_t>(i)];
      corners.push_back(corner.allFinite() ? std::optional<Eigen::Vector2d>(corner.cast<double>()) : std::nullopt);
    }
    return EdgeWidthPx(plane_, corners, marker.size.rows - 1, marker.size.cols - 1);
  }

  DetectorOptions options_;
  bool loose_;
  std::unique_ptr<Detector> detector_;
  DetectionPlane plane_;
  std::map<std::pair<int, std::uint64_t>, int> boards_;
};

}  // namespace

std::unique_ptr<LensTarget> MakeMarkerTarget(std::vector<MarkerFamily> families, bool loose) {
  return std::make_unique<MarkerTarget>(std::move(families), loose);
}

}  // namespace chequer
