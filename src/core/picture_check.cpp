#include "core/picture_check.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace chequer {
namespace {

/// Less contrast may be noise or the picture's grain, levels.
constexpr int kLeastContrast = 30;
/// Noise goes back and forth by less; an edge ends where the level goes back by more.
constexpr int kTurn = 8;
/// Fewer edges say nothing.
constexpr std::size_t kFewestEdges = 24;
/// The sharpest edges: this share of all. Shadows and round things have wide ones in sharp pictures, too.
constexpr double kSharpest = 0.15;
/// Chance crosses fewer in noise.
constexpr int kFewestOfAll = 4;
/// Noise and black level of a covered sensor stay below, and a dim room's lights above.
constexpr int kMostBlack = 16, kLeastWhite = 250;

/// Grey samples of a plane, the step of one colour apart: Bayer mosaics repeat every other pixel.
struct Samples {
  const std::uint8_t* first = nullptr;
  std::ptrdiff_t column_step = 1, row_step = 0;
  int columns = 0, rows = 0;
  int pixels = 1;  ///< between neighbours
};

Samples SamplesOf(const ImageView& image) {
  Samples samples{image.row(0), 1, image.plane(0).stride_bytes, image.width(), image.height(), 1};
  switch (image.format()) {
    case PixelFormat::kBgr8:
    case PixelFormat::kRgb8:
      samples.first += 1;  // green
      samples.column_step = 3;
      break;
    case PixelFormat::kUyvy: samples.first += 1; [[fallthrough]];
    case PixelFormat::kYuyv: samples.column_step = 2; break;
    case PixelFormat::kBayerRg8:
    case PixelFormat::kBayerBg8:
      samples.first += samples.columns > 1 ? 1 : 0;  // green
      [[fallthrough]];
    case PixelFormat::kBayerGr8:
    case PixelFormat::kBayerGb8:
      samples.column_step = 2;
      samples.row_step *= 2;
      samples.columns = std::max(1, samples.columns / 2);
      samples.rows = std::max(1, samples.rows / 2);
      samples.pixels = 2;
      break;
    default: break;
  }
  return samples;
}

/// Widths of the edges in one line, in samples: the way between two turning points over the steepest step of it.
void FindEdges(const std::uint8_t* first, std::ptrdiff_t step, int count, std::vector<float>& widths) {
  const auto level = [&](int i) { return static_cast<int>(first[step * i]); };
  int low = 0, high = 0;  // the extremes since the last turn
  int rising = 0, steep_up = 1, steep_down = 1;
  const auto end_edge = [&](int contrast, int steepest) {
    if (contrast >= kLeastContrast)
      widths.push_back(2.0f * static_cast<float>(contrast) / static_cast<float>(steepest));
  };
  for (int i = 1; i < count; ++i) {
    // Over two steps: less of the noise, which steps go both ways.
    const int change = i > 1 ? level(i) - level(i - 2) : 0;
    steep_up = std::max(steep_up, change);
    steep_down = std::max(steep_down, -change);
    if (level(i) > level(high)) high = i;
    if (level(i) < level(low)) low = i;
    if (rising >= 0 && level(high) - level(i) > kTurn) {
      if (rising > 0) end_edge(level(high) - level(low), steep_up);
      rising = -1;
      low = i;
      steep_down = std::max(1, -change);
    } else if (rising <= 0 && level(i) - level(low) > kTurn) {
      if (rising < 0) end_edge(level(high) - level(low), steep_down);
      rising = 1;
      high = i;
      steep_up = std::max(1, change);
    }
  }
}

/// Of the lines that are spread over a side, where this one is.
std::ptrdiff_t Middle(int line, int lines, int side) {
  return (2 * static_cast<std::ptrdiff_t>(line) + 1) * side / (2 * static_cast<std::ptrdiff_t>(lines));
}

std::optional<double> SharpestOf(std::vector<float>& widths, int pixels) {
  if (widths.size() < kFewestEdges) return std::nullopt;
  const auto at = widths.begin() + static_cast<std::ptrdiff_t>(kSharpest * static_cast<double>(widths.size()));
  std::nth_element(widths.begin(), at, widths.end());
  return *at * static_cast<double>(pixels);
}

}  // namespace

bool PictureCheck::IsBlack() const { return bright < kMostBlack; }
bool PictureCheck::IsWhite() const { return dark >= kLeastWhite; }
bool PictureCheck::IsBlank() const { return bright - dark < kLeastContrast && edges < kFewestOfAll; }

std::optional<double> PictureCheck::Blur(double least_px) const {
  if (!edge_along_rows_px || !edge_along_columns_px) return std::nullopt;
  const auto [narrow, wide] = std::minmax(*edge_along_rows_px, *edge_along_columns_px);
  return narrow > least_px ? std::optional(wide) : std::nullopt;
}

PictureCheck CheckPicture(const ImageView& image, int lines) {
  PictureCheck check;
  if (image.empty()) return check;
  const Samples samples = SamplesOf(image);
  std::array<std::size_t, 256> histogram{};
  std::size_t total = 0;
  std::vector<float> along_rows, along_columns;
  for (int line = 0; line < lines; ++line) {
    const std::uint8_t* row = samples.first + samples.row_step * Middle(line, lines, samples.rows);
    const std::uint8_t* column = samples.first + samples.column_step * Middle(line, lines, samples.columns);
    FindEdges(row, samples.column_step, samples.columns, along_rows);
    FindEdges(column, samples.row_step, samples.rows, along_columns);
    for (int i = 0; i < samples.columns; ++i, ++total) ++histogram[row[samples.column_step * i]];
  }
  std::size_t below = 0;
  for (int level = 0; level < 256; ++level) {
    below += histogram[static_cast<std::size_t>(level)];
    if (100 * below <= total) check.dark = level;
    if (100 * below < 99 * total) check.bright = level + 1;
  }
  check.edges = static_cast<int>(along_rows.size() + along_columns.size());
  check.edge_along_rows_px = SharpestOf(along_rows, samples.pixels);
  check.edge_along_columns_px = SharpestOf(along_columns, samples.pixels);
  return check;
}

}  // namespace chequer
