#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "chequer/image.h"
#include "detect/common/raw_buffer.h"

namespace chequer {

/// One 8-bit channel with its memory, rows `stride` apart. Resizing keeps the memory.
class BytePlane {
 public:
  /// Values are undefined afterwards. Rows get a tail of at least kTail bytes, so that vectors may run over their end.
  void Resize(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }
  std::ptrdiff_t stride() const { return stride_; }
  std::uint8_t* row(int y) { return bytes_.data() + stride_ * y; }
  const std::uint8_t* row(int y) const { return bytes_.data() + stride_ * y; }
  std::uint8_t at(int x, int y) const { return row(y)[x]; }
  /// @pre 0 ≤ x ≤ width − 1, 0 ≤ y ≤ height − 1.
  float Bilinear(float x, float y) const;

  static constexpr int kTail = 128;

 private:
  RawBuffer<std::uint8_t> bytes_;
  int width_ = 0;
  int height_ = 0;
  std::ptrdiff_t stride_ = 0;
};

/// The detection plane of an image: one value a pixel, coded as in the image, in which blue is as dark as black and
/// yellow as light as white, as far as the format tells without a colour conversion of the frame: (R+G)/2 where there
/// is colour at every pixel; a 2 × 2 window without its blue sample for Bayer; Y for YUV.
/// The plane's pixel (x, y) lies at (x, y) + Origin() of the image.
struct DetectionPlane {
  BytePlane plane;
  float offset_px = 0;  ///< along x and along y
  /// Where the part that is searched begins in the image.
  Eigen::Vector2f region_px = Eigen::Vector2f::Zero();

  Eigen::Vector2f Origin() const { return region_px + Eigen::Vector2f::Constant(offset_px); }
};

/// Fills `out`; images smaller than 2 × 2 give an empty plane. Where blue is as dark as black and yellow as light as
/// white, corners lie in the plane where they lie in the image; in luma unequal cells pull them by up to 0.4 px, which
/// the fit takes out. 0.17 ms from BGR, 0.15 ms from Bayer, 0.09 ms from YUYV at 1920 × 1080. (Times in these headers
/// are CPU times of stages_benchmark on one core of a shared EPYC: 1920 × 1080, 50 boards, textured ground, 8,000
/// corners.)
void BuildDetectionPlane(const ImageView& image, DetectionPlane& out);
/// The same in parts, so that rows can be used while they are near: sizes `out`, then fills its rows first … past − 1.
void StartDetectionPlane(const ImageView& image, DetectionPlane& out);
void FillDetectionPlane(const ImageView& image, int first, int past, DetectionPlane& out);

/// Rows first … past − 1 of `half`, which has its size already: means of 2 × 2 pixels, rounded up by less than 1. Pixel
/// (x, y) of `half` lies at (2x + ½, 2y + ½) of `full`. 0.04 ms at 1920 × 1080.
void HalveRows(const BytePlane& full, int first, int past, BytePlane& half);

inline float BytePlane::Bilinear(float x, float y) const {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const std::uint8_t* a = row(y0) + x0;
  const std::uint8_t* b = row(y0 + 1 < height_ ? y0 + 1 : y0) + x0;
  const int right = x0 + 1 < width_ ? 1 : 0;
  const float top = static_cast<float>(a[0]) + fx * static_cast<float>(a[right] - a[0]);
  const float bottom = static_cast<float>(b[0]) + fx * static_cast<float>(b[right] - b[0]);
  return top + fy * (bottom - top);
}

}  // namespace chequer
