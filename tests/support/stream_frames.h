#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/detector.h"
#include "simulate/stream.h"

// Streams for tests of what looks at one frame after the other. A test lists stream_frames.cpp among its sources and
// links chequer_simulate and chequer_detect.

namespace chequer::test {

/// A frame of a stream with its truth.
struct StreamFrame {
  Image image;
  FrameTruth truth;
};

/// How detections of a frame, or of several, compare with the truth.
struct StreamScore {
  int expected = 0;  ///< boards with at least half of them in the image
  int read = 0;
  int wrong = 0;  ///< ids that are not in the frame, or whose board lies elsewhere
  int twice = 0;  ///< ids that were read again in the same frame

  double Recall() const { return expected == 0 ? 1 : static_cast<double>(read) / expected; }
  StreamScore& operator+=(const StreamScore& other);
};

/// Frames of a scenario, drawn in memory as they are asked for. They are the bytes that `chequer render --scenario`
/// writes.
class StreamFrames {
 public:
  /// The scenario of that name among the examples: "reference", "flicker", …
  static StreamFrames Example(const std::string& name);
  /// A scenario's text.
  explicit StreamFrames(std::string_view scenario);

  std::size_t size() const { return stream_.size(); }
  const Scenario& scenario() const { return stream_.scenario(); }
  /// Name of the phase that a frame belongs to.
  const std::string& phase(std::size_t index) const;

  /// @param round gives the same picture with other noise, for longer runs over the same frames.
  StreamFrame Frame(std::size_t index, std::uint64_t round = 0) const;

  /// What a detector needs to read the stream's markers.
  DetectorOptions Options() const;

 private:
  explicit StreamFrames(Scenario scenario);

  Stream stream_;
};

/// Compares what was detected with the truth of its frame.
StreamScore ScoreFrame(const std::vector<MarkerPose>& found, const FrameTruth& truth);

}  // namespace chequer::test
