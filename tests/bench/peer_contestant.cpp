#include <algorithm>
#include <memory>
#include <stdexcept>

#include "bench/contestants.h"
#include "bench/grey.h"

namespace chequer::bench {
namespace {

class PeerContestant final : public Contestant {
 public:
  PeerContestant(const Suite& suite, const Peer& peer)
      : plugin_(peer.plugin()),
        side_m_(suite.side_m),
        camera_(suite.camera),
        detector_(plugin_.create(suite.camera.width, suite.camera.height), plugin_.destroy) {
    if (!detector_) throw std::runtime_error(peer.name() + ": makes no detector for the frames of " + suite.name);
  }

  std::string name() const override { return plugin_.name; }
  Pattern pattern() const override { return plugin_.pattern; }

  void Detect(const BenchFrame& frame) override {
    ConvertToGrey(frame.colour, grey_);
    const int found = plugin_.detect(detector_.get(), grey_.data, grey_.step, markers_.data(), kCapacity);
    count_ = static_cast<std::size_t>(std::clamp(found, 0, kCapacity));
  }

  std::vector<Detection> Detections() override {
    std::vector<Detection> detections;
    for (std::size_t i = 0; i < count_; ++i) {
      std::array<Eigen::Vector2d, 4> corners;
      for (std::size_t corner = 0; corner < corners.size(); ++corner)
        corners[corner] = {markers_[i].corners_px[corner][0], markers_[i].corners_px[corner][1]};
      detections.push_back({static_cast<std::uint64_t>(markers_[i].id), PoseOfSquare(corners, side_m_, camera_)});
    }
    return detections;
  }

 private:
  /// More than any suite shows, with room for false ones.
  static constexpr int kCapacity = 4096;

  const ChequerPeer& plugin_;
  double side_m_;
  CameraModel camera_;
  std::unique_ptr<void, void (*)(void*)> detector_;
  cv::Mat grey_;
  std::vector<ChequerPeerMarker> markers_ = std::vector<ChequerPeerMarker>(kCapacity);
  std::size_t count_ = 0;
};

}  // namespace

std::unique_ptr<Contestant> MakePeer(const Suite& suite, const Peer& peer) {
  return std::make_unique<PeerContestant>(suite, peer);
}

}  // namespace chequer::bench
