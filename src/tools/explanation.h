#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "chequer/image.h"
#include "tools/finding.h"

namespace chequer {

/// A rectangle of pixels.
struct ImageRegion {
  int x = 0, y = 0, width = 0, height = 0;

  bool Holds(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= x - 0.5 && pixel.y() >= y - 0.5 && pixel.x() < x + width - 0.5 && pixel.y() < y + height - 0.5;
  }
};

/// A detection with all that led to it.
struct Explanation {
  std::string name;  ///< of the image
  ImageView image;   ///< BGR8
  std::span<const MarkerPose> markers;
  const DetectTrace* trace = nullptr;
  DetectStats stats;
  ImageRegion region;  ///< of the image, that is explained
  std::vector<Finding> findings{};

  const TraceCandidate& candidate(std::size_t i) const { return trace->candidates[i]; }
};

/// What is told of the candidates in the region, in the order of their numbers: first those that were refused, then
/// those without an id, then those that were read. Of the former, first what a finding explains, then what has a
/// marker's inks, boards before groups of corners and large groups before small ones. Of groups that came nowhere near
/// a board only the likeliest are told.
std::vector<std::size_t> ToldCandidates(const Explanation& explanation);

/// What became of a candidate in a few words: "id 17", "no id", "refused: border_differs".
std::string Verdict(const Explanation& explanation, const TraceCandidate& candidate);

/// Where a candidate is, pixels.
Eigen::AlignedBox2d CandidateBox(const Explanation& explanation, const TraceCandidate& candidate);

/// The finding about a place; null where there is none.
const Finding* FindingAt(const Explanation& explanation, const Eigen::Vector2d& pixel);

/// What each stage made of what it got: "75 peaks > 25 corners > ...".
std::string StageCounts(const Explanation& explanation);

/// Lines for people, ending with a line's end: counts of the stages, what was found to be wrong and would help, then a
/// line a candidate, then one a place of the second look.
std::string DescribeExplanation(const Explanation& explanation);

/// A picture that fits a screen, a PNG of at most kSheetWidth x kSheetHeight pixels: the image with what every stage saw,
/// as large as there is room, and beside it close views of the candidates with the lowest numbers, the troubled ones
/// first, each with what became of it.
std::vector<std::uint8_t> DrawContactSheet(const Explanation& explanation);
inline constexpr int kSheetWidth = 1840, kSheetHeight = 1030;

/// The image with what every stage saw drawn in, a panel for each candidate that has cells and one for each
/// place that was viewed again, as PNG.
/// @param scale picture pixels per image pixel, 1..16. @param most_panels those with the lowest numbers.
/// Throws std::runtime_error where the picture would be too large.
std::vector<std::uint8_t> DrawExplanation(const Explanation& explanation, int scale, int most_panels);

}  // namespace chequer
