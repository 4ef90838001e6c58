#include "capture/jpeg.h"

#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "capture/codec_limits.h"
#include "chequer/check.h"

namespace chequer {
namespace {

struct DestroyTurbo {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboHandle = std::unique_ptr<std::remove_pointer_t<tjhandle>, DestroyTurbo>;

// Progressive files of very many scans decode for minutes; the accurate DCT costs little and the pose shows it.
constexpr int kFlags = TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS;

struct JpegHeader {
  int width = 0;
  int height = 0;
  int sampling = 0;
  int colour_space = 0;
};

std::optional<PixelFormat> PlanarFormat(const JpegHeader& header) {
  if (header.colour_space != TJCS_YCbCr) return std::nullopt;
  switch (header.sampling) {
    case TJSAMP_444: return PixelFormat::kYuv444p;
    case TJSAMP_422: return PixelFormat::kYuv422p;
    case TJSAMP_420: return PixelFormat::kYuv420p;
    default: return std::nullopt;
  }
}

int TurboSampling(PixelFormat planar) {
  switch (planar) {
    case PixelFormat::kYuv420p: return TJSAMP_420;
    case PixelFormat::kYuv422p: return TJSAMP_422;
    default: return TJSAMP_444;
  }
}

/// Throws unless a call went well. Many webcams put stray bytes before the end marker: by then all is decoded, so this
/// one warning is none; any other means pixels that were not in the file.
void CheckTurbo(int status, tjhandle handle) {
  if (status == 0) return;
  const std::string_view message = tjGetErrorStr2(handle);
  const bool stray_bytes_at_end = message.ends_with("extraneous bytes before marker 0xd9");
  if (tjGetErrorCode(handle) == TJERR_WARNING && stray_bytes_at_end) return;
  throw std::runtime_error(std::string(message));
}

JpegHeader ReadHeader(tjhandle handle, std::span<const std::uint8_t> bytes) {
  JpegHeader header;
  if (tjDecompressHeader3(handle, bytes.data(), bytes.size(), &header.width, &header.height, &header.sampling,
                          &header.colour_space) != 0)
    throw std::runtime_error(tjGetErrorStr2(handle));
  CheckPromisedSize(header.width, header.height);
  if (header.colour_space == TJCS_CMYK || header.colour_space == TJCS_YCCK)
    throw std::runtime_error("it is in printing colours (CMYK); only RGB, YCbCr and grey are read");
  return header;
}

/// Planes as the codec wants them: padded to whole chroma samples, which matters for odd sizes only.
struct PaddedPlanes {
  PaddedPlanes(int width, int height, int sampling) {
    for (int i = 0; i < 3; ++i) {
      const auto plane = static_cast<std::size_t>(i);
      strides[plane] = tjPlaneWidth(i, width, sampling);
      rows[plane] = tjPlaneHeight(i, height, sampling);
      samples[plane].resize(static_cast<std::size_t>(strides[plane]) * static_cast<std::size_t>(rows[plane]));
      data[plane] = samples[plane].data();
    }
  }
  std::array<int, 3> strides{};
  std::array<int, 3> rows{};
  std::array<std::vector<std::uint8_t>, 3> samples;
  std::array<std::uint8_t*, 3> data{};
};

/// Makes an image what it is to be, unless it is that already.
void Shape(Image& image, PixelFormat format, const JpegHeader& header, ToneCurve tone_curve) {
  const ImageView view = image.view();
  const bool is_right = view.format() == format && view.width() == header.width && view.height() == header.height &&
                        view.tone_curve() == tone_curve && view.yuv_range() == YuvRange::kFull;
  if (!is_right) image = Image(format, header.width, header.height, tone_curve, YuvRange::kFull);
}

void DecodePlanar(tjhandle handle, std::span<const std::uint8_t> bytes, const JpegHeader& header, Image& image) {
  const auto shapes = PlaneShapes(image.format(), header.width, header.height);
  std::uint8_t* next = image.bytes().data();
  if (header.width % 2 == 0 && header.height % 2 == 0) {
    std::array<std::uint8_t*, 3> planes{};
    std::array<int, 3> strides{};
    for (std::size_t i = 0; i < 3; ++i) {
      planes[i] = next;
      strides[i] = shapes[i].row_bytes;
      next += static_cast<std::ptrdiff_t>(shapes[i].row_bytes) * shapes[i].rows;
    }
    CheckTurbo(tjDecompressToYUVPlanes(handle, bytes.data(), bytes.size(), planes.data(), header.width, strides.data(),
                                       header.height, kFlags),
               handle);
    return;
  }
  PaddedPlanes padded(header.width, header.height, header.sampling);
  CheckTurbo(tjDecompressToYUVPlanes(handle, bytes.data(), bytes.size(), padded.data.data(), header.width,
                                     padded.strides.data(), header.height, kFlags),
             handle);
  for (std::size_t i = 0; i < 3; ++i)
    for (int y = 0; y < shapes[i].rows; ++y, next += shapes[i].row_bytes)
      std::memcpy(next, padded.data[i] + static_cast<std::ptrdiff_t>(padded.strides[i]) * y,
                  static_cast<std::size_t>(shapes[i].row_bytes));
}

PaddedPlanes PadPlanes(const ImageView& image, int sampling) {
  PaddedPlanes padded(image.width(), image.height(), sampling);
  const auto shapes = PlaneShapes(image.format(), image.width(), image.height());
  for (std::size_t i = 0; i < 3; ++i)
    for (int y = 0; y < padded.rows[i]; ++y) {
      const std::uint8_t* from = image.row(std::min(y, shapes[i].rows - 1), static_cast<int>(i));
      std::uint8_t* to = padded.data[i] + static_cast<std::ptrdiff_t>(padded.strides[i]) * y;
      std::memcpy(to, from, static_cast<std::size_t>(shapes[i].row_bytes));
      std::fill(to + shapes[i].row_bytes, to + padded.strides[i], from[shapes[i].row_bytes - 1]);
    }
  return padded;
}

/// Bytes that the codec allocated.
struct TurboBytes {
  unsigned char* data = nullptr;
  unsigned long size = 0;
  ~TurboBytes() { tjFree(data); }
};

}  // namespace

void DecodeJpeg(std::span<const std::uint8_t> bytes, JpegColour colour, ToneCurve tone_curve, Image& into) {
  const TurboHandle handle(tjInitDecompress());
  const JpegHeader header = ReadHeader(handle.get(), bytes);
  if (const auto planar = PlanarFormat(header); planar && colour == JpegColour::kYuv) {
    Shape(into, *planar, header, tone_curve);
    return DecodePlanar(handle.get(), bytes, header, into);
  }
  const bool grey = header.colour_space == TJCS_GRAY;
  Shape(into, grey ? PixelFormat::kMono8 : PixelFormat::kBgr8, header, tone_curve);
  CheckTurbo(tjDecompress2(handle.get(), bytes.data(), bytes.size(), into.bytes().data(), header.width, 0,
                           header.height, grey ? TJPF_GRAY : TJPF_BGR, kFlags),
             handle.get());
}

Image ImageFromJpeg(std::span<const std::uint8_t> bytes, JpegColour colour, ToneCurve tone_curve) {
  Image image;
  DecodeJpeg(bytes, colour, tone_curve, image);
  return image;
}

bool JpegHolds(PixelFormat format, YuvRange range) {
  switch (format) {
    case PixelFormat::kMono8:
    case PixelFormat::kBgr8:
    case PixelFormat::kRgb8: return true;
    case PixelFormat::kYuv420p:
    case PixelFormat::kYuv422p:
    case PixelFormat::kYuv444p: return range == YuvRange::kFull;
    default: return false;
  }
}

std::vector<std::uint8_t> JpegFromImage(const ImageView& image, const JpegOptions& options) {
  CHEQUER_CHECK(JpegHolds(image.format(), image.yuv_range()), "JPEG cannot hold that format");
  CHEQUER_CHECK(options.quality >= 1 && options.quality <= 100, "JPEG quality must be from 1 to 100");
  const TurboHandle handle(tjInitCompress());
  TurboBytes out;
  int status = 0;
  if (IsYuv(image.format())) {
    const int sampling = TurboSampling(image.format());
    PaddedPlanes planes = PadPlanes(image, sampling);
    std::array<const unsigned char*, 3> data{planes.data[0], planes.data[1], planes.data[2]};
    status = tjCompressFromYUVPlanes(handle.get(), data.data(), image.width(), planes.strides.data(), image.height(),
                                     sampling, &out.data, &out.size, options.quality, kFlags);
  } else {
    constexpr std::array<int, 3> kSampling{TJSAMP_444, TJSAMP_422, TJSAMP_420};
    const bool grey = image.format() == PixelFormat::kMono8;
    const int pixels = grey ? TJPF_GRAY : image.format() == PixelFormat::kBgr8 ? TJPF_BGR : TJPF_RGB;
    const int sampling = grey ? int{TJSAMP_GRAY} : kSampling[static_cast<std::size_t>(options.chroma)];
    status = tjCompress2(handle.get(), image.row(0), image.width(), static_cast<int>(image.plane(0).stride_bytes),
                         image.height(), pixels, &out.data, &out.size, sampling, options.quality, kFlags);
  }
  if (status != 0) throw std::runtime_error(std::string("encoding a JPEG: ") + tjGetErrorStr2(handle.get()));
  return {out.data, out.data + out.size};
}

}  // namespace chequer
