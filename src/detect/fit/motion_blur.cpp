#include "detect/fit/motion_blur.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace chequer {
namespace {

/// The shortest and the longest motion blur that is searched for, cells.
constexpr double kLeastMotionBlur = 0.35, kMostMotionBlur = 1.6;
/// The search begins with all motion blurs in steps, of which there are so many at most on either side, and ends with
/// finer ones, cells.
constexpr int kMotionBlurSteps = 16;
constexpr double kMotionBlurStep = kMostMotionBlur / kMotionBlurSteps, kLastMotionBlurStep = 0.005;
constexpr std::array<double, 4> kCoarseBlurs{0.06, 0.12, 0.2, 0.3};
/// Minima that are looked into, and how far apart they are, cells.
constexpr std::size_t kMostMinima = 5;
constexpr double kApartMinima = 0.25;
/// Minima that leave so many times more than the deepest may be the true one: along a side of the cells, few waves
/// tell.
constexpr double kMostOfDeepest = 20;
/// Narrower cells show no harmonics but the first, px.
constexpr double kLeastAcrossPx = 5;
/// Share that a motion blur must leave of what a blur alone leaves unexplained.
constexpr double kLeastGainOfMotionBlur = 0.5;
/// What a blur alone leaves, of all: of boards that only were blurred at most 0.01, blurred by a motion of 0.8 cells
/// 0.045.
constexpr double kMostEvenly = 0.025;
/// Of the lens, cells.
constexpr double kLeastBlurOfMotionBlurred = 0.03, kMostBlurOfMotionBlurred = 0.4;

/// Samples a cell, along each axis, that tell the harmonics.
constexpr int kSamplesOfCell = 10;
/// Cells, along each axis, whose light tells them.
constexpr int kMostCells = 4;
/// The harmonics of a checkerboard that are asked for: m along one axis, n along the other.
constexpr std::array<std::array<int, 2>, 5> kHarmonics{{{1, 1}, {1, 3}, {3, 1}, {1, 5}, {5, 1}}};
/// Of each harmonic, its wave along one diagonal of the cells and its wave along the other.
using Waves = std::array<std::array<double, 2>, kHarmonics.size()>;

/// Means of a patch times its waves' four products of cosines and sines about a point.
struct Products {
  double even = 0, odd = 0, mixed_x = 0, mixed_y = 0;
};

/// Light of points around a corner, row by row, over `cells` cells along each axis, which the corner is the middle of.
struct Patch {
  std::array<double, kMostCells * kMostCells * kSamplesOfCell * kSamplesOfCell> light;
  int cells = 0;

  /// Of harmonic (m, n), about a point (x, y) cells from the corner.
  Products Of(int m, int n, const Eigen::Vector2d& about) const {
    const std::size_t count = static_cast<std::size_t>(cells * kSamplesOfCell);
    const auto phase = [&](std::size_t i, double offset) {
      return std::numbers::pi * ((static_cast<double>(i) + 0.5) / kSamplesOfCell - 0.5 * cells - offset);
    };
    Products products;
    std::array<double, kMostCells * kSamplesOfCell> cosine, sine;
    for (std::size_t i = 0; i < count; ++i)
      cosine[i] = std::cos(m * phase(i, about.x())), sine[i] = std::sin(m * phase(i, about.x()));
    for (std::size_t row = 0; row < count; ++row) {
      double even = 0, odd = 0;
      for (std::size_t col = 0; col < count; ++col) {
        even += light[row * count + col] * cosine[col];
        odd += light[row * count + col] * sine[col];
      }
      const double c = std::cos(n * phase(row, about.y())), s = std::sin(n * phase(row, about.y()));
      products.even += even * c;
      products.odd += odd * s;
      products.mixed_x += odd * c;
      products.mixed_y += even * s;
    }
    const double scale = 1 / static_cast<double>(count * count);
    products.even *= scale, products.odd *= scale, products.mixed_x *= scale, products.mixed_y *= scale;
    return products;
  }
  /// Where the waves of the first harmonic say that the corner lies, cells from where it was thought to.
  Eigen::Vector2d Corner() const {
    const Products of = Of(1, 1, {0, 0});
    // Along each diagonal of the cells, the phase of a wave that is even about the corner.
    const auto phase = [](double sine, double cosine) {
      return std::atan2(cosine < 0 ? -sine : sine, std::abs(cosine));
    };
    const double minus = phase(of.mixed_x - of.mixed_y, of.even + of.odd),
                 plus = phase(of.mixed_x + of.mixed_y, of.even - of.odd);
    return Eigen::Vector2d(plus + minus, plus - minus) / (2 * std::numbers::pi);
  }
};

/// Amplitudes of a checkerboard's waves.
Waves MeasureWaves(const Patch& patch) {
  const Eigen::Vector2d corner = patch.Corner();
  Waves waves{};
  for (std::size_t k = 0; k < kHarmonics.size(); ++k) {
    const Products of = patch.Of(kHarmonics[k][0], kHarmonics[k][1], corner);
    waves[k] = {of.odd + of.even, of.odd - of.even};
  }
  return waves;
}

/// What a motion blur and a blur, cells, leave of a checkerboard's waves.
struct Damping {
  double x = 0, y = 0, blur = 0.1;

  Waves Of() const {
    Waves waves{};
    for (std::size_t k = 0; k < kHarmonics.size(); ++k) {
      const double m = kHarmonics[k][0], n = kHarmonics[k][1];
      const double lens = std::exp(-std::numbers::pi * std::numbers::pi / 2 * blur * blur * (m * m + n * n)) / (m * n);
      const auto motion_blurred = [](double phase) { return std::abs(phase) < 1e-6 ? 1.0 : std::sin(phase) / phase; };
      waves[k] = {lens * motion_blurred(std::numbers::pi / 2 * (m * x - n * y)),
                  lens * motion_blurred(std::numbers::pi / 2 * (m * x + n * y))};
    }
    return waves;
  }
};

double SquareOf(const Waves& waves) {
  double sum = 0;
  for (const std::array<double, 2>& pair : waves) sum += pair[0] * pair[0] + pair[1] * pair[1];
  return sum;
}

/// Sum of the squares that are left of waves where another set, at the best amplitude, is taken out of them.
double LeftOf(const Waves& measured, const Waves& model) {
  double product = 0;
  for (std::size_t k = 0; k < measured.size(); ++k)
    for (std::size_t i = 0; i < 2; ++i) product += measured[k][i] * model[k][i];
  return SquareOf(measured) - product * product / SquareOf(model);
}

bool IsSought(const Damping& damping) {
  return damping.blur > kLeastBlurOfMotionBlurred && damping.blur < kMostBlurOfMotionBlurred &&
         std::hypot(damping.x, damping.y) < kMostMotionBlur;
}

/// There and back are the same.
bool AreNear(const Damping& a, const Damping& b) {
  return std::min(std::hypot(a.x - b.x, a.y - b.y), std::hypot(a.x + b.x, a.y + b.y)) < kApartMinima;
}

/// A damping, and what it leaves of the waves.
struct Guess {
  Damping damping;
  double left = 0;
};

/// Goes to the minimum that lies next.
Guess Descend(const Waves& waves, Guess guess) {
  for (double step = kMotionBlurStep / 2; step > kLastMotionBlurStep; step /= 2)
    for (bool nearer = true; nearer;) {
      nearer = false;
      const Damping from = guess.damping;
      for (int i = 0; i < 27; ++i) {
        const Damping to{from.x + (i % 3 - 1) * step, from.y + (i / 3 % 3 - 1) * step,
                         from.blur + (i / 9 - 1) * step / 4};
        if (!IsSought(to)) continue;
        const double left = LeftOf(waves, to.Of());
        if (left < guess.left) guess = {to, left}, nearer = true;
      }
    }
  return guess;
}

/// The deepest minima, the deepest first. @param least the most that they may leave.
std::array<Guess, kMostMinima> DeepestMinima(const Waves& waves, double least) {
  std::array<Guess, kCoarseBlurs.size() * (kMotionBlurSteps + 1) * (2 * kMotionBlurSteps + 1)> guesses;
  std::size_t count = 0;
  for (const double blur : kCoarseBlurs)
    for (int x = 0; x <= kMotionBlurSteps; ++x)
      for (int y = -kMotionBlurSteps; y <= kMotionBlurSteps; ++y)
        if (const Damping damping{x * kMotionBlurStep, y * kMotionBlurStep, blur}; IsSought(damping))
          guesses[count++] = {damping, LeftOf(waves, damping.Of())};
  const auto end = guesses.begin() + static_cast<std::ptrdiff_t>(count);
  const auto leaves_less = [](const Guess& a, const Guess& b) { return a.left < b.left; };
  std::sort(guesses.begin(), end, leaves_less);
  std::array<Guess, kMostMinima> minima;
  minima.fill({{}, least});
  std::size_t tries = 0;
  std::array<Damping, kMostMinima> tried;
  for (auto guess = guesses.begin(); guess != end && tries < kMostMinima; ++guess) {
    if (std::any_of(tried.begin(), tried.begin() + static_cast<std::ptrdiff_t>(tries),
                    [&](const Damping& other) { return AreNear(other, guess->damping); }))
      continue;
    tried[tries] = guess->damping;
    const Guess minimum = Descend(waves, *guess);
    if (minimum.left < least) minima[tries] = minimum;
    ++tries;
  }
  std::sort(minima.begin(), minima.end(), leaves_less);
  return minima;
}

/// What a board shows around one of its corners.
Patch SamplePatch(const LightReader& reader, const Lens& lens, const BoardGeometry& geometry,
                  const Eigen::Vector2d& corner, int cells) {
  Patch patch;
  patch.cells = cells;
  const int count = cells * kSamplesOfCell;
  for (int i = 0; i < count * count; ++i) {
    const Eigen::Vector2d from(i % count + 0.5 - 0.5 * count, i / count + 0.5 - 0.5 * count);
    const Eigen::Vector2f pixel = lens.ToImage(geometry.ToPlane(corner + from / kSamplesOfCell)).cast<float>();
    const Eigen::Vector3f rgb = reader.Rgb(pixel.x(), pixel.y(), 0);
    patch.light[static_cast<std::size_t>(i)] = static_cast<double>(rgb[0] + rgb[1]);
  }
  return patch;
}

}  // namespace

MotionBlurs FindMotionBlurs(const LightReader& reader, const Lens& lens, MarkerSize size,
                            const BoardGeometry& geometry) {
  // Whole periods, which tell waves apart, that what lies beside the board does not blur into.
  const int smaller = std::min(size.rows, size.cols), cells = smaller >= 6 ? kMostCells : 2;
  const Eigen::Vector2d corner = CornerOnBoard(size, (size.rows - 1) / 2, (size.cols - 1) / 2);
  Eigen::Matrix2d pixel_by_plane;
  if (smaller < 4 || !lens.ToImage(geometry.ToPlane(corner), &pixel_by_plane).allFinite()) return {};
  const Eigen::Matrix2d pixel_by_board = pixel_by_plane * geometry.PlaneByBoard(corner);
  const double longer = std::max(pixel_by_board.col(0).norm(), pixel_by_board.col(1).norm());
  if (std::abs(pixel_by_board.determinant()) < kLeastAcrossPx * longer) return {};
  const Waves waves = MeasureWaves(SamplePatch(reader, lens, geometry, corner, cells));
  double without = SquareOf(waves);
  const double even = kMostEvenly * without;
  for (const double blur : kCoarseBlurs) without = std::min(without, LeftOf(waves, Damping{0, 0, blur}.Of()));
  if (without < even) return {};
  MotionBlurs motion_blurs;
  const std::array<Guess, kMostMinima> minima = DeepestMinima(waves, kLeastGainOfMotionBlur * without);
  std::array<Damping, MotionBlurs::kMost> told;
  for (const Guess& minimum : minima) {
    const Eigen::Vector2d motion_blur(minimum.damping.x, minimum.damping.y);
    if (motion_blurs.count == MotionBlurs::kMost || minimum.left > kMostOfDeepest * minima[0].left ||
        motion_blur.norm() < kLeastMotionBlur)
      continue;
    const auto end = told.begin() + static_cast<std::ptrdiff_t>(motion_blurs.count);
    if (std::any_of(told.begin(), end, [&](const Damping& other) { return AreNear(other, minimum.damping); })) continue;
    told[motion_blurs.count] = minimum.damping;
    motion_blurs.by_px[motion_blurs.count++] = pixel_by_board * motion_blur;
  }
  return motion_blurs;
}

}  // namespace chequer
