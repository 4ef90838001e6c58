#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/frame_source.h"
#include "chequer/detector.h"
#include "chequer/detector_memory.h"
#include "core/clock.h"
#include "daemon/capture_loop.h"
#include "daemon/frame_budget.h"
#include "daemon/frame_look.h"
#include "daemon/frame_publisher.h"
#include "daemon/frame_viewer.h"
#include "daemon/pipeline_state.h"
#include "daemon/progress.h"
#include "daemon/scheduling.h"
#include "publish/publisher.h"

namespace chequer {

/// What happens to a frame that comes while another still waits for a worker.
enum class WhenBusy : std::uint8_t {
  kNewest,  ///< it replaces the waiting one, which is dropped and counted: a live camera
  kWait,    ///< the source is not asked for more until the waiting one was taken: a recording as fast as it goes
};

struct PipelineOptions {
  int workers = 1;  ///< 1..64
  WhenBusy when_busy = WhenBusy::kNewest;
  /// Whether capture times are of this host's clock now; if not (a recording with its own times), latencies are
  /// measured from a frame's arrival.
  bool capture_times_are_live = true;
  CaptureLoopOptions capture;
  SchedulingOptions scheduling;
  std::string camera = "camera";
  std::string version;
  std::chrono::milliseconds status_period{1000};
  FramePublisherOptions frames;
  PiecesDone pieces_done;  ///< may be empty: then whole frames alone show progress
  /// What is sought, for the hints of the status.
  std::vector<MarkerFamily> families;
  FrameBudget budget;
  bool memory = false;  ///< each frame is begun with what the last ones taught
  /// Has a value where others may look at the frames.
  std::optional<FrameViewerOptions> view;
};

/// What a detector made of one frame.
struct DetectedFrame {
  // Given to it:
  std::uint64_t budget = 0;  ///< the units of work that it may take, 0 for no limit
  MonotonicTime captured{};  ///< of the frame
  /// Where frames are begun with one: of the newest frame before that is finished; becomes that of this one.
  std::optional<DetectorMemory> memory;
  // Filled by it:
  std::vector<MarkerPose> markers;
  DetectStats stats;
  /// Has a value where one is asked for: the detection is then looked at more closely, and it is filled.
  std::optional<FrameLook> look;
};

/// Finds the markers of one image. Belongs to one worker, so it may hold scratch memory.
using DetectFrame = std::function<void(const ImageView& image, DetectedFrame& found)>;

/// What the owner of a pipeline may want to know. Called on the pipeline's threads; must return quickly.
struct PipelineEvents {
  /// Once: a frame has gone all the way to the publisher, or the camera was opened or found missing. What is wrong then
  /// was said in a status before.
  std::function<void()> ready;
  /// With each status, as published.
  std::function<void(const StatusMessage& status)> status;
  /// Once, at the very end: all is published. Only joining is left. Must not throw.
  std::function<void()> finished;
};

/// Frames from a source through the workers to a publisher, in the order of capture:
///
///   capture thread ──▶ NewestQueue ──▶ workers ──▶ ReorderBuffer ──▶ publish thread ──▶ Outbox ──▶ send thread
///
/// Beside them a thread that answers those who look (FrameViewer). Runs from construction until the recording is over,
/// or Stop or Drain is called. At the end every frame that a worker had begun is published whole, then one last status.
class Pipeline {
 public:
  /// @param make_detect called once a worker, before that runs. @pre options in range. Throws std::system_error, and
  /// leaves no thread behind, where one cannot be started.
  Pipeline(PipelineOptions options, std::unique_ptr<FrameSource> source,
           const std::function<DetectFrame()>& make_detect, std::unique_ptr<Publisher> publisher,
           PipelineEvents events = {}, Clock clock = Clock::System());
  /// Takes the place of a pipeline that was drained and joined, where that left off. @pre state has a source and a
  /// publisher.
  Pipeline(PipelineOptions options, PipelineState state, const std::function<DetectFrame()>& make_detect,
           PipelineEvents events = {}, Clock clock = Clock::System());
  /// Stops and joins.
  ~Pipeline();
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  /// Ends capturing; does not wait. Any thread, also several times.
  void Stop();

  /// Ends capturing as Stop does, but the frame that waits for a worker is worked on too: nothing is dropped. The
  /// source stays open. Does not wait. Any thread.
  void Drain();

  /// Waits until all is published and only joining is left; false when the time is over.
  bool WaitForEnd(std::chrono::milliseconds timeout) const;
  /// What has not come to its end yet, such as "worker 0 is at a frame". Any thread.
  std::string UnderWay() const;

  /// After Stop: gives up those threads that do not end by themselves. What was finished is published, and so is a last
  /// status; false if that has not been sent when the time is over. Joining may take for ever, so that only leaving the
  /// process is left.
  bool Abandon(std::chrono::milliseconds timeout);

  /// Waits for the end. Throws what ended it, if that was an error: a source that can never work, or what a detector
  /// threw. Call it once, from the thread that owns the pipeline.
  void Join();

  /// What a next pipeline goes on with. Call it once, after Join returned or threw.
  PipelineState TakeState();

  /// Empty while every part makes progress or waits for something known, else which does not (Progress::Stuck). One
  /// thread.
  std::string Stuck(const ProgressLimits& limits) const;

  /// Any thread.
  CameraState camera_state() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer
