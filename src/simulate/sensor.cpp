#include "simulate/sensor.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "chequer/check.h"
#include "simulate/random.h"

namespace chequer {
namespace {

constexpr float kRawMax = 65535.0f;

/// Photons, read-out and saturation of one photosite.
class Photosite {
 public:
  Photosite(const SensorOptions& options, std::uint64_t seed)
      : full_well_(static_cast<float>(options.full_well_electrons)),
        read_noise_(static_cast<float>(options.read_noise_electrons)),
        noiseless_(std::isinf(options.full_well_electrons)),
        random_(seed) {}

  /// 0..65535 of light in parts of full scale.
  std::uint16_t Read(float light) {
    float value = light;
    if (!noiseless_) {
      float electrons = random_.Poisson(std::max(0.0f, light) * full_well_);
      if (read_noise_ > 0) electrons += read_noise_ * random_.Normal();
      value = electrons / full_well_;
    }
    return static_cast<std::uint16_t>(std::clamp(value, 0.0f, 1.0f) * kRawMax + 0.5f);
  }

 private:
  float full_well_;
  float read_noise_;
  bool noiseless_;
  Random random_;
};

/// The colour (0 red, 1 green, 2 blue) of each pixel of a 2 × 2 quad, row by row.
std::array<int, 4> QuadColours(PixelFormat bayer) {
  switch (bayer) {
    case PixelFormat::kBayerRg8: return {0, 1, 1, 2};
    case PixelFormat::kBayerGb8: return {1, 2, 0, 1};
    case PixelFormat::kBayerGr8: return {1, 0, 2, 1};
    case PixelFormat::kBayerBg8: return {2, 1, 1, 0};
    default: FailCheck("IsBayer(bayer)", __FILE__, __LINE__, "not a Bayer format");
  }
}

/// OpenCV names a mosaic by the second row's second and third pixel.
int OpenCvDemosaicing(PixelFormat bayer) {
  switch (bayer) {
    case PixelFormat::kBayerRg8: return cv::COLOR_BayerBG2BGR;
    case PixelFormat::kBayerGb8: return cv::COLOR_BayerGR2BGR;
    case PixelFormat::kBayerGr8: return cv::COLOR_BayerGB2BGR;
    default: return cv::COLOR_BayerRG2BGR;
  }
}

cv::Mat ReadMosaic(const LinearImage& light, const SensorOptions& options, PixelFormat bayer, Photosite& site) {
  cv::Mat raw(light.height, light.width, CV_16U);
  const std::array<int, 4> quad = QuadColours(bayer);
  for (int y = 0; y < light.height; ++y) {
    auto* out = raw.ptr<std::uint16_t>(y);
    const float* in = light.Pixel(0, y);
    for (int x = 0; x < light.width; ++x) {
      const int colour = quad[static_cast<std::size_t>(2 * (y % 2) + x % 2)];
      const auto gain = static_cast<float>(options.exposure * options.white_balance[static_cast<std::size_t>(colour)]);
      out[x] = site.Read(in[3 * x + colour] * gain);
    }
  }
  return raw;
}

cv::Mat ReadColours(const LinearImage& light, const SensorOptions& options, Photosite& site) {
  cv::Mat raw(light.height, light.width, CV_16UC3);
  for (int y = 0; y < light.height; ++y) {
    auto* out = raw.ptr<cv::Vec3w>(y);
    const float* in = light.Pixel(0, y);
    for (int x = 0; x < light.width; ++x)
      for (int colour = 0; colour < 3; ++colour) {
        const auto gain =
            static_cast<float>(options.exposure * options.white_balance[static_cast<std::size_t>(colour)]);
        out[x][2 - colour] = site.Read(in[3 * x + colour] * gain);
      }
  }
  return raw;
}

/// Silicon without filters sees all three colours about alike.
cv::Mat ReadGrey(const LinearImage& light, const SensorOptions& options, Photosite& site) {
  cv::Mat raw(light.height, light.width, CV_16U);
  std::array<float, 3> gain{};
  for (std::size_t c = 0; c < 3; ++c) gain[c] = static_cast<float>(options.exposure * options.white_balance[c] / 3);
  for (int y = 0; y < light.height; ++y) {
    auto* out = raw.ptr<std::uint16_t>(y);
    const float* in = light.Pixel(0, y);
    for (int x = 0; x < light.width; ++x)
      out[x] = site.Read(in[3 * x] * gain[0] + in[3 * x + 1] * gain[1] + in[3 * x + 2] * gain[2]);
  }
  return raw;
}

/// Raw values through the curve into packed bytes; with `swapped`, the first and third of three channels change places.
void Code(const cv::Mat& raw, ToneCurve tone_curve, const CameraCurve& curve, bool swapped,
          std::span<std::uint8_t> bytes) {
  std::vector<std::uint8_t> table(65536);
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<std::uint8_t>(curve.CodeOf(static_cast<double>(i) / 65535.0, tone_curve) * 255 + 0.5);
  const auto channels = static_cast<std::size_t>(raw.channels());
  const std::size_t samples = static_cast<std::size_t>(raw.cols) * channels;
  for (int y = 0; y < raw.rows; ++y) {
    const auto* in = raw.ptr<std::uint16_t>(y);
    std::uint8_t* out = &bytes[static_cast<std::size_t>(y) * samples];
    for (std::size_t i = 0; i < samples; ++i) out[i] = table[in[i]];
    if (swapped)
      for (std::size_t i = 0; i + 2 < samples; i += 3) std::swap(out[i], out[i + 2]);
  }
}

/// Multiplies the colours' distance from grey of the same luminance (BT.709's, of linear light).
void Saturate(cv::Mat& raw, double saturation) {
  constexpr std::array<double, 3> kLuminance{0.0722, 0.7152, 0.2126};  // blue, green, red
  for (int y = 0; y < raw.rows; ++y) {
    auto* pixel = raw.ptr<cv::Vec3w>(y);
    for (int x = 0; x < raw.cols; ++x) {
      double grey = 0;
      for (int c = 0; c < 3; ++c) grey += kLuminance[static_cast<std::size_t>(c)] * pixel[x][c];
      for (int c = 0; c < 3; ++c)
        pixel[x][c] = cv::saturate_cast<std::uint16_t>(grey + saturation * (pixel[x][c] - grey));
    }
  }
}

}  // namespace

std::string SensorOptions::Check() const {
  if (!IsBayer(bayer)) return "the sensor's mosaic must be BayerRG8, BayerGB8, BayerGR8 or BayerBG8";
  if (!(exposure > 0 && exposure <= 1000)) return "exposure must be above 0, at most 1000";
  for (const double factor : white_balance)
    if (!(factor >= 0 && factor <= 100)) return "white_balance must be from 0 to 100";
  if (!(full_well_electrons >= 1)) return "full_well_electrons must be at least 1";
  if (!(read_noise_electrons >= 0 && read_noise_electrons <= 1e6)) return "read_noise_electrons must be from 0 to 1e6";
  return {};
}

std::string LightingOptions::Check() const {
  if (!(gradient >= 0 && gradient <= 1)) return "gradient must be from 0 to 1";
  if (!(vignetting >= 0 && vignetting <= 1)) return "vignetting must be from 0 to 1";
  if (!(haze >= 0 && haze <= 0.95)) return "haze must be from 0 to 0.95";
  return {};
}

void Illuminate(LinearImage& image, const LightingOptions& lighting) {
  if (lighting.gradient == 0 && lighting.vignetting == 0 && lighting.haze == 0) return;
  const double dx = std::cos(lighting.gradient_angle_rad), dy = std::sin(lighting.gradient_angle_rad);
  const double half_width = 0.5 * image.width, half_height = 0.5 * image.height;
  const double reach = std::abs(dx) * half_width + std::abs(dy) * half_height;
  const double corner2 = half_width * half_width + half_height * half_height;
  const auto clear = static_cast<float>(1 - lighting.haze), veil = static_cast<float>(lighting.haze);
  for (int y = 0; y < image.height; ++y) {
    const double v = y + 0.5 - half_height;
    float* pixel = image.Pixel(0, y);
    for (int x = 0; x < image.width; ++x, pixel += 3) {
      const double u = x + 0.5 - half_width;
      const double fallen = 0.5 + 0.5 * (u * dx + v * dy) / reach;
      const double light = (1 - lighting.gradient * fallen) * (1 - lighting.vignetting * (u * u + v * v) / corner2);
      for (int c = 0; c < 3; ++c) pixel[c] = pixel[c] * static_cast<float>(light) * clear + veil;
    }
  }
}

Image Expose(const LinearImage& light, const SensorOptions& options, PixelFormat format, ToneCurve tone_curve,
             std::uint64_t seed, const ProcessingOptions& processing) {
  Photosite site(options, seed);
  Image image(format, light.width, light.height, tone_curve);
  cv::Mat raw;
  if (IsBayer(format)) {
    raw = ReadMosaic(light, options, format, site);
  } else if (format == PixelFormat::kMono8) {
    raw = ReadGrey(light, options, site);
  } else {
    CHEQUER_CHECK(format == PixelFormat::kBgr8 || format == PixelFormat::kRgb8, "not a format that sensors give");
    if (options.kind == SensorKind::kBayer)
      cv::demosaicing(ReadMosaic(light, options, options.bayer, site), raw, OpenCvDemosaicing(options.bayer));
    else
      raw = ReadColours(light, options, site);
  }
  if (processing.saturation != 1 && raw.channels() == 3) Saturate(raw, processing.saturation);
  Code(raw, tone_curve, processing.curve, format == PixelFormat::kRgb8, image.bytes());
  return image;
}

}  // namespace chequer
