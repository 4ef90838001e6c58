#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/image.h"
#include "simulate/cast_shadow.h"
#include "simulate/lens.h"
#include "simulate/processing.h"
#include "simulate/scene.h"
#include "simulate/sensor.h"

namespace chequer {

/// A camera, from its lens to the bytes it delivers.
struct RenderOptions {
  CameraModel camera{.width = 640, .height = 480, .fx = 540.5, .fy = 540.5, .cx = 319.5, .cy = 239.5};
  double blur_sigma_px = 0.6;   ///< of the lens, Gaussian, 0..20
  double motion_px = 0;         ///< length of the camera's motion during the exposure, 0..200; poses hold at its middle
  double motion_angle_rad = 0;  ///< 0 right, π/2 down
  CastShadow shadow;            ///< on the scene; the lens blurs what it has shaded
  LightingOptions lighting;
  SensorOptions sensor;
  ProcessingOptions processing;  ///< not of Bayer formats
  ToneCurve tone_curve = ToneCurve::Srgb();
  PixelFormat format = PixelFormat::kBgr8;
  YuvRange yuv_range = YuvRange::kFull;  ///< of the YUV formats; planar JPEG YUV is always full
  /// Passes the image through JPEG of that quality, 1..100, and back. For BGR8, RGB8, Mono8 and planar YUV.
  std::optional<int> jpeg_quality;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};
/// The same options. Throws std::runtime_error with what Check() finds.
RenderOptions Checked(RenderOptions options);

/// Renders frames of scenes with one camera before one background, which is drawn once.
class Renderer {
 public:
  /// Throws std::runtime_error with the message of what Check() finds, or where the background's file cannot be read.
  Renderer(RenderOptions options, const Background& background);

  /// The frame in which `markers` stand before the renderer's background. The same arguments give the same bytes.
  /// Throws std::runtime_error with Scene::Check's message.
  Image Render(const std::vector<SceneMarker>& markers, std::uint64_t seed) const;

  const RenderOptions& options() const { return options_; }

 private:
  RenderOptions options_;
  PointSpread spread_;
  Background background_;
  int rim_;
  LinearImage drawn_;  ///< the background, larger than the frame by rim_ on each side
};

/// A background in a shadow. @param rim pixels by which it is larger than the image on each side.
LinearImage Shaded(LinearImage background, int rim, const CastShadow& shadow);

/// What the camera delivers of the light on its sensor: gradients, exposure, processing, conversion and coding.
/// @pre options.Check() is empty.
Image Capture(LinearImage light, const RenderOptions& options, std::uint64_t seed);

/// One frame of one scene: Renderer(options, scene.background).Render(scene.markers, seed).
Image Render(const Scene& scene, const RenderOptions& options, std::uint64_t seed);

/// The light on the sensor before gradients and exposure: what the frame is made of, for tests of geometry and energy.
/// Throws as Renderer does.
LinearImage RenderLight(const Scene& scene, const RenderOptions& options);

}  // namespace chequer
