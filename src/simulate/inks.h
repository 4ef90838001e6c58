#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

namespace chequer {

/// What the four colours of a print reflect, as linear RGB (sRGB's primaries), 0..1.
struct InkSet {
  Eigen::Vector3f black{0.035f, 0.035f, 0.038f};
  Eigen::Vector3f white{0.85f, 0.85f, 0.84f};
  Eigen::Vector3f blue{0.030f, 0.065f, 0.330f};
  Eigen::Vector3f yellow{0.760f, 0.610f, 0.045f};

  /// The reflectance of 'K', 'W', 'B' or 'Y'. @pre one of these.
  const Eigen::Vector3f& Of(char colour) const;
  /// Empty, or what is wrong and what would be right (each value from 0 to 1).
  std::string Check() const;
  bool operator==(const InkSet&) const = default;
};

/// "laser" (the default), "inkjet", "matte" (little contrast), "faded" (blue and yellow paled by the sun), "ideal"
/// (sRGB's pure colours). Nothing if there is no set of that name.
std::optional<InkSet> NamedInks(std::string_view name);

/// All names that NamedInks knows, comma-separated, for messages.
std::string InkNames();

}  // namespace chequer
