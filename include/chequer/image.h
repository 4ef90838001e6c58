#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/tone_curve.h"

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// How the bytes of an image are laid out. Eight bits a sample throughout.
/// Bayer names follow GenICam: the first two letters are the first two pixels of the first row.
enum class PixelFormat : std::uint8_t {
  kMono8,
  kBgr8,
  kRgb8,
  kBayerRg8,
  kBayerGb8,
  kBayerGr8,
  kBayerBg8,
  kYuyv,     ///< 4:2:2 interleaved, Y0 U Y1 V; even width
  kUyvy,     ///< 4:2:2 interleaved, U Y0 V Y1; even width
  kNv12,     ///< 4:2:0, plane 0 Y, plane 1 interleaved U V; even width and height
  kYuv420p,  ///< planar JPEG YUV (Y, U, V), chroma halved both ways, rounded up
  kYuv422p,  ///< planar JPEG YUV, chroma halved horizontally, rounded up
  kYuv444p,  ///< planar JPEG YUV, chroma at full size
};

/// The name users write: GenICam's for Mono8, BGR8, RGB8 and Bayer, V4L2's for YUYV, UYVY, NV12, and YUV420P, YUV422P, YUV444P.
std::string_view PixelFormatName(PixelFormat format);

/// The format of that exact name; nothing when there is none.
std::optional<PixelFormat> ParsePixelFormat(std::string_view name);

/// All names that ParsePixelFormat knows, comma-separated, for messages.
std::string PixelFormatNames();

bool IsBayer(PixelFormat format);
bool IsYuv(PixelFormat format);

/// The values that Y, U and V run over (BT.601): JPEG's 0..255 or video's 16..235 / 16..240.
enum class YuvRange : std::uint8_t { kFull, kLimited };

/// One plane of an image: `height` rows, `stride_bytes` apart.
struct Plane {
  const std::uint8_t* data = nullptr;
  std::ptrdiff_t stride_bytes = 0;
};

/// Where a plane of a format lies in its image, in samples.
struct PlaneShape {
  int row_bytes = 0;
  int rows = 0;
};

/// The planes a format has at that size, in order. Unused entries are zero.
std::array<PlaneShape, 3> PlaneShapes(PixelFormat format, int width, int height);

/// Bytes of an image whose rows and planes follow each other without gaps.
std::size_t PackedSize(PixelFormat format, int width, int height);

/// Largest width or height anything in chequer accepts, pixels.
inline constexpr int kMaxImageSide = 16384;

/// A borrowed image: it owns nothing and must not outlive the pixels.
/// The centre of the top-left pixel is (0, 0).
class ImageView {
 public:
  /// An empty image (0 × 0).
  ImageView() = default;

  /// @pre sides from 1 to kMaxImageSide, even where the format asks it, every plane the format needs is there and
  /// its stride holds a row; a breach is a bug of the caller and ends the program with a message.
  ImageView(PixelFormat format, int width, int height, std::span<const Plane> planes,
            ToneCurve tone_curve = ToneCurve::Srgb(), YuvRange yuv_range = YuvRange::kFull);

  PixelFormat format() const { return format_; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return width_ == 0; }
  const Plane& plane(int index) const { return planes_[static_cast<std::size_t>(index)]; }
  const std::uint8_t* row(int y, int plane_index = 0) const {
    const Plane& p = plane(plane_index);
    return p.data + p.stride_bytes * y;
  }
  /// How the values relate to light.
  const ToneCurve& tone_curve() const { return tone_curve_; }
  YuvRange yuv_range() const { return yuv_range_; }

 private:
  PixelFormat format_ = PixelFormat::kMono8;
  int width_ = 0;
  int height_ = 0;
  std::array<Plane, 3> planes_{};
  ToneCurve tone_curve_ = ToneCurve::Srgb();
  YuvRange yuv_range_ = YuvRange::kFull;
};

/// Whether an image of that format can have that size (sides in range, even where the format asks it).
bool SizeIsValid(PixelFormat format, int width, int height);

/// A view over packed bytes (rows and planes without gaps); nothing if the size is not valid or the bytes do not suffice.
std::optional<ImageView> ViewPacked(PixelFormat format, int width, int height, std::span<const std::uint8_t> bytes,
                                    ToneCurve tone_curve = ToneCurve::Srgb(), YuvRange yuv_range = YuvRange::kFull);

/// An image that owns its bytes, packed.
class Image {
 public:
  Image() = default;
  /// Zeroed. @pre SizeIsValid.
  Image(PixelFormat format, int width, int height, ToneCurve tone_curve = ToneCurve::Srgb(),
        YuvRange yuv_range = YuvRange::kFull);

  ImageView view() const;
  PixelFormat format() const { return format_; }
  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return bytes_.empty(); }
  /// All planes, packed, in order.
  std::span<std::uint8_t> bytes() { return bytes_; }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  PixelFormat format_ = PixelFormat::kMono8;
  int width_ = 0;
  int height_ = 0;
  ToneCurve tone_curve_ = ToneCurve::Srgb();
  YuvRange yuv_range_ = YuvRange::kFull;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace chequer

#pragma GCC visibility pop
