#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/image.h"
#include "chequer/marker.h"
#include "simulate/render.h"
#include "simulate/truth.h"

// Frames for tests of what looks at frames. A test lists scenes.cpp among its sources and links chequer_simulate.

namespace chequer::test {

/// A frame with what is in it, and where.
struct KnownFrame {
  std::string name;  ///< says what is special about it, for messages
  Scene scene;
  RenderOptions options;
  std::uint64_t seed = 1;

  Image Draw() const { return Render(scene, options, seed); }
  std::vector<TrueMarker> Truth() const { return TruthOf(scene.markers, options.camera); }
};

/// A camera without distortion whose principal point is the middle of the frame.
CameraModel PlainCamera(int width = 640, int height = 480, double focal_px = 600);

/// A marker of that code.
SceneMarker MarkerOf(const MarkerCode& code, std::uint64_t id, const RigidTransform& camera_from_marker,
                     double side_m = 0.12);

/// One marker whose cells are `cell_px` pixels wide, near the middle of a plain grey frame of PlainCamera, lens blur
/// 0.6 px, little noise. Heading and the place within a pixel hang on the seed.
KnownFrame OneMarker(const MarkerCode& code, std::uint64_t id, double cell_px, std::uint64_t seed,
                     double tilt_rad = 0.15);

/// The inner corners row by row from the marker's top left, in pixels: what MarkerPose::corners should be.
std::vector<Eigen::Vector2d> InnerCorners(const SceneMarker& marker, const CameraModel& camera);

/// Frames without any marker, each kind of clutter in turn, some bright, some dark, some blurred, some noisy: whatever
/// is detected in them is wrong.
std::vector<KnownFrame> ClutterFrames(int count, std::uint64_t seed, int width = 640, int height = 480);

}  // namespace chequer::test
