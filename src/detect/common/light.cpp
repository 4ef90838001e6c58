#include "detect/common/light.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace chequer {
namespace {

/// BT.601, as JPEG and V4L2's webcams use it: R' = Y + a V, B' = Y + b U, G' by difference.
struct YuvScale {
  float y_offset, y_scale, chroma_scale;
};
constexpr YuvScale kFullRange{0, 1, 1};
constexpr YuvScale kLimitedRange{16, 255.0f / 219.0f, 255.0f / 224.0f};

const YuvScale& ScaleOf(const ImageView& image) {
  return image.yuv_range() == YuvRange::kFull ? kFullRange : kLimitedRange;
}

LightReader::Codes RgbOfYuv(const LightReader::Codes& yuv, const YuvScale& scale) {
  const float l = (yuv[0] - scale.y_offset) * scale.y_scale;
  const float cb = (yuv[1] - 128) * scale.chroma_scale, cr = (yuv[2] - 128) * scale.chroma_scale;
  return {l + 1.402f * cr, l - 0.344136f * cb - 0.714136f * cr, l + 1.772f * cb};
}

/// Light at a value between two codes, or beyond the first or last.
float LightAtCode(const std::array<float, 256>& table, float code) {
  code = std::clamp(code, 0.0f, 255.0f);
  const std::size_t below = static_cast<std::size_t>(code), above = std::min<std::size_t>(below + 1, 255);
  return table[below] + (code - static_cast<float>(below)) * (table[above] - table[below]);
}

std::optional<LightReader::Mosaic> MosaicOf(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBayerRg8: return LightReader::Mosaic{0, 0};
    case PixelFormat::kBayerGr8: return LightReader::Mosaic{1, 0};
    case PixelFormat::kBayerGb8: return LightReader::Mosaic{0, 1};
    case PixelFormat::kBayerBg8: return LightReader::Mosaic{1, 1};
    default: return std::nullopt;
  }
}

/// Bytes from one pixel of a row to the next, in the first plane.
int StepOf(PixelFormat format) {
  switch (format) {
    case PixelFormat::kBgr8:
    case PixelFormat::kRgb8: return 3;
    case PixelFormat::kYuyv:
    case PixelFormat::kUyvy: return 2;
    default: return 1;
  }
}

/// Of a pixel of a mosaic, bilinearly.
LightReader::Codes InterpolatedAt(const ImageView& image, const LightReader& reader, int x, int y) {
  LightReader::Codes sum = LightReader::Codes::Zero(), weight = sum;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int at_x = x + dx, at_y = y + dy;
      if (at_x < 0 || at_y < 0 || at_x >= image.width() || at_y >= image.height()) continue;
      const int channel = reader.ChannelOf(at_x & 1, at_y & 1);
      const float share = static_cast<float>((2 - dx * dx) * (2 - dy * dy));
      sum[channel] += share * image.row(at_y)[at_x];
      weight[channel] += share;
    }
  return sum / weight.max(1);
}

/// Bytes of a short row of pixels with three colours, which are summed side by side, with those that follow.
constexpr int kShortRow = 16;
using ByteSums = std::array<std::uint16_t, kShortRow>;

/// Down the columns of bytes of so many rows, at most kShortRow.
ByteSums SumRows(const std::uint8_t* row, std::ptrdiff_t stride, int rows) {
  ByteSums sums{};
  for (; rows > 0; --rows, row += stride)
    for (std::size_t k = 0; k < kShortRow; ++k) sums[k] = static_cast<std::uint16_t>(sums[k] + row[k]);
  return sums;
}

/// First of `size` pixels around `at`, of `all`.
int FirstAround(float at, int size, int all) {
  const int first = static_cast<int>(at - 0.5f * static_cast<float>(size - 1) + 0.5f);
  return std::clamp(first, 0, all - size);
}

}  // namespace

LightReader::LightReader(const ImageView& image, const std::array<float, 256>& table)
    : image_(image), table_(table), mosaic_(MosaicOf(image.format())), step_(StepOf(image.format())) {
  if (!IsYuv(image.format()) || image.yuv_range() == YuvRange::kFull) return;
  limited_luma_.emplace();
  for (std::size_t y = 0; y < limited_luma_->size(); ++y)
    (*limited_luma_)[y] = LightAtCode(table, (static_cast<float>(y) - kLimitedRange.y_offset) * kLimitedRange.y_scale);
}

LightReader::Sharing LightReader::chroma_sharing() const {
  switch (image_.format()) {
    case PixelFormat::kYuyv:
    case PixelFormat::kUyvy:
    case PixelFormat::kYuv422p: return {2, 1};
    case PixelFormat::kNv12:
    case PixelFormat::kYuv420p: return {2, 2};
    default: return {1, 1};
  }
}

LightReader::Codes LightReader::CodesAt(int x, int y) const {
  const std::uint8_t* row = image_.row(y);
  switch (image_.format()) {
    case PixelFormat::kBgr8: return Codes(row[3 * x + 2], row[3 * x + 1], row[3 * x]);
    case PixelFormat::kRgb8: return Codes(row[3 * x], row[3 * x + 1], row[3 * x + 2]);
    case PixelFormat::kMono8: return Codes::Constant(row[x]);
    case PixelFormat::kBayerRg8:
    case PixelFormat::kBayerGr8:
    case PixelFormat::kBayerGb8:
    case PixelFormat::kBayerBg8: return InterpolatedAt(image_, *this, x, y);
    default: {
      const auto [luma, u, v] = YuvAt(x, y);
      return Codes(static_cast<float>(luma), static_cast<float>(u), static_cast<float>(v));
    }
  }
}

Eigen::Vector3f LightReader::LightOf(const Codes& codes) const {
  const Codes rgb = IsYuv(image_.format()) ? RgbOfYuv(codes, ScaleOf(image_)) : codes;
  return {LightAtCode(table_, rgb[0]), LightAtCode(table_, rgb[1]), LightAtCode(table_, rgb[2])};
}

LightReader::Codes LightReader::CodesOf(const Eigen::Vector3f& light) const {
  const auto code_of = [&](float value) {
    const auto above = std::upper_bound(table_.begin() + 1, table_.end() - 1, value);
    const float below = *(above - 1), code = static_cast<float>(above - table_.begin() - 1);
    return std::clamp(code + (value - below) / (*above - below), 0.0f, 255.0f);
  };
  const Codes rgb(code_of(light[0]), code_of(light[1]), code_of(light[2]));
  if (!IsYuv(image_.format())) return rgb;
  const YuvScale& scale = ScaleOf(image_);
  const float l = 0.299f * rgb[0] + 0.587f * rgb[1] + 0.114f * rgb[2];
  return {l / scale.y_scale + scale.y_offset, 128 + (rgb[2] - l) / 1.772f / scale.chroma_scale,
          128 + (rgb[0] - l) / 1.402f / scale.chroma_scale};
}

int LightReader::ChannelOf(int x_parity, int y_parity) const {
  if (!mosaic_) return 0;
  const bool red_col = x_parity == mosaic_->red_x, red_row = y_parity == mosaic_->red_y;
  return red_col && red_row ? 0 : (red_col || red_row ? 1 : 2);
}

void LightReader::Rows::Negate(float from, std::array<float, 256>& table) {
  std::copy_n(table_, table.size(), table.begin());
  for (auto light = table.rbegin(); light != table.rend() && *light >= from; ++light) *light = -from;
  table_ = table.data();
}

LightReader::Rows LightReader::AllRows() const {
  Rows rows;
  rows.base_ = image_.row(0);
  rows.table_ = limited_luma_ ? limited_luma_->data() : table_.data();
  rows.step_ = step_;
  if (height() > 1) rows.stride_ = image_.row(1) - image_.row(0);
  const PixelFormat format = image_.format();
  if (format == PixelFormat::kUyvy) rows.offset_ = {{{1, 1}, {1, 1}}};
  if (step_ != 3) return rows;
  const bool bgr = format == PixelFormat::kBgr8;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) {
      const int channel = mosaic_ ? ChannelOf(x, y) : 1;
      rows.offset_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = bgr ? 2 - channel : channel;
    }
  if (!mosaic_) rows.red_ = bgr ? 1 : -1;
  return rows;
}

std::array<int, 3> LightReader::YuvAt(int x, int y) const {
  const std::uint8_t* row = image_.row(y);
  switch (image_.format()) {
    case PixelFormat::kYuyv: {
      const std::uint8_t* p = row + 4 * (x / 2);
      return {row[2 * x], p[1], p[3]};
    }
    case PixelFormat::kUyvy: {
      const std::uint8_t* p = row + 4 * (x / 2);
      return {row[2 * x + 1], p[0], p[2]};
    }
    case PixelFormat::kNv12: {
      const std::uint8_t* p = image_.row(y / 2, 1) + 2 * (x / 2);
      return {row[x], p[0], p[1]};
    }
    default: {
      const int cx = image_.format() == PixelFormat::kYuv444p ? x : x / 2;
      const int cy = image_.format() == PixelFormat::kYuv420p ? y / 2 : y;
      return {row[x], image_.row(cy, 1)[cx], image_.row(cy, 2)[cx]};
    }
  }
}

Eigen::Vector3f LightReader::LightOfYuv(const Codes& yuv) const {
  const Codes rgb = RgbOfYuv(yuv, ScaleOf(image_));
  const auto light = [&](float value) {
    return table_[static_cast<std::size_t>(std::clamp(value + 0.5f, 0.0f, 255.0f))];
  };
  return {light(rgb[0]), light(rgb[1]), light(rgb[2])};
}

Eigen::Vector3f LightReader::RgbAt(int x, int y) const {
  const std::uint8_t* row = image_.row(y);
  switch (image_.format()) {
    case PixelFormat::kBgr8: return {table_[row[3 * x + 2]], table_[row[3 * x + 1]], table_[row[3 * x]]};
    case PixelFormat::kRgb8: return {table_[row[3 * x]], table_[row[3 * x + 1]], table_[row[3 * x + 2]]};
    case PixelFormat::kMono8: return Eigen::Vector3f::Constant(table_[row[x]]);
    default: {
      const auto [luma, u, v] = YuvAt(x, y);
      return LightOfYuv({static_cast<float>(luma), static_cast<float>(u), static_cast<float>(v)});
    }
  }
}

void LightReader::Prefetch(const PixelBox& box) const {
  constexpr std::ptrdiff_t kLine = 64, kWidest = 1024;
  if (!(box.left <= box.right)) return;
  const auto pixel = [](float at, int size) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(size - 1)));
  };
  const std::ptrdiff_t first = step_ * pixel(box.left, width()), last = step_ * pixel(box.right, width());
  if (last - first > kWidest) return;
  const int top = pixel(box.top, height()), bottom = pixel(box.bottom, height());
  const std::ptrdiff_t to_next = height() > 1 ? image_.row(1) - image_.row(0) : 0;
  const std::uint8_t* row = image_.row(top);
  for (int y = top; y <= bottom; ++y, row += to_next) {
    for (std::ptrdiff_t at = first; at < last; at += kLine) __builtin_prefetch(row + at, 0, 1);
    __builtin_prefetch(row + last, 0, 1);
  }
}

Eigen::Vector3f LightReader::Rgb(float x, float y, float half_px) const {
  x = std::clamp(x, 0.0f, static_cast<float>(width() - 1));
  y = std::clamp(y, 0.0f, static_cast<float>(height() - 1));
  // Rounded without the library, whose functions cost a call where the processor may be of any age. What lies left of
  // or above the image is cut off below.
  const auto ceil = [](float at) {
    const int whole = static_cast<int>(at);
    return whole + (static_cast<float>(whole) < at);
  };
  int x0 = ceil(x - half_px), x1 = static_cast<int>(x + half_px);
  int y0 = ceil(y - half_px), y1 = static_cast<int>(y + half_px);
  const bool bayer = IsBayer(image_.format());
  const int more = bayer ? 1 : 0;
  if (x1 < x0 + more) x0 = static_cast<int>(bayer ? x : x + 0.5f), x1 = x0 + more;
  if (y1 < y0 + more) y0 = static_cast<int>(bayer ? y : y + 0.5f), y1 = y0 + more;
  if (x1 > width() - 1) x0 -= x1 - (width() - 1), x1 = width() - 1;
  if (y1 > height() - 1) y0 -= y1 - (height() - 1), y1 = height() - 1;
  x0 = std::max(x0, 0);
  y0 = std::max(y0, 0);
  if (bayer) return MosaicMean(x0, y0, x1, y1);
  const float pixels = static_cast<float>((x1 - x0 + 1) * (y1 - y0 + 1));
  if (image_.format() == PixelFormat::kBgr8 || image_.format() == PixelFormat::kRgb8) {
    float sum[3] = {0, 0, 0};
    for (int yy = y0; yy <= y1; ++yy) {
      // Row by row, so that the rows' sums do not wait for each other.
      float row[3] = {0, 0, 0};
      const std::uint8_t* p = image_.row(yy) + 3 * x0;
      for (int xx = x0; xx <= x1; ++xx, p += 3)
        for (int c = 0; c < 3; ++c) row[c] += table_[p[c]];
      for (int c = 0; c < 3; ++c) sum[c] += row[c];
    }
    const int red = image_.format() == PixelFormat::kBgr8 ? 2 : 0;
    return Eigen::Vector3f(sum[red], sum[1], sum[2 - red]) / pixels;
  }
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int yy = y0; yy <= y1; ++yy)
    for (int xx = x0; xx <= x1; ++xx) sum += RgbAt(xx, yy);
  return sum / pixels;
}

Eigen::Vector3f LightReader::MosaicMean(int x0, int y0, int x1, int y1) const {
  // By row and column of the window, odd or even. A row's sums stay in registers.
  float sums[2][2] = {};
  for (int y = y0; y <= y1; ++y) {
    const std::uint8_t* row = image_.row(y);
    float even = 0, odd = 0;
    int x = x0;
    for (; x < x1; x += 2) {
      even += table_[row[x]];
      odd += table_[row[x + 1]];
    }
    if (x == x1) even += table_[row[x]];
    sums[(y - y0) & 1][0] += even;
    sums[(y - y0) & 1][1] += odd;
  }
  Eigen::Vector3f light = Eigen::Vector3f::Zero();
  std::array<int, 3> pixels{};
  for (int row = 0; row < 2; ++row)
    for (int col = 0; col < 2; ++col) {
      const int channel = ChannelOf((x0 + col) & 1, (y0 + row) & 1);
      light[channel] += sums[row][col];
      pixels[static_cast<std::size_t>(channel)] += (x1 - x0 + 2 - col) / 2 * ((y1 - y0 + 2 - row) / 2);
    }
  for (int channel = 0; channel < 3; ++channel)
    light[channel] /= static_cast<float>(std::max(pixels[static_cast<std::size_t>(channel)], 1));
  return light;
}

Eigen::Vector3f LightReader::RoughRgb(float x, float y, float half_px) const {
  const bool bayer = IsBayer(image_.format());
  const int least = bayer ? 2 : 1, most = std::min(width(), height());
  const int size = std::min(std::max(static_cast<int>(2 * half_px), least), most);
  const int x0 = FirstAround(std::clamp(x, 0.0f, static_cast<float>(width() - 1)), size, width()),
            y0 = FirstAround(std::clamp(y, 0.0f, static_cast<float>(height() - 1)), size, height());
  if (size == least) return bayer ? RgbOfTile(x0, y0) : RgbAt(x0, y0);
  const Codes codes = bayer ? MeanOfMosaic(x0, y0, size) : MeanOfPixels(x0, y0, size);
  if (IsYuv(image_.format())) return LightOfYuv(codes);
  return {LightAtCode(table_, codes[0]), LightAtCode(table_, codes[1]), LightAtCode(table_, codes[2])};
}

Eigen::Vector3f LightReader::RgbOfTile(int x0, int y0) const {
  const std::uint8_t* const rows[2] = {image_.row(y0) + x0, image_.row(y0 + 1) + x0};
  const int row = (y0 ^ mosaic_->red_y) & 1, col = (x0 ^ mosaic_->red_x) & 1;  // of red; blue lies opposite
  const auto light = [&](int of_row, int of_col) { return table_[rows[of_row][of_col]]; };
  return {light(row, col), (light(row, 1 - col) + light(1 - row, col)) / 2, light(1 - row, 1 - col)};
}

LightReader::Codes LightReader::MeanOfPixels(int x0, int y0, int size) const {
  const float pixels = static_cast<float>(size * size);
  if (step_ == 3 && 3 * size <= kShortRow && 3 * (width() - x0) >= kShortRow) {
    std::array<int, 3> sum{};
    const ByteSums bytes = SumRows(image_.row(y0) + 3 * x0, image_.row(1) - image_.row(0), size);
    for (std::size_t at = 0, end = static_cast<std::size_t>(3 * size); at < end; at += 3)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += bytes[at + c];
    if (image_.format() == PixelFormat::kBgr8) std::swap(sum[0], sum[2]);
    return Eigen::Array3i(sum[0], sum[1], sum[2]).cast<float>() / pixels;
  }
  // Whole numbers below 2²⁴: exact.
  Codes sum = Codes::Zero();
  for (int y = y0; y < y0 + size; ++y)
    for (int x = x0; x < x0 + size; ++x) sum += CodesAt(x, y);
  return sum / pixels;
}

LightReader::Codes LightReader::MeanOfMosaic(int x0, int y0, int size) const {
  // By row and column of the square, odd or even.
  std::array<std::array<int, 2>, 2> sums{};
  for (int row = 0; row < size; ++row) {
    const std::uint8_t* p = image_.row(y0 + row) + x0;
    int even = 0, odd = 0;
    for (int col = 0; col + 1 < size; col += 2) even += p[col], odd += p[col + 1];
    if (size % 2) even += p[size - 1];
    std::array<int, 2>& sum = sums[static_cast<std::size_t>(row % 2)];
    sum[0] += even;
    sum[1] += odd;
  }
  // Red and blue lie in opposite places of the tile, the greens in the other two.
  const std::size_t red_row = static_cast<std::size_t>((y0 ^ mosaic_->red_y) & 1),
                    red_col = static_cast<std::size_t>((x0 ^ mosaic_->red_x) & 1);
  const std::array<int, 2> in_line{(size + 1) / 2, size / 2};
  const auto pixels = [&](std::size_t row, std::size_t col) { return in_line[row] * in_line[col]; };
  const std::size_t row = 1 - red_row, col = 1 - red_col;
  const Eigen::Array3i sum(sums[red_row][red_col], sums[red_row][col] + sums[row][red_col], sums[row][col]);
  const Eigen::Array3i count(pixels(red_row, red_col), pixels(red_row, col) + pixels(row, red_col), pixels(row, col));
  return sum.cast<float>() / count.cast<float>();
}

namespace {

/// How far values lie from the mean of four neighbours, in steps of the 8-bit code at that value. The mean is taken
/// both of light and of coded values: cameras interpolate before their curve, programs often after it.
struct OffNeighbours {
  double in_light = 0, coded = 0;

  void Add(const ImageView& image, const std::array<float, 256>& table, int channel, int x, int y,
           const std::array<int, 4>& dx, const std::array<int, 4>& dy) {
    float light_mean = 0, coded_mean = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint8_t value = image.row(y + dy[k])[3 * (x + dx[k]) + channel];
      light_mean += 0.25f * table[value];
      coded_mean += 0.25f * static_cast<float>(value);
    }
    const int value = image.row(y)[3 * x + channel];
    const std::size_t low = static_cast<std::size_t>(std::max(value - 1, 0)),
                      high = static_cast<std::size_t>(std::min(value + 1, 255));
    const float step = (table[high] - table[low]) / static_cast<float>(high - low);
    // Bounded, so that a few overshooting pixels do not decide.
    in_light += std::min(std::abs(table[static_cast<std::size_t>(value)] - light_mean) / step, 8.0f);
    coded += std::min(std::abs(static_cast<float>(value) - coded_mean), 8.0f);
  }
};

/// What tells an interpolated mosaic, on average, in steps: least and most that values are off. Rounding alone leaves
/// 0.25 to 0.45.
struct MosaicBounds {
  double most_interpolated, least_measured;
};
constexpr MosaicBounds kFair{0.6, 1.5};
/// The same where a part of the window is to decide. Means of interpolated values have a deviation of 0.03 by then,
/// those of measured ones of 0.2 (of the fewest pixels, by the values' own deviations of 0.3 and 2).
constexpr MosaicBounds kClear{0.5, 2};
/// Where a part shows more than this everywhere, none of it was interpolated (a guess, twice what may be).
constexpr double kNotInterpolated = 1.2;
/// Fewer pixels of each site tell nothing.
constexpr int kFewestOfSite = 40;

/// Of the pixels of a window, by parities.
struct MosaicSums {
  std::array<OffNeighbours, 2> green{};  ///< of x + y
  std::array<OffNeighbours, 4> red{};    ///< of x (1) and y (2)
  std::array<int, 4> count{};            ///< the same

  bool are_enough() const { return *std::min_element(count.begin(), count.end()) >= kFewestOfSite; }
  /// Nothing where these pixels do not decide it. @pre are_enough()
  std::optional<LightReader::Mosaic> Decide(const MosaicBounds& bounds) const {
    if (auto mosaic = DecideBy(&OffNeighbours::in_light, bounds)) return mosaic;
    return DecideBy(&OffNeighbours::coded, bounds);
  }
  bool AreOfNone() const {
    const double most = kNotInterpolated * 2 * count[0];
    return std::ranges::all_of(green,
                               [&](const OffNeighbours& off) { return off.in_light > most && off.coded > most; });
  }

 private:
  std::optional<LightReader::Mosaic> DecideBy(double OffNeighbours::*member, const MosaicBounds& bounds) const {
    const int least = *std::min_element(count.begin(), count.end());
    const auto differ = [&](const OffNeighbours& interpolated, const OffNeighbours& measured, double pixels) {
      return interpolated.*member <= bounds.most_interpolated * pixels &&
             measured.*member >= bounds.least_measured * pixels;
    };
    const std::size_t interpolated = green[0].*member < green[1].*member ? 0 : 1;
    if (!differ(green[interpolated], green[1 - interpolated], 2.0 * least)) return std::nullopt;
    // Red and blue sites have interpolated green; red is interpolated from the diagonals at the blue ones.
    const std::size_t a = interpolated == 0 ? 0 : 1, b = interpolated == 0 ? 3 : 2;
    const std::size_t blue = red[a].*member < red[b].*member ? a : b;
    const std::size_t red_site = blue == a ? b : a;
    if (!differ(red[blue], red[red_site], least)) return std::nullopt;
    return LightReader::Mosaic{static_cast<int>(red_site & 1), static_cast<int>(red_site >> 1)};
  }
};

}  // namespace

std::optional<LightReader::Mosaic> FindInterpolatedMosaic(const ImageView& image, const std::array<float, 256>& table,
                                                          int x0, int y0, int x1, int y1) {
  if (image.format() != PixelFormat::kBgr8 && image.format() != PixelFormat::kRgb8) return std::nullopt;
  const int red = image.format() == PixelFormat::kBgr8 ? 2 : 0;
  constexpr std::array<int, 4> kCrossX{1, -1, 0, 0}, kCrossY{0, 0, 1, -1}, kDiagonalX{1, 1, -1, -1},
      kDiagonalY{1, -1, 1, -1};
  x0 = std::max(x0, 1), x1 = std::min(x1, image.width() - 2);
  y0 = std::max(y0, 1), y1 = std::min(y1, image.height() - 2);
  MosaicSums sums;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const std::size_t site = static_cast<std::size_t>((x & 1) + 2 * (y & 1));
      sums.green[static_cast<std::size_t>((x + y) & 1)].Add(image, table, 1, x, y, kCrossX, kCrossY);
      sums.red[site].Add(image, table, red, x, y, kDiagonalX, kDiagonalY);
      ++sums.count[site];
    }
    // After every other row, there are as many of each site.
    if ((y - y0) % 2 == 0 || !sums.are_enough()) continue;
    if (const auto mosaic = sums.Decide(kClear)) return mosaic;
    if (sums.AreOfNone()) return std::nullopt;
  }
  return sums.are_enough() ? sums.Decide(kFair) : std::nullopt;
}

}  // namespace chequer
