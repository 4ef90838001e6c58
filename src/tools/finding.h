#pragma once

#include <Eigen/Core>
#include <string>

namespace chequer {

/// What explains an image, or a place of it, better than what was sought, and what would help.
struct Finding {
  Eigen::Vector2d center_px{0, 0};
  /// Of what it is about, pixels; 0: the whole image.
  double reach_px = 0;
  std::string text;

  bool IsAbout(const Eigen::Vector2d& pixel) const { return reach_px > 0 && (pixel - center_px).norm() < reach_px; }
};

}  // namespace chequer
