#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "chequer/image.h"
#include "simulate/linear_image.h"

namespace chequer {

/// The curve of a camera's processor, where it is another than the one that the image states.
struct CameraCurve {
  enum class Kind : std::uint8_t {
    kStated,  ///< the image's own
    kBt709,   ///< ITU-R BT.709's transfer function
    kGamma,   ///< light to the power of 1 / amount
    kKnee,    ///< sRGB whose codes above `amount` (0..1) rise half as fast, white still being white
  };
  Kind kind = Kind::kStated;
  double amount = 0;

  /// The code, 0..1, of light from 0 to 1. @param stated the image's curve.
  double CodeOf(double light, const ToneCurve& stated) const;
};

/// "bt709", "gamma:1.4", "knee:0.6"; nothing for other words, or where the amount is not from 0.2 to 5 (gamma) or 0.1 to
/// 0.95 (knee).
std::optional<CameraCurve> ParseCameraCurve(std::string_view text);
/// The forms that ParseCameraCurve knows, for messages.
inline constexpr const char* kCameraCurveForms = "bt709, gamma:G, knee:K";

/// What a webcam's processor does to a picture on its way from the sensor to the cable. The ranges are those of webcams:
/// sharpening up to 1.5, denoising up to 6 levels, saturation 0.9 to 1.5, chromatic aberration up to 1 px, upscaling of
/// sensors that have fewer pixels than the picture, up to 1.5.
struct ProcessingOptions {
  double chromatic_aberration_px = 0;  ///< by which red is too far out in the frame's corners, and blue too far in; 0..5
  double denoising_levels = 0;         ///< differences of values that a bilateral filter takes for noise, 0..50
  double sharpening = 0;               ///< unsharp masking of 1 px: how much of the detail is added; 0..4
  double saturation = 1;               ///< factor of the colours' distance from grey, in light; 0..3
  double upscaling = 1;                ///< the sensor has so many times fewer columns and rows than the frame; 1..4
  CameraCurve curve;

  /// Whether it does anything to a picture.
  bool any() const;
  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// Red too large and blue too small about the middle of the frame.
LinearImage WithChromaticAberration(const LinearImage& light, double corner_px);
/// The mean light of each of a smaller number of pixels: what a sensor with fewer of them gets.
LinearImage Reduced(const LinearImage& light, int width, int height);
/// Denoises, sharpens and enlarges a picture to that size. @pre BGR8 or RGB8 or Mono8.
Image Processed(const Image& image, const ProcessingOptions& options, int width, int height);

/// A kind of camera: how it processes and delivers pictures.
struct CameraPreset {
  std::string_view name;
  PixelFormat format = PixelFormat::kBgr8;
  std::optional<int> jpeg_quality;
  ProcessingOptions processing;
};
/// "webcam-mjpeg", "webcam-yuyv", "webcam-nv12"; nothing for other names.
std::optional<CameraPreset> FindCameraPreset(std::string_view name);
/// Their names, comma-separated.
std::string CameraPresetNames();

}  // namespace chequer
