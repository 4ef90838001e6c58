#include "chequer/image.h"

#include <algorithm>
#include <utility>

#include "chequer/check.h"

namespace chequer {
namespace {

constexpr std::array<std::pair<PixelFormat, std::string_view>, 13> kNames{{
    {PixelFormat::kMono8, "Mono8"},
    {PixelFormat::kBgr8, "BGR8"},
    {PixelFormat::kRgb8, "RGB8"},
    {PixelFormat::kBayerRg8, "BayerRG8"},
    {PixelFormat::kBayerGb8, "BayerGB8"},
    {PixelFormat::kBayerGr8, "BayerGR8"},
    {PixelFormat::kBayerBg8, "BayerBG8"},
    {PixelFormat::kYuyv, "YUYV"},
    {PixelFormat::kUyvy, "UYVY"},
    {PixelFormat::kNv12, "NV12"},
    {PixelFormat::kYuv420p, "YUV420P"},
    {PixelFormat::kYuv422p, "YUV422P"},
    {PixelFormat::kYuv444p, "YUV444P"},
}};

std::array<Plane, 3> PackedPlanes(PixelFormat format, int width, int height, const std::uint8_t* data) {
  std::array<Plane, 3> planes;
  const auto shapes = PlaneShapes(format, width, height);
  for (std::size_t i = 0; i < planes.size() && shapes[i].rows > 0; ++i) {
    planes[i] = {data, shapes[i].row_bytes};
    data += static_cast<std::size_t>(shapes[i].row_bytes) * static_cast<std::size_t>(shapes[i].rows);
  }
  return planes;
}

}  // namespace

std::string_view PixelFormatName(PixelFormat format) {
  return std::find_if(kNames.begin(), kNames.end(), [&](const auto& entry) { return entry.first == format; })->second;
}

std::optional<PixelFormat> ParsePixelFormat(std::string_view name) {
  for (const auto& [format, known] : kNames)
    if (known == name) return format;
  return std::nullopt;
}

std::string PixelFormatNames() {
  std::string text;
  for (const auto& [format, name] : kNames) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

bool IsBayer(PixelFormat format) { return format >= PixelFormat::kBayerRg8 && format <= PixelFormat::kBayerBg8; }
bool IsYuv(PixelFormat format) { return format >= PixelFormat::kYuyv; }

std::array<PlaneShape, 3> PlaneShapes(PixelFormat format, int width, int height) {
  const int half_width = (width + 1) / 2;
  const int half_height = (height + 1) / 2;
  switch (format) {
    case PixelFormat::kBgr8:
    case PixelFormat::kRgb8: return {{{3 * width, height}, {}, {}}};
    case PixelFormat::kYuyv:
    case PixelFormat::kUyvy: return {{{2 * width, height}, {}, {}}};
    case PixelFormat::kNv12: return {{{width, height}, {2 * half_width, half_height}, {}}};
    case PixelFormat::kYuv420p: return {{{width, height}, {half_width, half_height}, {half_width, half_height}}};
    case PixelFormat::kYuv422p: return {{{width, height}, {half_width, height}, {half_width, height}}};
    case PixelFormat::kYuv444p: return {{{width, height}, {width, height}, {width, height}}};
    default: return {{{width, height}, {}, {}}};
  }
}

std::size_t PackedSize(PixelFormat format, int width, int height) {
  std::size_t size = 0;
  for (const PlaneShape& shape : PlaneShapes(format, width, height))
    size += static_cast<std::size_t>(shape.row_bytes) * static_cast<std::size_t>(shape.rows);
  return size;
}

bool SizeIsValid(PixelFormat format, int width, int height) {
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide) return false;
  switch (format) {
    case PixelFormat::kYuyv:
    case PixelFormat::kUyvy: return width % 2 == 0;
    case PixelFormat::kNv12: return width % 2 == 0 && height % 2 == 0;
    default: return true;
  }
}

ImageView::ImageView(PixelFormat format, int width, int height, std::span<const Plane> planes, ToneCurve tone_curve,
                     YuvRange yuv_range)
    : format_(format), width_(width), height_(height), tone_curve_(tone_curve), yuv_range_(yuv_range) {
  CHEQUER_CHECK(SizeIsValid(format, width, height), "image size not valid for its format");
  const auto shapes = PlaneShapes(format, width, height);
  for (std::size_t i = 0; i < shapes.size() && shapes[i].rows > 0; ++i) {
    CHEQUER_CHECK(i < planes.size() && planes[i].data != nullptr, "image plane missing");
    CHEQUER_CHECK(planes[i].stride_bytes >= shapes[i].row_bytes, "stride shorter than a row");
    planes_[i] = planes[i];
  }
}

std::optional<ImageView> ViewPacked(PixelFormat format, int width, int height, std::span<const std::uint8_t> bytes,
                                    ToneCurve tone_curve, YuvRange yuv_range) {
  if (!SizeIsValid(format, width, height) || bytes.size() < PackedSize(format, width, height)) return std::nullopt;
  return ImageView(format, width, height, PackedPlanes(format, width, height, bytes.data()), tone_curve, yuv_range);
}

Image::Image(PixelFormat format, int width, int height, ToneCurve tone_curve, YuvRange yuv_range)
    : format_(format), width_(width), height_(height), tone_curve_(tone_curve), yuv_range_(yuv_range) {
  CHEQUER_CHECK(SizeIsValid(format, width, height), "image size not valid for its format");
  bytes_.resize(PackedSize(format, width, height));
}

ImageView Image::view() const {
  if (empty()) return {};
  return ImageView(format_, width_, height_, PackedPlanes(format_, width_, height_, bytes_.data()), tone_curve_,
                   yuv_range_);
}

}  // namespace chequer
