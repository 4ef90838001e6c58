#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "chequer/detector.h"

namespace chequer {

/// What `chequer detect` says of one image.
struct ImageReport {
  std::string file;  ///< as it was named on the command line
  int width = 0;     ///< pixels
  int height = 0;
  double detect_ms = 0;  ///< from the decoded frame in memory to the finished list
  std::uint64_t work = 0;  ///< units (DetectStats::work)
  std::span<const MarkerPose> markers;
};

/// One line of JSON, without the line's end. Numbers carry all digits of their type; what is not finite is null.
/// Position, orientation, covariance and ambiguity are left out of markers without a pose.
std::string JsonLine(const ImageReport& report);

/// A table for people: a line for the image, one for the columns and one a marker; ends with a line's end.
std::string Table(const ImageReport& report);

}  // namespace chequer
