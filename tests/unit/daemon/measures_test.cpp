#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "daemon/latency_histogram.h"
#include "daemon/notify.h"
#include "daemon/sequence_counter.h"
#include "daemon/statistics.h"
#include "support/seed.h"

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(LatencyHistogram, SaysNothingOfNothing) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.worst(), microseconds(0));
  EXPECT_EQ(histogram.Quantile(0.5), microseconds(0));
}

TEST(LatencyHistogram, IsExactForSmallTimes) {
  LatencyHistogram histogram;
  for (int time = 1; time <= 31; ++time) histogram.Add(microseconds(time));
  EXPECT_EQ(histogram.Quantile(0.5), microseconds(16));
  EXPECT_EQ(histogram.worst(), microseconds(31));
}

TEST(LatencyHistogram, IsWithinThreePercentOfTheExactQuantile) {
  std::mt19937_64 random = test::SeededGenerator();
  std::lognormal_distribution<double> times(9, 2);
  LatencyHistogram histogram;
  std::vector<double> all;
  for (int i = 0; i < 20000; ++i) {
    const auto time = microseconds(static_cast<std::int64_t>(times(random)));
    histogram.Add(time);
    all.push_back(static_cast<double>(time.count()));
  }
  std::sort(all.begin(), all.end());
  for (const double fraction : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const double exact = all[static_cast<std::size_t>(std::ceil(fraction * 20000)) - 1];
    EXPECT_NEAR(static_cast<double>(histogram.Quantile(fraction).count()), exact, std::max(1.0, 0.03 * exact));
  }
  EXPECT_EQ(histogram.worst(), microseconds(static_cast<std::int64_t>(all.back())));
}

TEST(LatencyHistogram, NeverGivesAQuantileBeyondTheWorst) {
  LatencyHistogram histogram;
  histogram.Add(microseconds(1000));
  EXPECT_LE(histogram.Quantile(0.99), histogram.worst());
}

TEST(LatencyHistogram, TakesAnyTime) {
  LatencyHistogram histogram;
  histogram.Add(microseconds(-5));
  EXPECT_EQ(histogram.worst(), microseconds(0));
  histogram.Add(microseconds::max());
  EXPECT_EQ(histogram.count(), 2u);
  EXPECT_EQ(histogram.worst(), microseconds((1ll << 35) - 1));
}

TEST(LatencyHistogram, IsEmptyAfterClear) {
  LatencyHistogram histogram;
  histogram.Add(microseconds(1000));
  histogram.Clear();
  EXPECT_EQ(histogram.count(), 0u);
  EXPECT_EQ(histogram.Quantile(0.5), microseconds(0));
}

TEST(SequenceCounter, KeepsTheCamerasNumbers) {
  SequenceCounter counter;
  EXPECT_EQ(counter.Frame(17).sequence, 17u);
  EXPECT_EQ(counter.Frame(18).sequence, 18u);
}

TEST(SequenceCounter, CountsGapsAsLost) {
  SequenceCounter counter;
  counter.Frame(1);
  const auto counted = counter.Frame(5);
  EXPECT_EQ(counted.sequence, 5u);
  EXPECT_EQ(counted.lost, 3u);
}

TEST(SequenceCounter, GoesOnRisingWhenTheCameraCountsAnew) {
  SequenceCounter counter;
  counter.Frame(100);
  EXPECT_EQ(counter.Frame(0).sequence, 101u);
  const auto counted = counter.Frame(2);
  EXPECT_EQ(counted.sequence, 103u);
  EXPECT_EQ(counted.lost, 1u);
  EXPECT_EQ(counter.Frame(2).sequence, 104u);  // the same number twice: anew as well
}

TEST(SequenceCounter, DoesNotCountAnUnusableFrameAsLostToo) {
  SequenceCounter counter;
  counter.Frame(1);
  counter.UnusableFrame();
  const auto counted = counter.Frame(4);
  EXPECT_EQ(counted.sequence, 4u);
  EXPECT_EQ(counted.lost, 1u);
}

TEST(SequenceCounter, LeavesAGapForAnUnusableFrameWhereTheCameraCountsAnew) {
  SequenceCounter counter;
  counter.Frame(7);
  counter.UnusableFrame();
  const auto counted = counter.Frame(0);
  EXPECT_EQ(counted.sequence, 9u);
  EXPECT_EQ(counted.lost, 0u);
}

MonotonicTime AtMs(int ms) { return MonotonicTime(milliseconds(ms)); }

const NamedCount& Named(const std::vector<NamedCount>& counts, const std::string& name) {
  return *std::find_if(counts.begin(), counts.end(), [&](const NamedCount& count) { return count.name == name; });
}

const StageLatency& Stage(const StatusMessage& status, const std::string& name) {
  return *std::find_if(status.stages.begin(), status.stages.end(),
                       [&](const StageLatency& stage) { return stage.stage == name; });
}

TEST(Statistics, TellsRatesAndMarkersOfTheWindow) {
  Statistics statistics({"1.0", "cam", 1, 2}, AtMs(0));
  QueueCounts frames{.came = 4, .waiting = 1};
  for (const std::size_t markers : {3u, 5u, 4u}) statistics.Published(std::vector<MarkerPose>(markers), {});
  StatusMessage status = statistics.Finish({}, frames, AtMs(2000));
  EXPECT_EQ(status.version, "1.0");
  EXPECT_EQ(status.camera, "cam");
  EXPECT_EQ(status.workers, 2);
  EXPECT_EQ(status.queue_depth, 1);
  EXPECT_EQ(status.window, seconds(2));
  EXPECT_DOUBLE_EQ(status.capture_rate_hz, 2.0);
  EXPECT_DOUBLE_EQ(status.publish_rate_hz, 1.5);
  EXPECT_DOUBLE_EQ(status.markers_mean, 4.0);
  EXPECT_EQ(status.markers_min, 3);
  EXPECT_EQ(status.markers_max, 5);

  frames = {.came = 5};
  statistics.Published(std::vector<MarkerPose>(9), {});
  status = statistics.Finish({}, frames, AtMs(3000));
  EXPECT_EQ(status.uptime, seconds(3));
  EXPECT_EQ(status.window, seconds(1));
  EXPECT_DOUBLE_EQ(status.capture_rate_hz, 1.0);
  EXPECT_EQ(status.frames_published, 4u);
  EXPECT_EQ(status.markers_min, 9);
}

TEST(Statistics, TellsOfAWindowWithoutFrames) {
  Statistics statistics({}, AtMs(0));
  statistics.Published(std::vector<MarkerPose>(3), {});
  statistics.Finish({}, {}, AtMs(1000));
  const StatusMessage status = statistics.Finish({}, {}, AtMs(2000));
  EXPECT_EQ(status.publish_rate_hz, 0);
  EXPECT_EQ(status.markers_max, 0);
  EXPECT_EQ(Stage(status, "total").frames, 0u);
}

TEST(Statistics, MeasuresEachStage) {
  Statistics statistics({}, AtMs(0));
  statistics.Sent({AtMs(0), AtMs(1), AtMs(6), AtMs(8), AtMs(9)});
  const StatusMessage status = statistics.Finish({}, {}, AtMs(1000));
  EXPECT_EQ(Stage(status, "queue").worst, milliseconds(1));
  EXPECT_EQ(Stage(status, "detect").worst, milliseconds(5));
  EXPECT_EQ(Stage(status, "order").worst, milliseconds(2));
  EXPECT_EQ(Stage(status, "publish").worst, milliseconds(1));
  EXPECT_EQ(Stage(status, "total").worst, milliseconds(9));
  EXPECT_EQ(Stage(status, "total").frames, 1u);
}

TEST(Statistics, AddsUpDropsByReason) {
  Statistics statistics({}, AtMs(0));
  CaptureReport capture;
  capture.lost_before = 1;
  capture.corrupt = 2;
  capture.wrong_size = 4;
  const StatusMessage status = statistics.Finish(capture, {.superseded = 16, .discarded = 8}, AtMs(1000));
  EXPECT_EQ(status.frames_dropped, 31u);
  EXPECT_EQ(Named(status.drops, "corrupt").count, 2u);
  EXPECT_EQ(Named(status.drops, "superseded").count, 16u);
  EXPECT_EQ(Named(status.drops, "stopped").count, 8u);
}

TEST(Statistics, AddsUpWhatTheDetectorSaw) {
  Statistics statistics({}, AtMs(0));
  DetectStats stats;
  stats.boards = 3;
  stats.refused_fit = 1;
  statistics.Published(std::vector<MarkerPose>(2), stats);
  statistics.Published(std::vector<MarkerPose>(2), stats);
  StatusMessage status = statistics.Finish({}, {}, AtMs(1000));
  EXPECT_EQ(Named(status.detections, "boards").count, 6u);
  EXPECT_EQ(Named(status.detections, "refused_fit").count, 2u);
  status = statistics.Finish({}, {}, AtMs(2000));
  EXPECT_EQ(Named(status.detections, "boards").count, 0u);
}

TEST(Statistics, CountsMarkersByTheirWarnings) {
  Statistics statistics({}, AtMs(0));
  std::vector<MarkerPose> markers(3);
  markers[0].warnings =
      static_cast<std::uint32_t>(Warning::kPoorIllumination) | static_cast<std::uint32_t>(Warning::kAmbiguous);
  markers[2].warnings = static_cast<std::uint32_t>(Warning::kAmbiguous);
  statistics.Published(markers, {});
  StatusMessage status = statistics.Finish({}, {}, AtMs(1000));
  EXPECT_EQ(Named(status.detections, "warning_poor_illumination").count, 1u);
  EXPECT_EQ(Named(status.detections, "warning_ambiguous_pose").count, 2u);
  EXPECT_EQ(Named(status.detections, "warning_id_undecided").count, 0u);
  status = statistics.Finish({}, {}, AtMs(2000));
  EXPECT_EQ(Named(status.detections, "warning_ambiguous_pose").count, 0u);
}

TEST(StatusLine, SaysWhatIsWrongFirst) {
  StatusMessage status;
  EXPECT_EQ(StatusLine(status), "waiting for the camera");
  status.camera_message = "no such device";
  EXPECT_EQ(StatusLine(status), "waiting for the camera: no such device");
  status.camera_state = CameraState::kRunning;
  EXPECT_EQ(StatusLine(status), "no such device");
  status.publisher.message = "no multicast route";
  EXPECT_EQ(StatusLine(status), "no multicast route");
}

TEST(StatusLine, SaysHowItGoes) {
  StatusMessage status;
  status.camera_state = CameraState::kRunning;
  status.publish_rate_hz = 59.96;
  status.markers_mean = 49.5;
  status.frames_dropped = 3;
  EXPECT_EQ(StatusLine(status), "60.0 frames/s, 49.5 markers a frame, 3 frames dropped");
  status.stages = {{"queue", 60, milliseconds(1), milliseconds(1), milliseconds(1)},
                   {"total", 60, std::chrono::microseconds(5170), milliseconds(8), milliseconds(9)}};
  EXPECT_EQ(StatusLine(status), "60.0 frames/s, 49.5 markers a frame, 3 frames dropped, latency 5.2 ms (99 %: 8.0 ms)");
}

}  // namespace
}  // namespace chequer
