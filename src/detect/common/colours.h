#pragma once

#include <Eigen/Core>

#include "chequer/detector.h"

namespace chequer {

/// A cell's colour in the two channels of the marker.
struct CellColour {
  float luminance = 0;   ///< CIE L* (0..100), or V (0..100)
  float saturation = 0;  ///< grows with the cell's ink: b* of a light cell, −b* of a dark one; or S (0..100)
};

/// Converts the light of a cell (linear R, G, B) whose white is `white`. A light cell that is yellow and a dark one
/// that is blue are saturated: with CIE L*a*b* that is |b*| with the sign of the class, so that a cast of the light
/// does not fold over; with HSV it is S.
/// @param white light of the board's white, per channel, > 0.
CellColour ColourOf(const Eigen::Vector3f& light, const Eigen::Vector3f& white, bool dark_cell, ColorSpace space);

/// A group of values by their count, mean and standard deviation.
struct Gaussian {
  int count = 0;
  double mean = 0;
  double deviation = 0;
};

/// Collects values for a Gaussian, of which the mean is not a million times the deviation.
class GaussianSum {
 public:
  void Add(double value) {
    ++count_;
    sum_ += value;
    square_sum_ += value * value;
  }
  Gaussian Get() const;

 private:
  int count_ = 0;
  double sum_ = 0, square_sum_ = 0;
};

/// The overlap of two Gaussians, as the share of either that lies beyond the point between them that misjudges both
/// equally: Φ(−|m₁ − m₀| / (s₀ + s₁)), 0..½ (publication, section II-B).
double Overlap(const Gaussian& a, const Gaussian& b);

}  // namespace chequer
