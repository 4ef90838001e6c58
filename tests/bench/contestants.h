#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/frames.h"
#include "bench/peer.h"
#include "bench/score.h"

namespace chequer::bench {

/// A detector in the race, with one thread, made for one suite.
class Contestant {
 public:
  virtual ~Contestant() = default;

  virtual std::string name() const = 0;
  /// What it reads.
  virtual Pattern pattern() const = 0;
  /// Whether it takes that frame (a raw one, say, has to be there).
  virtual bool Takes(const BenchFrame&) const { return true; }
  /// Before each Detect, untimed. @param first whether the frame is another than the last Detect's; the frames of a
  ///   stream come in their order.
  virtual void Prepare(bool /*first*/) {}
  /// The part that is timed: from the frame in memory to what was found in it.
  virtual void Detect(const BenchFrame& frame) = 0;
  /// What the last Detect found, with poses. Poses that Detect did not yield by itself are made here, untimed.
  virtual std::vector<Detection> Detections() = 0;
};

/// This detector from colour and from raw frames; poses are part of what is timed.
std::unique_ptr<Contestant> MakeChequer(const Suite& suite, bool bayer);

/// The same with a memory of the frames before: each repetition of a frame begins with the one that the frame before
/// has left. @pre suite.interval is not 0.
std::unique_ptr<Contestant> MakeChequerOfStream(const Suite& suite, bool bayer);

/// AprilTag 3, family 36h11; the grey conversion is timed, the pose is not. With `linear`, the grey image goes through
/// a table that undoes sRGB's curve, which is timed too: coded values move the edges of its square outwards, most of
/// its depth error on such frames.
std::unique_ptr<Contestant> MakeAprilTag(const Suite& suite, float quad_decimate, bool linear);

/// OpenCV's ArUco, DICT_4X4_1000; the grey conversion is timed, the pose is not. Without refinement it is
/// quickest, with its sub-pixel refinement poses are better.
std::unique_ptr<Contestant> MakeAruco(const Suite& suite, bool refine);

/// A detector from a shared library; the grey conversion is timed, the pose is not. The peer outlives it. Throws
/// std::runtime_error where it makes no detector for the suite's frames.
std::unique_ptr<Contestant> MakePeer(const Suite& suite, const Peer& peer);

/// Pose of a square of that side from its corners: top left, top right, bottom right, bottom left. Shared by the peers.
RigidTransform PoseOfSquare(std::span<const Eigen::Vector2d> corners_px, double side_m, const CameraModel& camera);

}  // namespace chequer::bench
