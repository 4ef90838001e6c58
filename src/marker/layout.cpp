#include <charconv>

#include "chequer/check.h"
#include "chequer/marker.h"

namespace chequer {
namespace {

constexpr int kMaxKernelBits = 64;
/// A board of three columns with kMaxKernelBits kernel cells.
constexpr int kMaxSide = kMaxKernelBits + 2;

/// Reads a number that takes up the whole text, digits only.
std::optional<int> ParseDigits(std::string_view text) {
  if (text.empty() || text.find_first_not_of("0123456789") != std::string_view::npos) return std::nullopt;
  int value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{}) return std::nullopt;
  return value;
}

}  // namespace

bool IsValid(MarkerSize size) {
  // The bound on the sides comes first so that the product cannot overflow.
  if (size.rows < 3 || size.cols < 3 || size.rows > kMaxSide || size.cols > kMaxSide) return false;
  return KernelBits(size) <= kMaxKernelBits;
}

std::optional<MarkerSize> ParseMarkerSize(std::string_view text) {
  const std::size_t x = text.find('x');
  if (x == std::string_view::npos) return std::nullopt;
  const std::optional<int> rows = ParseDigits(text.substr(0, x));
  const std::optional<int> cols = ParseDigits(text.substr(x + 1));
  if (!rows || !cols || !IsValid({*rows, *cols})) return std::nullopt;
  return MarkerSize{*rows, *cols};
}

std::string ToString(MarkerSize size) { return std::to_string(size.rows) + "x" + std::to_string(size.cols); }

std::vector<Cell> BorderCells(MarkerSize size) {
  CHEQUER_CHECK(IsValid(size), "not a size of a marker");
  std::vector<Cell> cells;
  cells.reserve(static_cast<std::size_t>(BorderLength(size)));
  const int last_row = size.rows - 1;
  const int last_col = size.cols - 1;
  for (int col = 0; col < last_col; ++col) cells.push_back({0, col});
  for (int row = 0; row < last_row; ++row) cells.push_back({row, last_col});
  for (int col = last_col; col > 0; --col) cells.push_back({last_row, col});
  for (int row = last_row; row > 0; --row) cells.push_back({row, 0});
  return cells;
}

std::vector<std::uint8_t> BorderSaturation(MarkerSize size) {
  CHEQUER_CHECK(IsValid(size), "not a size of a marker");
  constexpr std::array<std::uint8_t, 4> kCycle{0, 1, 1, 0};
  const auto length = static_cast<std::size_t>(BorderLength(size));
  // Where luminance looks the same after a half turn, the second half ring is the complement of the first, so that a
  // half turn changes every border cell. Elsewhere luminance alone tells the turn and the cycle runs all round.
  const bool luminance_survives_half_turn = (size.rows + size.cols) % 2 == 0;
  const std::size_t half = length / 2;
  std::vector<std::uint8_t> saturation(length);
  for (std::size_t k = 0; k < length; ++k) {
    const bool complemented = luminance_survives_half_turn && k >= half;
    saturation[k] = complemented ? static_cast<std::uint8_t>(1 - kCycle[(k - half) % 4]) : kCycle[k % 4];
  }
  return saturation;
}

std::vector<std::uint8_t> CellSaturation(MarkerSize size, std::uint64_t kernel) {
  const auto cols = static_cast<std::size_t>(size.cols);
  const std::vector<Cell> border_cells = BorderCells(size);
  const std::vector<std::uint8_t> border = BorderSaturation(size);
  std::vector<std::uint8_t> saturation(static_cast<std::size_t>(size.rows) * cols);
  for (std::size_t k = 0; k < border.size(); ++k) {
    saturation[static_cast<std::size_t>(border_cells[k].row) * cols + static_cast<std::size_t>(border_cells[k].col)] =
        border[k];
  }
  int bit = KernelBits(size);
  for (std::size_t row = 1; row + 1 < static_cast<std::size_t>(size.rows); ++row) {
    for (std::size_t col = 1; col + 1 < cols; ++col) {
      saturation[row * cols + col] = static_cast<std::uint8_t>(kernel >> --bit & 1);
    }
  }
  return saturation;
}

std::string CellColours(MarkerSize size, std::uint64_t kernel) {
  const std::vector<std::uint8_t> saturation = CellSaturation(size, kernel);
  std::string colours;
  colours.reserve(saturation.size());
  for (const std::uint8_t saturated : saturation) {
    const int index = static_cast<int>(colours.size());
    const bool dark = IsDark(index / size.cols, index % size.cols);
    colours.push_back(dark ? (saturated ? 'B' : 'K') : (saturated ? 'Y' : 'W'));
  }
  return colours;
}

}  // namespace chequer
