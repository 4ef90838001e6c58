#include "simulate/background.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/image_file.h"
#include "chequer/tone_curve.h"
#include "simulate/clutter.h"
#include "simulate/random.h"

namespace chequer {
namespace {

constexpr std::array<std::pair<BackgroundKind, std::string_view>, 9> kNames{{
    {BackgroundKind::kPlain, "plain"},
    {BackgroundKind::kNoise, "noise"},
    {BackgroundKind::kChess, "chess"},
    {BackgroundKind::kText, "text"},
    {BackgroundKind::kTiles, "tiles"},
    {BackgroundKind::kWood, "wood"},
    {BackgroundKind::kBlobs, "blobs"},
    {BackgroundKind::kMixed, "mixed"},
    {BackgroundKind::kImage, "image"},
}};

/// The file's middle, scaled to fill the frame.
cv::Mat LoadCut(const std::string& file, int width, int height) {
  Image loaded = LoadImage(file, {PixelFormat::kMono8, JpegColour::kBgr, ToneCurve::Srgb()});
  const bool grey = loaded.format() == PixelFormat::kMono8;
  cv::Mat image(loaded.height(), loaded.width(), grey ? CV_8UC1 : CV_8UC3, loaded.bytes().data());
  if (grey) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  const double scale = std::max(static_cast<double>(width) / image.cols, static_cast<double>(height) / image.rows);
  cv::Mat scaled;
  const cv::Size size(std::max(width, static_cast<int>(std::lround(image.cols * scale))),
                      std::max(height, static_cast<int>(std::lround(image.rows * scale))));
  cv::resize(image, scaled, size, 0, 0, scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return scaled(cv::Rect((size.width - width) / 2, (size.height - height) / 2, width, height)).clone();
}

LinearImage ToLinear(const cv::Mat& bgr) {
  // Paper white is the brightest thing about, and an image's 255 is no brighter.
  constexpr float kBrightest = 0.9f;
  const std::array<float, 256> light = ToneCurve::Srgb().LinearTable();
  LinearImage out(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y) {
    const auto* in = bgr.ptr<cv::Vec3b>(y);
    float* pixel = out.Pixel(0, y);
    for (int x = 0; x < bgr.cols; ++x, pixel += 3)
      for (int c = 0; c < 3; ++c) pixel[c] = kBrightest * light[in[x][2 - c]];
  }
  return out;
}

}  // namespace

std::string Background::Check() const {
  if (!(colour.minCoeff() >= 0) || !(colour.maxCoeff() <= 1)) return "the background's colour must be from 0 to 1";
  if (kind == BackgroundKind::kImage && file.empty()) return "a background of kind image needs a file";
  return {};
}

std::string_view BackgroundName(BackgroundKind kind) {
  return std::find_if(kNames.begin(), kNames.end(), [&](const auto& entry) { return entry.first == kind; })->second;
}

std::optional<BackgroundKind> ParseBackground(std::string_view name) {
  for (const auto& [kind, known] : kNames)
    if (known == name) return kind;
  return std::nullopt;
}

std::string BackgroundNames() {
  std::string text;
  for (const auto& [kind, name] : kNames)
    if (kind != BackgroundKind::kImage) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

LinearImage DrawBackground(const Background& background, int width, int height) {
  if (background.kind == BackgroundKind::kPlain) {
    LinearImage out(width, height);
    for (std::size_t i = 0; i < out.rgb.size(); ++i) out.rgb[i] = background.colour[static_cast<int>(i % 3)];
    return out;
  }
  if (background.kind == BackgroundKind::kImage) return ToLinear(LoadCut(background.file, width, height));
  cv::Mat image(height, width, CV_8UC3);
  Random random(background.seed);
  DrawClutter(background.kind, image, random);
  return ToLinear(image);
}

}  // namespace chequer
