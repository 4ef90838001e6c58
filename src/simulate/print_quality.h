#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "simulate/scene.h"

namespace chequer {

/// How the prints of one printer differ from what was sent to it. What has a deviation differs from print to print.
struct PrintQuality {
  /// Printed over nominal length: of a board's width, of its height. 0.9..1.1.
  Eigen::Vector2d scale{1, 1};
  double scale_deviation = 0;  ///< standard deviation of both about that, 0..0.03
  /// How far blue and yellow lie off black: standard deviation along either axis, metres, 0..0.005.
  double register_m = 0;
  double dot_gain_m = 0;  ///< by which dark cells grow on each side, metres, 0..0.005
  double fading = 0;      ///< share by which inks are nearer to white, 0..0.9
  double dirt = 0;        ///< share of the board that dark specks occlude, 0..0.3
  /// What the mirror image of a lamp adds at its middle, over what white paper reflects, 0..5; each print has its own
  /// place and size of it.
  double gloss = 0;
  /// Radius of the cylinder that the paper lies on, metres, 0.01..1000; negative where it is hollow; 0: flat.
  double bend_radius_m = 0;
  /// In which it bends, from the marker's x axis towards its y axis; where it is not set, each print has its own.
  std::optional<double> bend_angle_rad{};

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
  bool operator==(const PrintQuality&) const = default;
};

/// A kind of print: its quality, and NamedInks' name of its inks.
struct PrintKind {
  PrintQuality quality;
  std::string_view ink;
};

/// "ideal" (the default), "office" (any office printer: 0.25 % of scale, 0.03 mm between inks), "laser", "inkjet",
/// "inkjet-worn" (used for months: paled, with specks, hollow as paper is that dries on its printed side). Nothing if
/// there is no kind of that name.
std::optional<PrintKind> NamedPrint(std::string_view name);

/// All names that NamedPrint knows, comma-separated, for messages.
std::string PrintKindNames();

/// Makes a marker one print of that quality; the same seed gives the same. Its pose, side and inks are those that were
/// meant, and stay so in the truth. @pre quality.Check() is empty; the marker's inks are set.
void Print(const PrintQuality& quality, std::uint64_t seed, SceneMarker& marker);

}  // namespace chequer
