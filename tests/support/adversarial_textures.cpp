#include "support/adversarial_textures.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "chequer/marker.h"
#include "simulate/board.h"
#include "simulate/inks.h"
#include "simulate/random.h"

namespace chequer::test {
namespace {

/// Light at a point, pixels.
using Texture = std::function<Eigen::Vector3f(double x, double y)>;

/// Points a pixel along each axis, spread over kBlurPx.
constexpr int kPoints = 3;
constexpr double kBlurPx = 1.4;
/// Standard deviation of a value, levels of 255.
constexpr float kNoise = 1.5f;
/// Of the textures against the image: no cell lies along the pixels.
constexpr double kTurnRad = 0.17;

std::int64_t Floor(double value) { return static_cast<std::int64_t>(std::floor(value)); }

/// Evenly spread bits of a cell of a grid without end.
std::uint64_t BitsOf(std::int64_t col, std::int64_t row, std::uint64_t seed) {
  return Random(DeriveSeed(DeriveSeed(seed, static_cast<std::uint64_t>(col)), static_cast<std::uint64_t>(row))).Bits();
}

bool IsDarkCell(std::int64_t col, std::int64_t row) { return ((col + row) & 1) == 0; }

Texture Chess(double cell_px) {
  return [=](double x, double y) {
    const InkSet inks;
    return inks.Of(IsDarkCell(Floor(x / cell_px), Floor(y / cell_px)) ? 'K' : 'W');
  };
}

Texture InkChess(double cell_px, std::uint64_t seed) {
  return [=](double x, double y) {
    const InkSet inks;
    const std::int64_t col = Floor(x / cell_px), row = Floor(y / cell_px);
    const bool inked = (BitsOf(col, row, seed) >> 20 & 1) != 0;
    return inks.Of(IsDarkCell(col, row) ? (inked ? 'B' : 'K') : (inked ? 'Y' : 'W'));
  };
}

/// Boards of many ids edge to edge: every placement on the period of the border shows what it should.
Texture Borders(double cell_px) {
  const MarkerCode code({6, 6}, Variant::kSecded);
  std::vector<Board> boards;
  for (std::uint64_t id = 0; id < 16; ++id) boards.push_back(MakeBoard(code, id));
  return [=](double x, double y) {
    const InkSet inks;
    const std::int64_t col = Floor(x / cell_px), row = Floor(y / cell_px);
    const auto within = [](std::int64_t at) { return static_cast<std::size_t>(((at % 6) + 6) % 6); };
    const std::uint64_t which = BitsOf(Floor(x / cell_px / 6), Floor(y / cell_px / 6), 1) % boards.size();
    return inks.Of(boards[which].cells[within(row) * 6 + within(col)]);
  };
}

Texture RandomInks(double block_px, std::uint64_t seed) {
  return [=](double x, double y) {
    constexpr std::array kInks{'K', 'W', 'B', 'Y'};
    return InkSet{}.Of(kInks[BitsOf(Floor(x / block_px), Floor(y / block_px), seed) >> 20 & 3]);
  };
}

/// Dots of cyan, magenta and yellow, whose size follows a slow wave, each kind turned by an angle of its own.
Texture Halftone(double pitch_px) {
  return [=](double x, double y) {
    Eigen::Vector3f light = Eigen::Vector3f::Constant(0.85f);
    for (Eigen::Index ink = 0; ink < 3; ++ink) {
      const double turn = 0.26 * static_cast<double>(ink + 1), u = x * std::cos(turn) + y * std::sin(turn),
                   v = y * std::cos(turn) - x * std::sin(turn);
      const double dots = std::cos(2 * std::numbers::pi * u / pitch_px) + std::cos(2 * std::numbers::pi * v / pitch_px);
      if (dots > 1.2 * std::sin(x / 90 + static_cast<double>(ink)) * std::cos(y / 70)) light[ink] *= 0.15f;
    }
    return light;
  };
}

/// Lines of letters made of strokes.
Texture Page(double letter_px, std::uint64_t seed) {
  return [=](double x, double y) {
    const double line = y / (1.6 * letter_px), in_line = (line - std::floor(line)) * 1.6;
    const std::int64_t col = Floor(x / letter_px), row = Floor(line);
    const std::uint64_t bits = BitsOf(col, row, seed);
    if (in_line > 1 || bits % 6 == 0) return Eigen::Vector3f(0.8f, 0.8f, 0.78f);
    const double u = x / letter_px - static_cast<double>(col);
    const auto stroke = [&](double at, double from, int bit) { return (bits >> bit & 1) && std::abs(at - from) < 0.09; };
    const bool black = stroke(u, 0.2, 8) || stroke(u, 0.7, 9) || stroke(in_line, 0.15, 10) || stroke(in_line, 0.5, 11) ||
                       stroke(in_line, 0.85, 12) || stroke(u - 0.5 * in_line, 0.15, 13);
    return Eigen::Vector3f(Eigen::Vector3f::Constant(black ? 0.04f : 0.8f));
  };
}

Texture Noise(double grain_px, std::uint64_t seed) {
  return [=](double x, double y) {
    const std::uint64_t bits = BitsOf(Floor(x / grain_px), Floor(y / grain_px), seed);
    Eigen::Vector3f light;
    for (Eigen::Index i = 0; i < 3; ++i) light[i] = 0.85f * static_cast<float>(bits >> (8 * i + 8) & 255) / 255;
    return light;
  };
}

/// Two gratings a little apart, and rings that grow finer until the pixels no longer follow them.
Texture Moire(double pitch_px) {
  return [=](double x, double y) {
    const double away = std::hypot(x - 300, y - 200), k = 2 * std::numbers::pi / pitch_px;
    const double value = std::cos(k * x) * std::cos(k * 1.03 * (y + 0.02 * x)) + 0.7 * std::cos(away * away / 400);
    return Eigen::Vector3f(Eigen::Vector3f::Constant(static_cast<float>(0.4 + 0.22 * value)));
  };
}

/// Yellow, blue, black and white stripes with jagged rims: strong contrasts among the inks, and no cells.
Texture Stripes(double width_px, std::uint64_t seed) {
  return [=](double x, double y) {
    constexpr std::array kInks{'Y', 'K', 'W', 'B', 'Y', 'B', 'W', 'K'};
    const double jag = (BitsOf(Floor(x / 5), 0, seed) >> 20 & 1) ? 0.4 * width_px : 0;
    return InkSet{}.Of(kInks[static_cast<std::size_t>(Floor((y + jag) / width_px)) % 8]);
  };
}

struct Kind {
  std::string_view name;
  std::vector<int> sizes;  ///< px
  std::function<Texture(double size_px, std::uint64_t seed)> make;
};

const std::vector<Kind>& Kinds() {
  const auto without_seed = [](auto make) { return [make](double size, std::uint64_t) { return make(size); }; };
  static const std::vector<Kind> kinds{{"chess", {4, 6, 10, 20, 40}, without_seed(Chess)},
                                       {"inkchess", {4, 6, 10, 20, 40}, InkChess},
                                       {"borders", {4, 6, 10, 20}, without_seed(Borders)},
                                       {"inks", {3, 6, 12}, RandomInks},
                                       {"halftone", {4, 6, 10}, without_seed(Halftone)},
                                       {"page", {10, 18}, Page},
                                       {"noise", {1, 3, 6}, Noise},
                                       {"moire", {5, 9}, without_seed(Moire)},
                                       {"stripes", {3, 6}, Stripes}};
  return kinds;
}

std::uint8_t Coded(float light, float noise) {
  const float clamped = std::clamp(light, 0.0f, 1.0f);
  const float value = clamped <= 0.0031308f ? 12.92f * clamped : 1.055f * std::pow(clamped, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::clamp(255 * value + noise, 0.0f, 255.0f));
}

Eigen::Vector3f LightAt(const Texture& texture, int x, int y) {
  Eigen::Vector3f light = Eigen::Vector3f::Zero();
  for (int j = 0; j < kPoints; ++j)
    for (int i = 0; i < kPoints; ++i) {
      const double px = x + kBlurPx * ((i + 0.5) / kPoints - 0.5), py = y + kBlurPx * ((j + 0.5) / kPoints - 0.5);
      light += texture(px * std::cos(kTurnRad) - py * std::sin(kTurnRad) + 7.3,
                       px * std::sin(kTurnRad) + py * std::cos(kTurnRad) + 3.1);
    }
  return light / (kPoints * kPoints);
}

}  // namespace

std::vector<std::string> TextureNames() {
  std::vector<std::string> names;
  for (const Kind& kind : Kinds())
    for (const int size : kind.sizes) names.push_back(std::string(kind.name) + std::to_string(size));
  return names;
}

Image DrawTexture(std::string_view name, int width, int height, std::uint64_t seed) {
  const std::size_t digits = name.find_first_of("0123456789");
  const auto kind = std::find_if(Kinds().begin(), Kinds().end(),
                                 [&](const Kind& each) { return each.name == name.substr(0, digits); });
  int size_px = 0;
  if (kind == Kinds().end() || digits == std::string_view::npos ||
      std::from_chars(name.data() + digits, name.data() + name.size(), size_px).ec != std::errc() || size_px < 1)
    throw std::runtime_error("no texture " + std::string(name));
  const Texture texture = kind->make(size_px, seed);
  Random random(seed);
  Image image(PixelFormat::kBgr8, width, height);
  std::uint8_t* byte = image.bytes().data();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3f light = LightAt(texture, x, y);
      for (const Eigen::Index channel : {2, 1, 0}) *byte++ = Coded(light[channel], kNoise * random.Normal());
    }
  return image;
}

}  // namespace chequer::test
