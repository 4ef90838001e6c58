#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "detect/common/plane.h"
#include "detect/common/raw_buffer.h"

namespace chequer {

/// A local maximum of the corner response, in whole pixels of its plane, with the response of its neighbours.
struct Peak {
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::uint8_t response = 0;
  std::uint8_t left = 0, right = 0, above = 0, below = 0;
};

/// How many pixels from the plane's edge no response is computed.
inline constexpr int kRingMargin = 3;

/// Finds the peaks of the corner response of a plane whose rows come in one after the other. Keeps its memory.
///
/// The response is how much each pixel looks like the corner of four cells, in grey levels from 0 to about two thirds
/// of the contrast. One ring of 8 pixels at radius 3 serves cells from 3.5 to 60 px on sharp images; blurred ones are
/// sharp on a smaller plane. The test is that of ChESS (Bennett and Lasenby, 2014), of the ring's two squares each for
/// itself: the means of opposite pixels that differ from those a quarter turn on, less the differences of opposite
/// pixels, where that leaves something; then the mean of both squares, less the difference of the ring's mean and that
/// of the four pixels beside the middle. So wherever the edges run, and wherever between the pixels they cross, one
/// square at least lies well inside the cells and answers. Shares of their contrast that corners answer with, least and
/// median of all turns and places between the pixels: 0.43 and 0.67 for cells of 8 px with a blur of 0.5 px, 0.39 and
/// 0.58 of 0.7 px, 0.3 and 0.42 tilted by 60 degrees; 0.35 and 0.51 for cells of 4 px, 0.2 and 0.34 of 3.5 px. (A ring
/// of 12 taken as one answers with no more in the median and with 0.09, 0.17, 0, 0.1 and 0 at least.) Edges and the
/// outer corners of boards answer with nothing, lines of 3 px with up to 0.17. Of a corner between pixels, noise makes
/// two peaks 2 px apart, less than one time in a hundred; links take one of them. 0.1 ns a pixel.
class PeakScan {
 public:
  /// @param threshold least response of a peak.
  void Start(const BytePlane& plane, std::uint8_t threshold);
  /// The plane's first `rows` rows are there by now: finds the peaks that they tell, in reading order. Of 3 × 3 pixels,
  /// none exceeds a peak.
  void Advance(const BytePlane& plane, int rows);
  const std::vector<Peak>& peaks() const { return peaks_; }
  std::vector<Peak>& peaks() { return peaks_; }

 private:
  /// Of these, row y of the response stands in row y modulo kKept: so it never leaves the nearest cache.
  static constexpr int kKept = 4;

  void FindPeaks(int y);

  /// Where a row of the response has something strong: the first columns of its vectors that do, so that nothing else
  /// is looked at again.
  struct Strong {
    RawBuffer<std::uint16_t> columns;  ///< the first `count` of them
    int count = 0;
  };

  BytePlane response_;
  std::array<Strong, kKept> strong_;
  RawBuffer<std::uint16_t> columns_;  ///< of a row's peaks
  std::vector<Peak> peaks_;
  std::uint8_t threshold_ = 0;
  int next_ = 0;  ///< row of the response
};

}  // namespace chequer
