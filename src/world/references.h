#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace chequer {

// Where markers lie in the room, as measured by hand:
//
//   sigma = 0.001              # may be left out: standard deviation of each coordinate below, metres; default 0.001
//
//   [[reference]]
//   id = 3
//   position = [1.2, 0.0]      # of the board's centre, metres; a third number is its height over the floor, else 0
//   heading = 90               # may be left out: of the board's x axis from the world's, degrees, counter-clockwise
//   lies_flat = true           # whether its face looks straight up; default true
//   family = 0                 # which of several kinds of markers it is, counted from 0; default 0

/// A marker at a place that was measured by hand.
struct Reference {
  std::uint64_t id = 0;
  int family = 0;                                               ///< index into the families that are sought
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();  ///< of the board's centre, metres
  std::optional<double> heading_rad;  ///< of the board's x axis from the world's, counter-clockwise seen from above
  bool lies_flat = true;              ///< its face looks along the world's z
};

struct ReferenceList {
  std::vector<Reference> references;
  double sigma_m = 0.001;  ///< standard deviation of each coordinate
};

/// Reads a list of references. Throws std::runtime_error naming file, line, key, value and what would be right; also
/// where an id stands twice, or two references at the same place.
ReferenceList LoadReferences(const std::filesystem::path& path);

/// The same from a text. @param name stands for the file in messages.
ReferenceList ParseReferences(std::string_view text, const std::string& name);

}  // namespace chequer
