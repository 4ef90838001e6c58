#include "bench/contestants.h"
#include "chequer/detector.h"

namespace chequer::bench {
namespace {

DetectorOptions OptionsFor(const Suite& suite) {
  DetectorOptions options;
  options.families = {MarkerFamily{MarkerCode(MarkerSize{6, 6}, Variant::kSecded), suite.side_m, {}}};
  options.camera = suite.camera;
  options.threads = 1;
  return options;
}

class ChequerContestant : public Contestant {
 public:
  ChequerContestant(const Suite& suite, bool bayer) : bayer_(bayer), detector_(OptionsFor(suite)) {}

  std::string name() const override { return bayer_ ? "chequer Bayer" : "chequer BGR"; }
  Pattern pattern() const override { return kChequerPattern; }
  bool Takes(const BenchFrame& frame) const override { return !bayer_ || frame.bayer.has_value(); }
  void Detect(const BenchFrame& frame) override { detector_.Detect(ViewOf(frame), markers_); }
  std::vector<Detection> Detections() override {
    std::vector<Detection> detections;
    for (const MarkerPose& marker : markers_) detections.push_back({marker.id, marker.camera_from_marker});
    return detections;
  }

 protected:
  ImageView ViewOf(const BenchFrame& frame) const { return bayer_ ? frame.bayer->view() : frame.colour.view(); }

  bool bayer_;
  Detector detector_;
  std::vector<MarkerPose> markers_;
};

/// With a memory.
class StreamContestant final : public ChequerContestant {
 public:
  StreamContestant(const Suite& suite, bool bayer) : ChequerContestant(suite, bayer), interval_(suite.interval) {}

  std::string name() const override { return bayer_ ? "chequer stream Bayer" : "chequer stream BGR"; }
  void Prepare(bool first) override {
    if (first) {
      before_ = memory_;
      captured_ += interval_;
    } else {
      memory_ = before_;
    }
  }
  void Detect(const BenchFrame& frame) override { detector_.Detect(ViewOf(frame), captured_, memory_, markers_); }

 private:
  std::chrono::nanoseconds interval_, captured_{0};
  DetectorMemory before_, memory_;  ///< as they were before the frame, and after it
};

}  // namespace

std::unique_ptr<Contestant> MakeChequer(const Suite& suite, bool bayer) {
  return std::make_unique<ChequerContestant>(suite, bayer);
}

std::unique_ptr<Contestant> MakeChequerOfStream(const Suite& suite, bool bayer) {
  return std::make_unique<StreamContestant>(suite, bayer);
}

}  // namespace chequer::bench
