#pragma once

#include <filesystem>
#include <string>

#include "capture/frame_source.h"

namespace chequer::test {

/// A configuration of chequerd for a camera. @param capture the lines of [capture]. @param calibration may be empty.
std::string CameraConfig(const std::filesystem::path& folder, const std::string& capture,
                         const std::filesystem::path& calibration, const std::string& name = "test");

/// What a process holds.
struct Holdings {
  std::size_t descriptors = 0;
  std::size_t threads = 0;
  std::size_t memory_kb = 0;  ///< resident
};
Holdings HoldingsOf(int process);

/// What taking frames from a source and handing them over costs, and where they lie.
struct CaptureCost {
  int frames = 0;
  double cpu_ms = 0;        ///< a frame, of the capturing thread, system calls into the driver included
  double user_ms = 0;       ///< of these, outside of the kernel
  double hand_over_ms = 0;  ///< a frame, from the source's return until a worker has it (mean)
  int places = 0;           ///< different addresses of frames: of a source that copies nothing, its buffers
  std::string problem;      ///< empty if all frames came
};

/// Takes frames as the daemon does, with a worker that gives each back at once. @pre the source is open.
/// @param most_lost so many may come incomplete beside them: those of a network whose reader waits for a processor.
CaptureCost MeasureCapture(FrameSource& source, int frames, int most_lost = 0);

}  // namespace chequer::test
