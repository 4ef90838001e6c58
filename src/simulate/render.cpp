#include "simulate/render.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "capture/jpeg.h"
#include "simulate/coding.h"
#include "simulate/outline.h"
#include "simulate/random.h"

namespace chequer {
namespace {

void ThrowIf(const std::string& wrong) {
  if (!wrong.empty()) throw std::runtime_error(wrong);
}

bool IsPlanarYuv(PixelFormat format) {
  return format == PixelFormat::kYuv420p || format == PixelFormat::kYuv422p || format == PixelFormat::kYuv444p;
}

/// Cameras that stream JPEG store it as 4:2:2; files are mostly 4:2:0.
ChromaSharing ChromaOf(PixelFormat format) {
  if (format == PixelFormat::kYuv444p) return ChromaSharing::k444;
  return format == PixelFormat::kYuv422p ? ChromaSharing::k422 : ChromaSharing::k420;
}

/// @param background in the shadow.
LinearImage Light(const LinearImage& background, int rim, const std::vector<SceneMarker>& markers,
                  const RenderOptions& options, const PointSpread& spread) {
  LinearImage light = SeeThroughLens(background, rim, MakeLayers(markers, options.camera), spread, options.shadow);
  if (options.motion_px > 0) light = Smear(light, options.motion_px, options.motion_angle_rad);
  return light;
}

/// What a JPEG of the image holds, in the format asked for.
Image ThroughJpeg(const Image& image, int quality, const RenderOptions& options) {
  const auto jpeg = JpegFromImage(image.view(), {quality, ChromaOf(options.format)});
  const JpegColour colour = IsYuv(options.format) ? JpegColour::kYuv : JpegColour::kBgr;
  Image decoded = ImageFromJpeg(jpeg, colour, options.tone_curve);
  if (options.format == PixelFormat::kRgb8) return ConvertFromBgr(decoded.view(), PixelFormat::kRgb8);
  return decoded;
}

/// What the camera does after the sensor: conversion and coding.
Image Deliver(Image image, const RenderOptions& options) {
  if (options.jpeg_quality) return ThroughJpeg(image, *options.jpeg_quality, options);
  if (!IsYuv(options.format)) return image;
  const YuvRange range = IsPlanarYuv(options.format) ? YuvRange::kFull : options.yuv_range;
  return ConvertFromBgr(image.view(), options.format, range);
}

}  // namespace

RenderOptions Checked(RenderOptions options) {
  ThrowIf(options.Check());
  return options;
}

std::string RenderOptions::Check() const {
  if (camera.width < 1 || camera.height < 1 || camera.width > kMaxImageSide || camera.height > kMaxImageSide)
    return "the camera's width and height must be from 1 to " + std::to_string(kMaxImageSide);
  if (!SizeIsValid(format, camera.width, camera.height))
    return std::string(PixelFormatName(format)) + " needs an even width, NV12 also an even height";
  if (!(camera.fx > 0 && camera.fy > 0)) return "the camera's fx and fy must be above 0";
  if (!(blur_sigma_px >= 0 && blur_sigma_px <= 20)) return "blur_sigma_px must be from 0 to 20";
  if (!(motion_px >= 0 && motion_px <= 200)) return "motion_px must be from 0 to 200";
  if (jpeg_quality && (*jpeg_quality < 1 || *jpeg_quality > 100)) return "jpeg_quality must be from 1 to 100";
  if (jpeg_quality && (IsBayer(format) || (IsYuv(format) && !IsPlanarYuv(format))))
    return "JPEG holds BGR8, RGB8, Mono8, YUV420P, YUV422P or YUV444P, not " + std::string(PixelFormatName(format));
  if (IsBayer(format) && processing.any()) return "raw frames (Bayer) are not processed";
  if (std::string wrong = processing.Check(); !wrong.empty()) return wrong;
  if (std::string wrong = shadow.Check(); !wrong.empty()) return wrong;
  if (std::string wrong = lighting.Check(); !wrong.empty()) return wrong;
  return sensor.Check();
}

LinearImage Shaded(LinearImage background, int rim, const CastShadow& shadow) {
  if (shadow.takes == 0) return background;
  for (int y = 0; y < background.height; ++y)
    for (int x = 0; x < background.width; ++x) {
      const auto left = static_cast<float>(shadow.LightAt(x - rim, y - rim));
      for (int c = 0; c < 3; ++c) background.Pixel(x, y)[c] *= left;
    }
  return background;
}

Renderer::Renderer(RenderOptions options, const Background& background)
    : options_(Checked(std::move(options))),
      spread_(options_.blur_sigma_px),
      background_(background),
      rim_(spread_.reach()) {
  ThrowIf(background.Check());
  drawn_ = Shaded(DrawBackground(background, options_.camera.width + 2 * rim_, options_.camera.height + 2 * rim_), rim_,
                  options_.shadow);
}

Image Renderer::Render(const std::vector<SceneMarker>& markers, std::uint64_t seed) const {
  ThrowIf(Scene{markers, background_}.Check());
  return Capture(Light(drawn_, rim_, markers, options_, spread_), options_, seed);
}

Image Capture(LinearImage light, const RenderOptions& options, std::uint64_t seed) {
  const ProcessingOptions& processing = options.processing;
  const int width = light.width, height = light.height;
  if (processing.chromatic_aberration_px > 0) light = WithChromaticAberration(light, processing.chromatic_aberration_px);
  Illuminate(light, options.lighting);
  const PixelFormat captured = IsYuv(options.format) ? PixelFormat::kBgr8 : options.format;
  if (!processing.any())
    return Deliver(Expose(light, options.sensor, captured, options.tone_curve, seed), options);
  if (processing.upscaling > 1) {
    const auto fewer = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(pixels / processing.upscaling))); };
    light = Reduced(light, fewer(width), fewer(height));
  }
  const Image exposed = Expose(light, options.sensor, captured, options.tone_curve, seed, processing);
  return Deliver(Processed(exposed, processing, width, height), options);
}

Image Render(const Scene& scene, const RenderOptions& options, std::uint64_t seed) {
  return Renderer(options, scene.background).Render(scene.markers, seed);
}

LinearImage RenderLight(const Scene& scene, const RenderOptions& options) {
  ThrowIf(options.Check());
  ThrowIf(scene.Check());
  const PointSpread spread(options.blur_sigma_px);
  const int rim = spread.reach();
  LinearImage background =
      DrawBackground(scene.background, options.camera.width + 2 * rim, options.camera.height + 2 * rim);
  return Light(Shaded(std::move(background), rim, options.shadow), rim, scene.markers, options, spread);
}

}  // namespace chequer
