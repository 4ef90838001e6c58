#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "chequer/image.h"

namespace chequer {

/// A rectangle of pixels, edges included; empty at first.
struct PixelBox {
  float left = 1e9f, top = 1e9f, right = -1e9f, bottom = -1e9f;

  void Add(float x, float y) {
    left = std::min(left, x), right = std::max(right, x);
    top = std::min(top, y), bottom = std::max(bottom, y);
  }
  Eigen::Vector2f Center() const { return {0.5f * (left + right), 0.5f * (top + bottom)}; }
  /// The longer one.
  float Side() const { return std::max(right - left, bottom - top); }
  /// Moves every edge outwards by that share of the longer side.
  void Widen(float share) {
    const float by = share * std::max(right - left, bottom - top);
    left -= by, top -= by, right += by, bottom += by;
  }
};

/// What is measured of a pixel with all colours: red and green, in which blue is as dark as black and yellow as light
/// as white, mixed as in luma. JPEG shares out other mixtures' edges among pixels: from a mean of both, boards lay
/// 0.006 px off.
struct RedAndGreen {
  static constexpr float kRed = 0.3f;

  static float Of(float red, float green) { return green + kRed * (red - green); }
};

/// Reads single pixels of an image as linear light: the measuring stages touch a few thousand pixels of a frame, so
/// nothing is converted that is not looked at.
class LightReader {
 public:
  /// @param image must outlive the reader. @param table the image's tone curve.
  LightReader(const ImageView& image, const std::array<float, 256>& table);

  int width() const { return image_.width(); }
  int height() const { return image_.height(); }

  /// Where red lies in the 2 × 2 tile of a mosaic.
  struct Mosaic {
    int red_x = 0;
    int red_y = 0;
  };
  /// Of a Bayer image, or of a colour image that was found to be an interpolated mosaic (see SetMosaic).
  const std::optional<Mosaic>& mosaic() const { return mosaic_; }
  /// Declares that the pixels of a colour image hold the samples of that mosaic, the other two channels being
  /// interpolated: runs then read the samples alone.
  void SetMosaic(const Mosaic& mosaic) { mosaic_ = mosaic; }

  /// Three values as the image codes them, of a pixel or the mean of some: R, G, B, or Y, U, V.
  using Codes = Eigen::Array3f;
  /// How many pixels share a sample of the second and third code.
  struct Sharing {
    int cols = 1, rows = 1;
  };
  Sharing chroma_sharing() const;
  /// Where pixels share a sample, the same for all of them; where each has one colour, of its neighbours for the
  /// others.
  /// @pre the pixel lies in the image.
  Codes CodesAt(int x, int y) const;
  /// Light of codes, between those of whole ones, and the other way round: of what the image's range holds, within it.
  Eigen::Vector3f LightOf(const Codes& codes) const;
  Codes CodesOf(const Eigen::Vector3f& light) const;

  /// Channels that runs tell apart: 3 with a mosaic, else 1.
  int channels() const { return mosaic_ ? 3 : 1; }
  /// Channel of a pixel with coordinates of that parity: 0 red, 1 green, 2 blue; 0 without a mosaic.
  int ChannelOf(int x_parity, int y_parity) const;

  /// Neighbouring pixels of a row, from one on. One measurement each, 0..1: the sample of a mosaic; RedAndGreen of a
  /// colour image; Y of a YUV image.
  struct Run {
    const std::uint8_t *first, *second;  ///< bytes of the first pixel and the next
    std::ptrdiff_t step;                 ///< from a pixel to the next but one
    std::ptrdiff_t red;                  ///< from a byte to the one that it is mixed with; 0 if none is
    const float* table;

    bool is_mixed() const { return red != 0; }
    float Mixed(const std::uint8_t* p) const { return RedAndGreen::Of(table[p[red]], table[*p]); }
  };
  /// One row's.
  struct RunsOfRow {
    const std::uint8_t* start;
    const float* table;
    std::ptrdiff_t step, red;
    std::array<std::ptrdiff_t, 4> offset;  ///< of a run's first and second byte, from even x and from odd x

    Run From(int x) const {
      const std::uint8_t* p = start + step * x;
      const std::ptrdiff_t* of_x = offset.data() + 2 * (x & 1);
      return {p + of_x[0], p + of_x[1], 2 * step, red, table};
    }
  };
  /// Rows of the image for those who read many: the format is asked for once.
  class Rows {
   public:
    /// Of all runs, Run::is_mixed().
    bool are_mixed() const { return red_ != 0; }
    /// From now on, their runs tell of codes from that light on that light, negated. @param table room for the light of
    /// all codes, which must outlive them. @pre !are_mixed()
    void Negate(float from, std::array<float, 256>& table);
    /// @pre the row lies in the image.
    RunsOfRow At(int y) const {
      const std::array<int, 2>& offset = offset_[static_cast<std::size_t>(y & 1)];
      return {base_ + stride_ * y, table_, step_, red_, {offset[0], offset[1] + step_, offset[1], offset[0] + step_}};
    }
    /// The row, or a run in it, becomes the next one of its parity, which may be none of the image.
    void NextButOne(RunsOfRow& row) const { row.start += 2 * stride_; }
    void NextButOne(Run& run) const { run.first += 2 * stride_, run.second += 2 * stride_; }
    /// @pre the pixel lies in the image.
    Run From(int x, int y) const { return At(y).From(x); }

   private:
    friend class LightReader;
    const std::uint8_t* base_ = nullptr;
    const float* table_ = nullptr;
    std::ptrdiff_t stride_ = 0, step_ = 1, red_ = 0;
    std::array<std::array<int, 2>, 2> offset_{};  ///< by parities of y and x
  };
  Rows AllRows() const;

  /// Asks the memory for the pixels of a box (of the first plane), so that its answers overlap: a board's rows lie
  /// pages apart, and a large frame in no near cache. Does nothing for wide boxes, along whose rows the processor reads
  /// ahead itself.
  void Prefetch(const PixelBox& box) const;

  /// Light of the three channels around a point, 0..1 (slightly outside for YUV): the mean over the pixels at most
  /// half_px away along each axis, at least one of each channel. Points outside the image take its edge.
  Eigen::Vector3f Rgb(float x, float y, float half_px) const;
  /// The same in two thirds of the time, for windows of one colour: over the largest square of whole pixels that fits
  /// into the window wherever that lies, so that its size hardly ever changes from one cell to the next; and of the
  /// coded values' mean, which differs from the mean of the light where the pixels differ from each other. 60 ns, most
  /// of which waits for memory.
  Eigen::Vector3f RoughRgb(float x, float y, float half_px) const;

 private:
  Eigen::Vector3f RgbAt(int x, int y) const;
  /// Of the 2 × 2 pixels of a mosaic from x0, y0 on.
  Eigen::Vector3f RgbOfTile(int x0, int y0) const;
  /// Over a window of a mosaic that holds every channel.
  Eigen::Vector3f MosaicMean(int x0, int y0, int x1, int y1) const;
  std::array<int, 3> YuvAt(int x, int y) const;
  Eigen::Vector3f LightOfYuv(const Codes& yuv) const;
  /// Means over the square of `size` pixels a side from x0, y0.
  Codes MeanOfPixels(int x0, int y0, int size) const;
  Codes MeanOfMosaic(int x0, int y0, int size) const;

  ImageView image_;
  const std::array<float, 256>& table_;
  std::optional<std::array<float, 256>> limited_luma_;  ///< light of each Y, where these have the range of video
  std::optional<Mosaic> mosaic_;
  int step_ = 1;  ///< bytes from one pixel of the first plane to the next
};

/// Looks whether a colour image (BGR8 or RGB8) is a bilinearly interpolated mosaic, by comparing, in a window, each
/// channel with the mean of its neighbours: where it was interpolated they agree to the rounding, where it was measured
/// they differ by noise and texture. Nothing where that does not decide it (JPEG, other interpolations, flat windows).
/// Looks at no more rows of the window than it takes to be clear.
/// @param x0, y0, x1, y1 window, pixels, within the image less one pixel.
std::optional<LightReader::Mosaic> FindInterpolatedMosaic(const ImageView& image, const std::array<float, 256>& table,
                                                          int x0, int y0, int x1, int y1);

}  // namespace chequer
