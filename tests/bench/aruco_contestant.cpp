#include <array>
#include <opencv2/aruco.hpp>

#include "bench/contestants.h"
#include "bench/grey.h"

namespace chequer::bench {
namespace {

class ArucoContestant final : public Contestant {
 public:
  ArucoContestant(const Suite& suite, bool refine)
      : refine_(refine),
        side_m_(suite.side_m),
        camera_(suite.camera),
        dictionary_(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_1000)),
        parameters_(cv::aruco::DetectorParameters::create()) {
    if (refine) parameters_->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  }

  std::string name() const override { return refine_ ? "ArUco subpixel" : "ArUco"; }
  Pattern pattern() const override { return kArucoPattern; }

  void Detect(const BenchFrame& frame) override {
    ConvertToGrey(frame.colour, grey_);
    cv::aruco::detectMarkers(grey_, dictionary_, corners_, ids_, parameters_);
  }

  std::vector<Detection> Detections() override {
    std::vector<Detection> detections;
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      std::array<Eigen::Vector2d, 4> corners;
      for (std::size_t corner = 0; corner < corners.size(); ++corner) {
        corners[corner] = {static_cast<double>(corners_[i][corner].x), static_cast<double>(corners_[i][corner].y)};
      }
      detections.push_back({static_cast<std::uint64_t>(ids_[i]), PoseOfSquare(corners, side_m_, camera_)});
    }
    return detections;
  }

 private:
  bool refine_;
  double side_m_;
  CameraModel camera_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  cv::Mat grey_;
  std::vector<std::vector<cv::Point2f>> corners_;
  std::vector<int> ids_;
};

}  // namespace

std::unique_ptr<Contestant> MakeAruco(const Suite& suite, bool refine) {
  return std::make_unique<ArucoContestant>(suite, refine);
}

}  // namespace chequer::bench
