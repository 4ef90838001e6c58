#include "simulate/print_quality.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "simulate/random.h"

namespace chequer {
namespace {

/// Sigmas of highlights, over a board's longer side, and how far beside the board they may lie, as a share of it: lamps
/// and windows of 5 to 15 cm, seen in prints of 10 cm (guess).
constexpr double kLeastHighlight = 0.1, kMostHighlight = 0.3, kHighlightBeside = 0.25;
/// Sides of specks, cells.
constexpr double kLeastSpeck = 0.05, kMostSpeck = 0.25;

// Guesses within what makers and users of printers state: fusing shrinks paper by 0.1 to 0.3 %, and paper is stretched
// otherwise along its way than across; colour lasers keep their inks within 0.1 mm, inkjets within two droplets; edges
// grow by 10 to 50 µm, on plain paper by more. Paper that ink has wetted dries hollow: at a radius of 4 m, a guess, the
// rim of a print of 80 mm rises by .2 mm.
const std::array<std::pair<std::string_view, PrintKind>, 5>& Kinds() {
  static const std::array<std::pair<std::string_view, PrintKind>, 5> kKinds{{
      {"ideal", {{}, "laser"}},
      {"office", {{.scale_deviation = 0.0025, .register_m = 3e-5, .dot_gain_m = 2e-5}, "laser"}},
      {"laser", {{.scale_deviation = 0.002, .register_m = 5e-5, .dot_gain_m = 2e-5}, "laser"}},
      {"inkjet", {{.scale_deviation = 0.001, .register_m = 2e-5, .dot_gain_m = 5e-5}, "inkjet"}},
      {"inkjet-worn",
       {{.scale_deviation = 0.0025,
         .register_m = 3e-5,
         .dot_gain_m = 8e-5,
         .fading = 0.15,
         .dirt = 0.01,
         .bend_radius_m = -4},
        "inkjet"}},
  }};
  return kKinds;
}

void Fade(double share, InkSet& inks) {
  const auto pale = [&](Eigen::Vector3f& ink) { ink += static_cast<float>(share) * (inks.white - ink); };
  pale(inks.black);
  pale(inks.blue);
  pale(inks.yellow);
}

/// Specks at random places, until they cover so much of the board.
void AddDirt(double share, Random& random, SceneMarker& marker) {
  const Eigen::Array2d board(marker.board.cols, marker.board.rows);
  for (double left = share * board.prod(); left > 0;) {
    const Eigen::Array2d size{random.Uniform(kLeastSpeck, kMostSpeck), random.Uniform(kLeastSpeck, kMostSpeck)};
    Eigen::Array2d from{random.Uniform(), random.Uniform()};
    from *= board - size;
    Occluder speck{.from = (from / board).matrix(), .to = ((from + size) / board).matrix()};
    speck.colour.setConstant(static_cast<float>(random.Uniform(0.03, 0.3)));
    marker.occluders.push_back(speck);
    left -= size.prod();
  }
}

}  // namespace

std::string PrintQuality::Check() const {
  if (!(scale.minCoeff() >= 0.9 && scale.maxCoeff() <= 1.1)) return "the print's scale must be from 0.9 to 1.1";
  if (!(scale_deviation >= 0 && scale_deviation <= 0.03)) return "scale_deviation must be from 0 to 0.03";
  if (!(register_m >= 0 && register_m <= 0.005)) return "register must be from 0 to 5 mm";
  if (!(dot_gain_m >= 0 && dot_gain_m <= 0.005)) return "dot_gain must be from 0 to 5 mm";
  if (!(fading >= 0 && fading <= 0.9)) return "fading must be from 0 to 0.9";
  if (!(dirt >= 0 && dirt <= 0.3)) return "dirt must be from 0 to 0.3";
  if (!(gloss >= 0 && gloss <= 5)) return "gloss must be from 0 to 5";
  if (bend_radius_m != 0 && !(std::abs(bend_radius_m) >= 0.01 && std::abs(bend_radius_m) <= 1000))
    return "bend must be 0 (flat), or a radius from 0.01 to 1000 m, negative where the paper is hollow";
  return {};
}

std::optional<PrintKind> NamedPrint(std::string_view name) {
  for (const auto& [known, kind] : Kinds())
    if (known == name) return kind;
  return std::nullopt;
}

std::string PrintKindNames() {
  std::string text;
  for (const auto& [name, kind] : Kinds()) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

void Print(const PrintQuality& quality, std::uint64_t seed, SceneMarker& marker) {
  Random random(seed);
  // All are drawn, whatever is used: a knob changes nothing but what it is for.
  std::array<double, 6> normal{};
  for (double& value : normal) value = static_cast<double>(random.Normal());
  PrintErrors& errors = marker.print;
  errors.scale = quality.scale + quality.scale_deviation * Eigen::Vector2d(normal[0], normal[1]);
  errors.blue_shift_m = quality.register_m * Eigen::Vector2d(normal[2], normal[3]);
  errors.yellow_shift_m = quality.register_m * Eigen::Vector2d(normal[4], normal[5]);
  if (marker.board.Alternates())
    marker.ink_spread_cells =
        std::min(marker.ink_spread_cells + quality.dot_gain_m / marker.CellSize(), kMostInkSpreadCells);
  Fade(quality.fading, marker.inks);
  AddDirt(quality.dirt, random, marker);
  // Of seeds of their own, here and below: how many specks were drawn is no matter of theirs.
  Random lamp(DeriveSeed(seed, 2));
  marker.highlight.strength = quality.gloss;
  for (double& at : marker.highlight.at) at = lamp.Uniform(-kHighlightBeside, 1 + kHighlightBeside);
  marker.highlight.sigma = lamp.Uniform(kLeastHighlight, kMostHighlight);
  if (quality.bend_radius_m == 0) return;
  marker.bend_per_m = 1 / quality.bend_radius_m;
  marker.bend_angle_rad = quality.bend_angle_rad.value_or(Random(DeriveSeed(seed, 1)).Uniform(0, std::numbers::pi));
}

}  // namespace chequer
