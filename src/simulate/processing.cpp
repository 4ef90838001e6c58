#include "simulate/processing.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "chequer/check.h"

namespace chequer {
namespace {

double Bt709(double light) { return light < 0.018 ? 4.5 * light : 1.099 * std::pow(light, 0.45) - 0.099; }

cv::Mat MatOf(const LinearImage& image) {
  // OpenCV has no matrix over const memory; it is only read.
  return cv::Mat(image.height, image.width, CV_32FC3, const_cast<float*>(image.rgb.data()));
}

LinearImage FromMat(const cv::Mat& mat) {
  LinearImage image(mat.cols, mat.rows);
  mat.copyTo(cv::Mat(mat.rows, mat.cols, CV_32FC3, image.rgb.data()));
  return image;
}

// Strengths are guesses from what webcams' pictures of edges look like: overshoots of a tenth to a quarter of an edge.
const std::array<CameraPreset, 3>& Presets() {
  static const std::array<CameraPreset, 3> kPresets{{
      {"webcam-mjpeg", PixelFormat::kYuv422p, 75,
       {.chromatic_aberration_px = 0.3, .denoising_levels = 4, .sharpening = 0.6, .saturation = 1.2,
        .curve = {CameraCurve::Kind::kBt709, 0}}},
      {"webcam-yuyv", PixelFormat::kYuyv, {},
       {.chromatic_aberration_px = 0.3, .denoising_levels = 3, .sharpening = 0.4, .saturation = 1.1, .curve = {}}},
      {"webcam-nv12", PixelFormat::kNv12, {},
       {.chromatic_aberration_px = 0.3, .denoising_levels = 4, .sharpening = 0.6, .saturation = 1.2,
        .curve = {CameraCurve::Kind::kKnee, 0.8}}},
  }};
  return kPresets;
}

}  // namespace

double CameraCurve::CodeOf(double light, const ToneCurve& stated) const {
  light = std::clamp(light, 0.0, 1.0);
  switch (kind) {
    case Kind::kStated: return stated.FromLinear(light);
    case Kind::kBt709: return Bt709(light);
    case Kind::kGamma: return std::pow(light, 1 / amount);
    case Kind::kKnee: {
      const double code = ToneCurve::Srgb().FromLinear(light), most = amount + (1 - amount) / 2;
      return (code <= amount ? code : amount + (code - amount) / 2) / most;
    }
  }
  FailCheck("kind", __FILE__, __LINE__, "no such curve");
}

std::optional<CameraCurve> ParseCameraCurve(std::string_view text) {
  if (text == "bt709") return CameraCurve{CameraCurve::Kind::kBt709, 0};
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  double amount = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + colon + 1, end, amount);
  if (error != std::errc() || rest != end) return std::nullopt;
  const std::string_view name = text.substr(0, colon);
  if (name == "gamma" && amount >= 0.2 && amount <= 5) return CameraCurve{CameraCurve::Kind::kGamma, amount};
  if (name == "knee" && amount >= 0.1 && amount <= 0.95) return CameraCurve{CameraCurve::Kind::kKnee, amount};
  return std::nullopt;
}

bool ProcessingOptions::any() const {
  return chromatic_aberration_px != 0 || denoising_levels != 0 || sharpening != 0 || saturation != 1 ||
         upscaling != 1 || curve.kind != CameraCurve::Kind::kStated;
}

std::string ProcessingOptions::Check() const {
  if (!(chromatic_aberration_px >= 0 && chromatic_aberration_px <= 5)) return "chromatic_aberration_px must be from 0 to 5";
  if (!(denoising_levels >= 0 && denoising_levels <= 50)) return "denoising_levels must be from 0 to 50";
  if (!(sharpening >= 0 && sharpening <= 4)) return "sharpening must be from 0 to 4";
  if (!(saturation >= 0 && saturation <= 3)) return "saturation must be from 0 to 3";
  if (!(upscaling >= 1 && upscaling <= 4)) return "upscaling must be from 1 to 4";
  return {};
}

LinearImage WithChromaticAberration(const LinearImage& light, double corner_px) {
  if (corner_px == 0) return light;
  const double to_corner = std::hypot(0.5 * light.width, 0.5 * light.height);
  std::array<cv::Mat, 3> planes;
  cv::split(MatOf(light), planes);
  for (const std::size_t channel : {std::size_t{0}, std::size_t{2}}) {
    // Where the light of a pixel comes from: red's nearer to the middle.
    const double scale = 1 + (channel == 0 ? -corner_px : corner_px) / to_corner;
    const double x = 0.5 * (light.width - 1), y = 0.5 * (light.height - 1);
    const cv::Matx23d from(scale, 0, x - scale * x, 0, scale, y - scale * y);
    cv::Mat moved;
    cv::warpAffine(planes[channel], moved, from, planes[channel].size(), cv::INTER_CUBIC | cv::WARP_INVERSE_MAP,
                   cv::BORDER_REPLICATE);
    planes[channel] = cv::max(moved, 0.0f);
  }
  cv::Mat merged;
  cv::merge(planes, merged);
  return FromMat(merged);
}

LinearImage Reduced(const LinearImage& light, int width, int height) {
  cv::Mat reduced;
  cv::resize(MatOf(light), reduced, {width, height}, 0, 0, cv::INTER_AREA);
  return FromMat(reduced);
}

Image Processed(const Image& image, const ProcessingOptions& options, int width, int height) {
  CHEQUER_CHECK(image.format() == PixelFormat::kBgr8 || image.format() == PixelFormat::kRgb8 ||
                    image.format() == PixelFormat::kMono8,
                "only pictures are processed");
  const int type = image.format() == PixelFormat::kMono8 ? CV_8UC1 : CV_8UC3;
  // OpenCV has no matrix over const memory; it is only read.
  cv::Mat picture(image.height(), image.width(), type, const_cast<std::uint8_t*>(image.bytes().data()));
  if (options.denoising_levels > 0) {
    cv::Mat denoised;
    cv::bilateralFilter(picture, denoised, 5, 2 * options.denoising_levels, 1.2);
    picture = denoised;
  }
  if (options.sharpening > 0) {
    cv::Mat blurred, sharp;
    cv::GaussianBlur(picture, blurred, {}, 1.0);
    cv::addWeighted(picture, 1 + options.sharpening, blurred, -options.sharpening, 0, sharp);
    picture = sharp;
  }
  if (picture.cols != width || picture.rows != height) {
    cv::Mat enlarged;
    cv::resize(picture, enlarged, {width, height}, 0, 0, cv::INTER_LINEAR);
    picture = enlarged;
  }
  Image processed(image.format(), width, height, image.view().tone_curve());
  picture.copyTo(cv::Mat(height, width, type, processed.bytes().data()));
  return processed;
}

std::optional<CameraPreset> FindCameraPreset(std::string_view name) {
  for (const CameraPreset& preset : Presets())
    if (preset.name == name) return preset;
  return std::nullopt;
}

std::string CameraPresetNames() {
  std::string names;
  for (const CameraPreset& preset : Presets()) names.append(names.empty() ? "" : ", ").append(preset.name);
  return names;
}

}  // namespace chequer
