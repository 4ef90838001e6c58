extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

#include <array>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>

#include "bench/contestants.h"
#include "bench/grey.h"
#include "chequer/tone_curve.h"

namespace chequer::bench {
namespace {

struct DestroyDetector {
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
};
struct DestroyFamily {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
};
struct DestroyDetections {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

class AprilTagContestant final : public Contestant {
 public:
  AprilTagContestant(const Suite& suite, float quad_decimate, bool linear)
      : decimate_(quad_decimate),
        linear_(linear),
        side_m_(suite.side_m),
        camera_(suite.camera),
        family_(tag36h11_create()),
        detector_(apriltag_detector_create()) {
    apriltag_detector_add_family(detector_.get(), family_.get());
    detector_->nthreads = 1;
    detector_->quad_decimate = quad_decimate;
    const std::array<float, 256> table = ToneCurve::Srgb().LinearTable();
    for (std::size_t i = 0; i < table.size(); ++i) table_[i] = static_cast<std::uint8_t>(std::lround(255 * table[i]));
  }

  std::string name() const override {
    return "AprilTag d" + std::to_string(static_cast<int>(decimate_)) + (linear_ ? " lin" : "");
  }
  Pattern pattern() const override { return kAprilTagPattern; }

  void Detect(const BenchFrame& frame) override {
    ConvertToGrey(frame.colour, grey_);
    if (linear_) cv::LUT(grey_, cv::Mat(1, 256, CV_8U, table_.data()), grey_);
    image_u8_t image{grey_.cols, grey_.rows, static_cast<int>(grey_.step), grey_.data};
    found_.reset(apriltag_detector_detect(detector_.get(), &image));
  }

  std::vector<Detection> Detections() override {
    std::vector<Detection> detections;
    for (int i = 0; i < zarray_size(found_.get()); ++i) {
      apriltag_detection_t* found = nullptr;
      zarray_get(found_.get(), i, &found);
      // The library starts at the bottom left and goes round against the clock.
      std::array<Eigen::Vector2d, 4> corners;
      for (std::size_t corner = 0; corner < corners.size(); ++corner) {
        const double* p = found->p[3 - corner];
        corners[corner] = {p[0] - kPixelCenter, p[1] - kPixelCenter};
      }
      detections.push_back({static_cast<std::uint64_t>(found->id), PoseOfSquare(corners, side_m_, camera_)});
    }
    return detections;
  }

 private:
  /// Where the library has the centre of the top-left pixel.
  static constexpr double kPixelCenter = 0.5;

  float decimate_;
  bool linear_;
  std::array<std::uint8_t, 256> table_{};  ///< sRGB's curve undone: light, in 8 bits
  double side_m_;
  CameraModel camera_;
  std::unique_ptr<apriltag_family_t, DestroyFamily> family_;
  std::unique_ptr<apriltag_detector_t, DestroyDetector> detector_;
  std::unique_ptr<zarray_t, DestroyDetections> found_;
  cv::Mat grey_;
};

}  // namespace

std::unique_ptr<Contestant> MakeAprilTag(const Suite& suite, float quad_decimate, bool linear) {
  return std::make_unique<AprilTagContestant>(suite, quad_decimate, linear);
}

}  // namespace chequer::bench
