#include "daemon/pipeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>

#include "detect/memory/memory.h"
#include "support/deadline.h"
#include "support/log_capture.h"
#include "support/no_room_for_threads.h"
#include "support/recording_publisher.h"
#include "support/scripted_source.h"
#include "support/semaphore.h"
#include "support/stepped_clock.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::ComesTrue;
using test::FrameNumber;
using test::Frames;
using test::Gives;
using test::kEnd;
using test::kPatience;
using test::OpenFails;
using test::OpenThrows;
using test::Published;
using test::RecordingPublisher;
using test::ScriptedSource;
using test::Step;
using test::operator+;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Finds one marker, whose id is the frame's sequence number.
DetectFrame FindSequence() {
  return [](const ImageView& image, DetectedFrame& found) {
    MarkerPose marker;
    marker.id = test::SequenceIn(image);
    found.markers.push_back(marker);
    found.stats.boards = 1;
  };
}

class PipelineTest : public ::testing::Test {
 protected:
  /// The pipeline over a script, with options_ and events_.
  void Start(std::vector<Step> script, const std::function<DetectFrame()>& make_detect = FindSequence) {
    auto source = std::make_unique<ScriptedSource>(std::move(script));
    leases_ = source->leases();
    options_.capture.first_reopen = options_.capture.longest_reopen = milliseconds(1);
    pipeline_ = std::make_unique<Pipeline>(options_, std::move(source), make_detect,
                                           std::make_unique<RecordingPublisher>(published_), events_, clock_.clock());
  }

  std::vector<std::uint64_t> PublishedSequences() const {
    std::vector<std::uint64_t> sequences;
    for (const PosesMessage& message : published_->poses()) sequences.push_back(message.sequence);
    return sequences;
  }

  int LeaseCount() const { return *leases_; }
  StatusMessage LastStatus() const { return published_->statuses().back(); }

  PipelineOptions options_;
  PipelineEvents events_;
  test::SteppedClock clock_;
  std::shared_ptr<Published> published_ = std::make_shared<Published>();
  std::shared_ptr<std::atomic<int>> leases_;
  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(PipelineTest, PublishesEveryFrameInOrderWithManyWorkers) {
  options_.workers = 4;
  options_.when_busy = WhenBusy::kWait;
  constexpr std::uint64_t kLast = 2000;
  Start(Frames(1, kLast) + std::vector{kEnd}, [] {
    return [detect = FindSequence()](const ImageView& image, DetectedFrame& found) {
      if (test::SequenceIn(image) % 5 == 0) std::this_thread::yield();
      detect(image, found);
    };
  });
  pipeline_->Join();
  const auto poses = published_->poses();
  ASSERT_EQ(poses.size(), kLast);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ASSERT_EQ(poses[i].sequence, i + 1);
    ASSERT_EQ(poses[i].markers.size(), 1u);
    ASSERT_EQ(poses[i].markers[0].id, i + 1);
    ASSERT_EQ(poses[i].frames_dropped, 0u);
  }
  EXPECT_EQ(*leases_, 0);
}

TEST_F(PipelineTest, BeginsFramesWithTheMemoryOfTheLastOneWhereAskedTo) {
  options_.workers = 1;
  options_.when_busy = WhenBusy::kWait;
  for (const bool asked : {false, true}) {
    options_.memory = asked;
    std::vector<int> taught;
    Start(Frames(1, 3) + std::vector{kEnd}, [&] {
      return [&](const ImageView& image, DetectedFrame& found) {
        taught.push_back(found.memory ? found.memory->state().since_start : -1);
        if (found.memory) found.memory->state().since_start = static_cast<int>(test::SequenceIn(image));
      };
    });
    pipeline_->Join();
    EXPECT_EQ(taught, asked ? std::vector({0, 1, 2}) : std::vector({-1, -1, -1}));
  }
}

TEST_F(PipelineTest, SaysWhenAndWhereAFrameWasCaptured) {
  options_.camera = "ceiling";
  Start({FrameNumber(7), kEnd});
  pipeline_->Join();
  const PosesMessage message = published_->poses().at(0);
  EXPECT_EQ(message.captured_monotonic, MonotonicTime(milliseconds(7)));
  EXPECT_EQ(message.captured_utc, UtcTime(seconds(1'700'000'000) + milliseconds(7)));
  EXPECT_EQ(message.instant, ExposureInstant::kMiddle);
  EXPECT_EQ(message.published_monotonic, clock_.clock().monotonic());
  EXPECT_EQ(message.published_utc, clock_.clock().utc());
  EXPECT_EQ(message.camera, "ceiling");
  EXPECT_EQ(message.frame, "camera");
  EXPECT_EQ(message.image_width, 4);
  EXPECT_EQ(message.image_height, 2);
}

/// Lets the test decide when a worker goes on.
struct Gate {
  test::Semaphore entered{0};
  test::Semaphore open{0};

  DetectFrame Detector() {
    return [this, detect = FindSequence()](const ImageView& image, DetectedFrame& found) {
      entered.release();
      if (!open.try_acquire_for(kPatience)) return;
      detect(image, found);
    };
  }
  /// Whether a worker has come to it, now or in time.
  bool WasEntered() { return entered.try_acquire_for(kPatience); }
};

TEST_F(PipelineTest, ReplacesWaitingFramesByTheNewestAndCountsThem) {
  Gate gate;
  // Frames 2 to 6 are there before the worker is let go: the camera's end shows that they all came.
  std::atomic<bool> all_came{false};
  class Watched final : public FrameSource {
   public:
    Watched(Gate& gate, std::atomic<bool>& all_came)
        : behind_(Frames(1, 6) + std::vector{kEnd}), gate_(gate), all_came_(all_came) {}
    std::string Open() override { return behind_.Open(); }
    CaptureResult Next(milliseconds timeout) override {
      EXPECT_TRUE(++calls_ != 2 || gate_.WasEntered());  // the worker has frame 1
      CaptureResult result = behind_.Next(timeout);
      if (result.status == CaptureStatus::kEnd) all_came_ = true;
      return result;
    }
    void Interrupt() override { behind_.Interrupt(); }
    std::string Describe() const override { return behind_.Describe(); }

   private:
    ScriptedSource behind_;
    Gate& gate_;
    std::atomic<bool>& all_came_;
    int calls_ = 0;
  };
  Pipeline pipeline(
      options_, std::make_unique<Watched>(gate, all_came), [&] { return gate.Detector(); },
      std::make_unique<RecordingPublisher>(published_), events_, clock_.clock());
  EXPECT_TRUE(ComesTrue([&] { return all_came.load(); }));
  gate.open.release(10);
  pipeline.Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1, 6));
  EXPECT_EQ(published_->poses()[0].frames_dropped, 0u);
  EXPECT_EQ(published_->poses()[1].frames_dropped, 4u);
  EXPECT_EQ(LastStatus().frames_dropped, 4u);
}

TEST_F(PipelineTest, KeepsLatencyBelowTwoFramesWorkWhenFramesComeTwiceAsFast) {
  static constexpr milliseconds kWork{20};
  static constexpr int kFrames = 100;
  test::Semaphore begun{0};
  test::Semaphore done{0};
  // The clock moves with the camera: a frame each half of a frame's work; the worker is done after two of them.
  class TooFast final : public FrameSource {
   public:
    TooFast(test::SteppedClock& clock, Published& published, test::Semaphore& begun, test::Semaphore& done)
        : behind_(Frames(1, kFrames) + std::vector{kEnd}),
          clock_(clock),
          published_(published),
          begun_(begun),
          done_(done) {}
    std::string Open() override { return behind_.Open(); }
    CaptureResult Next(milliseconds timeout) override {
      if (count_ % 2 == 1) {
        published_.WaitForPoses(works_done_);
        EXPECT_TRUE(begun_.try_acquire_for(kPatience));  // the worker took the frame that waited
      }
      if (count_ > 0) clock_.Advance(kWork / 2);
      if (count_ > 0 && count_ % 2 == 0) Finish();
      CaptureResult result = behind_.Next(timeout);
      if (result.status == CaptureStatus::kEnd) done_.release(5);
      result.frame.captured_monotonic = clock_.clock().monotonic();
      ++count_;
      return result;
    }
    void Interrupt() override { behind_.Interrupt(); }
    std::string Describe() const override { return behind_.Describe(); }

   private:
    void Finish() {
      ++works_done_;
      done_.release();
    }

    ScriptedSource behind_;
    test::SteppedClock& clock_;
    Published& published_;
    test::Semaphore& begun_;
    test::Semaphore& done_;
    int count_ = 0;
    std::size_t works_done_ = 0;
  };
  Pipeline pipeline(
      options_, std::make_unique<TooFast>(clock_, *published_, begun, done),
      [&] {
        return [&](const ImageView&, DetectedFrame&) {
          begun.release();
          EXPECT_TRUE(done.try_acquire_for(kPatience));
        };
      },
      std::make_unique<RecordingPublisher>(published_), events_, clock_.clock());
  pipeline.Join();
  const auto poses = published_->poses();
  EXPECT_GE(poses.size(), kFrames / 2u - 1);
  for (const PosesMessage& message : poses)
    EXPECT_LE(message.published_monotonic - message.captured_monotonic, 2 * kWork) << message.sequence;
  const StatusMessage status = LastStatus();
  EXPECT_GT(status.frames_dropped, 0u);
  EXPECT_EQ(status.frames_published + status.frames_dropped, static_cast<std::uint64_t>(kFrames));
}

TEST_F(PipelineTest, KnowsAWorkerThatHangsFromOneThatWaits) {
  Gate gate;
  options_.workers = 2;
  Start(Frames(1, 1), [&] { return gate.Detector(); });
  ASSERT_TRUE(gate.WasEntered());
  EXPECT_EQ(pipeline_->Stuck({}), "");
  clock_.Advance(seconds(6));
  EXPECT_THAT(pipeline_->Stuck({}), HasSubstr("worker"));
  gate.open.release(10);
  ASSERT_TRUE(published_->WaitForPoses(1));
  EXPECT_THAT(pipeline_->Stuck({}), ::testing::Not(HasSubstr("worker")));
}

TEST_F(PipelineTest, KnowsAWorkerAtADearFrameFromOneThatHangs) {
  Gate gate;
  std::atomic<std::uint64_t> pieces{0};
  options_.pieces_done = [&](int) { return pieces.load(); };
  Start(Frames(1, 1), [&] { return gate.Detector(); });
  ASSERT_TRUE(gate.WasEntered());
  for (int i = 0; i < 20; ++i) {
    clock_.Advance(seconds(4));
    ++pieces;
    EXPECT_THAT(pipeline_->Stuck({}), ::testing::Not(HasSubstr("worker"))) << i;
  }
  clock_.Advance(seconds(6));
  EXPECT_THAT(pipeline_->Stuck({}), HasSubstr("worker 0"));
  gate.open.release(10);
  ASSERT_TRUE(published_->WaitForPoses(1));
}

TEST_F(PipelineTest, StopsWithoutAWorkerThatHangs) {
  Gate gate;
  options_.workers = 2;
  Start(Frames(1, 2), [&] { return gate.Detector(); });
  ASSERT_TRUE(gate.WasEntered());
  ASSERT_TRUE(ComesTrue([&] { return pipeline_->UnderWay() != ""; }));
  pipeline_->Stop();
  EXPECT_FALSE(pipeline_->WaitForEnd(milliseconds(10)));
  EXPECT_THAT(pipeline_->UnderWay(), HasSubstr("is at a frame"));
  EXPECT_TRUE(pipeline_->Abandon(kPatience));
  EXPECT_TRUE(PublishedSequences().empty());
  const StatusMessage status = LastStatus();
  EXPECT_EQ(status.frames_captured, status.frames_published + status.frames_dropped);
  gate.open.release(10);
  EXPECT_TRUE(pipeline_->WaitForEnd(kPatience));
}

/// Says nothing, and takes nothing, until it is let go.
class HangingPublisher final : public Publisher {
 public:
  explicit HangingPublisher(test::Semaphore& open) : open_(open) {}
  bool Publish(const PosesMessage&) override { return Hang(); }
  bool Publish(const StatusMessage&) override { return Hang(); }
  bool Publish(const RobotsMessage&) override { return Hang(); }
  bool Publish(const TracksMessage&) override { return Hang(); }
  bool PublishInCamera(const PosesMessage&) override { return Hang(); }
  PublisherHealth health() const override { return {}; }

 private:
  bool Hang() {
    if (open_.try_acquire_for(kPatience)) open_.release();
    return false;
  }
  test::Semaphore& open_;
};

TEST_F(PipelineTest, WorksOnWhileThePublisherHangsAndSaysSo) {
  test::Semaphore open{0};
  std::atomic<int> worked{0};
  std::atomic<std::uint64_t> failed{0};
  options_.status_period = milliseconds(1);
  events_.status = [&](const StatusMessage& status) { failed = status.publisher.failed; };
  Pipeline pipeline(
      options_, std::make_unique<ScriptedSource>(Frames(1, 100)),
      [&] { return [&](const ImageView&, DetectedFrame&) { ++worked; }; }, std::make_unique<HangingPublisher>(open),
      events_, clock_.clock());
  // Statuses alone are more than wait; the publisher has the first in its hands.
  EXPECT_TRUE(ComesTrue([&] {
    clock_.Advance(milliseconds(1));
    return worked > 0 && failed > 2;
  }));
  EXPECT_THAT(pipeline.UnderWay(), HasSubstr("LCM is being handed a message"));
  pipeline.Stop();
  EXPECT_FALSE(pipeline.WaitForEnd(milliseconds(10)));
  open.release();
  pipeline.Join();
}

TEST_F(PipelineTest, LeavesNothingBehindWhereAThreadCannotBeStarted) {
  options_.workers = 3;
  bool finished = false;
  events_.finished = [&] { finished = true; };
  // Two threads run when the first worker's is to be started, then three, then four.
  for (int workers_that_start = 0; workers_that_start < 3; ++workers_that_start) {
    std::optional<test::NoRoomForThreads> no_room;
    int made = 0;
    EXPECT_THROW(Start(Frames(1, 10),
                       [&] {
                         if (made++ == workers_that_start) no_room.emplace();
                         return FindSequence();
                       }),
                 std::system_error)
        << workers_that_start;
  }
  EXPECT_FALSE(finished);
}

TEST_F(PipelineTest, KnowsACameraThreadThatHangs) {
  class Hanging final : public FrameSource {
   public:
    explicit Hanging(Gate& gate) : gate_(gate) {}
    std::string Open() override { return {}; }
    CaptureResult Next(milliseconds) override {
      gate_.entered.release();
      EXPECT_TRUE(gate_.open.try_acquire_for(kPatience));  // whatever the timeout
      return {};
    }
    void Interrupt() override { gate_.open.release(10); }
    std::string Describe() const override { return "hanging camera"; }

   private:
    Gate& gate_;
  };
  Gate gate;
  Pipeline pipeline(options_, std::make_unique<Hanging>(gate), FindSequence,
                    std::make_unique<RecordingPublisher>(published_), events_, clock_.clock());
  ASSERT_TRUE(gate.WasEntered());
  EXPECT_EQ(pipeline.Stuck({}), "");
  clock_.Advance(seconds(6));
  EXPECT_THAT(pipeline.Stuck({}), HasSubstr("camera's thread"));
}

TEST_F(PipelineTest, WaitsForACameraWithoutBeingStuck) {
  options_.capture.first_reopen = options_.capture.longest_reopen = seconds(1000);
  auto source = std::make_unique<ScriptedSource>(std::vector<Step>(3, OpenFails("not there")));
  options_.status_period = milliseconds(1);
  std::atomic<bool> ready{false};
  events_.ready = [&] { ready = true; };
  Pipeline pipeline(options_, std::move(source), FindSequence, std::make_unique<RecordingPublisher>(published_),
                    events_, clock_.clock());
  // The first status may come before the camera is tried.
  ASSERT_TRUE(ComesTrue([&] {
    clock_.Advance(milliseconds(1));
    return ready.load();
  }));
  clock_.Advance(seconds(1000));
  EXPECT_TRUE(ComesTrue([&] { return pipeline.Stuck({}).empty(); }));
}

TEST_F(PipelineTest, DropsNothingWhenDrainedAndGoesOnWhereItLeftOff) {
  Gate gate;
  options_.when_busy = WhenBusy::kWait;
  Start({FrameNumber(1), FrameNumber(2), test::WaitsForInterrupt(), FrameNumber(3), kEnd},
        [&] { return gate.Detector(); });
  ASSERT_TRUE(gate.WasEntered());
  ASSERT_TRUE(ComesTrue([&] { return LeaseCount() == 2; }));  // the second waits for the worker
  pipeline_->Drain();
  gate.open.release(10);
  pipeline_->Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1, 2));
  PipelineState state = pipeline_->TakeState();
  EXPECT_TRUE(state.source_is_open);
  Pipeline next(options_, std::move(state), FindSequence, {}, clock_.clock());
  next.Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1, 2, 3));
  EXPECT_EQ(LastStatus().frames_published, 3u);
  EXPECT_EQ(LastStatus().frames_captured, 3u);
  EXPECT_EQ(LastStatus().frames_dropped, 0u);
  EXPECT_EQ(*leases_, 0);
}

TEST_F(PipelineTest, PinsItsWorkersAndNobodyElse) {
  const auto allowed = [] {
    cpu_set_t set;
    CPU_ZERO(&set);
    sched_getaffinity(0, sizeof set, &set);
    return CPU_COUNT(&set);
  };
  const int before = allowed();
  std::atomic<int> of_worker{0};
  options_.scheduling.cpus = {sched_getcpu()};
  events_.status = [&](const StatusMessage&) { EXPECT_EQ(allowed(), before); };
  Start({FrameNumber(1), kEnd}, [&] { return [&](const ImageView&, DetectedFrame&) { of_worker = allowed(); }; });
  pipeline_->Join();
  EXPECT_EQ(of_worker, 1);
}

TEST_F(PipelineTest, WorksOnWhereThreadsCannotBeAsUrgentAsAskedFor) {
  test::LogCapture log;
  options_.scheduling.realtime_priority = 99;  // capturing and publishing would be beyond what there is
  Start({FrameNumber(1), kEnd});
  pipeline_->Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1));
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("SCHED_FIFO"));
}

TEST_F(PipelineTest, SurvivesEveryTroubleOfACamera) {
  options_.when_busy = WhenBusy::kWait;
  Start({OpenFails("not there"), FrameNumber(1), Gives(CaptureStatus::kTimeout),
         Gives(CaptureStatus::kCorrupt, "cut off"), FrameNumber(3), Gives(CaptureStatus::kDisconnected, "unplugged"),
         OpenFails("not there"), FrameNumber(0), FrameNumber(4), kEnd});
  pipeline_->Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1, 3, 4, 8));
  EXPECT_EQ(published_->poses().back().frames_dropped, 4u);
  const StatusMessage status = LastStatus();
  EXPECT_EQ(status.camera_state, CameraState::kEnded);
  EXPECT_EQ(status.frames_captured, 4u);
  EXPECT_EQ(status.frames_published, 4u);
  EXPECT_EQ(status.frames_dropped, 4u);
}

TEST_F(PipelineTest, SendsAStatusOnceASecondAndAtTheEnd) {
  options_.when_busy = WhenBusy::kWait;
  Start(Frames(1, 10) + std::vector{kEnd},
        [this] { return [this](const ImageView&, DetectedFrame&) { clock_.Advance(milliseconds(250)); }; });
  pipeline_->Join();
  const auto statuses = published_->statuses();
  ASSERT_GE(statuses.size(), 2u);
  ASSERT_LE(statuses.size(), 3u);  // 2.5 s: one or two full seconds seen, and the end
  EXPECT_GE(statuses[0].window, seconds(1));
  EXPECT_EQ(statuses.back().frames_published, 10u);
  EXPECT_EQ(statuses.back().publisher.state, PublisherState::kReady);
}

TEST_F(PipelineTest, SendsItsStatusWithoutFramesToo) {
  options_.status_period = milliseconds(1);
  Start({});
  clock_.Advance(seconds(1));
  EXPECT_TRUE(published_->WaitForStatuses(1));
  pipeline_->Stop();
  pipeline_->Join();
  EXPECT_EQ(LastStatus().frames_published, 0u);
}

TEST_F(PipelineTest, FinishesWhatWorkersHaveBegunWhenStopped) {
  options_.workers = 2;
  Gate gate;
  Start(Frames(1, 3), [&] { return gate.Detector(); });
  ASSERT_TRUE(gate.WasEntered());
  pipeline_->Stop();
  gate.open.release(10);
  pipeline_->Join();
  const auto poses = published_->poses();
  ASSERT_GE(poses.size(), 1u);
  for (const PosesMessage& message : poses) EXPECT_EQ(message.markers.size(), 1u);
  const StatusMessage status = LastStatus();
  EXPECT_EQ(status.frames_captured, status.frames_published + status.frames_dropped);
  EXPECT_EQ(*leases_, 0);
}

TEST_F(PipelineTest, CountsTheFrameThatAStopThrowsAwayInTheLastStatusHoweverEarlyThatComes) {
  // Frame 1 is at the worker, frame 2 waits. The stop throws that away, and is held up there until all has ended.
  Gate gate;
  test::Semaphore both_came{0};
  class WhenItDies final : public FrameLease {
   public:
    explicit WhenItDies(std::function<void()> tell) : tell_(std::move(tell)) {}
    ~WhenItDies() override { tell_(); }

   private:
    std::function<void()> tell_;
  };
  class Watched final : public FrameSource {
   public:
    Watched(Gate& gate, test::Semaphore& both_came, std::function<void()> when_second_dies)
        : gate_(gate), both_came_(both_came), when_second_dies_(std::move(when_second_dies)) {}
    std::string Open() override { return behind_.Open(); }
    CaptureResult Next(milliseconds timeout) override {
      ++calls_;
      if (calls_ == 3) both_came_.release();
      EXPECT_TRUE(calls_ != 2 || gate_.WasEntered());
      CaptureResult result = behind_.Next(timeout);
      if (calls_ == 2) {
        result.frame.image = image_.view();
        result.frame.lease = std::make_unique<WhenItDies>(when_second_dies_);
      }
      return result;
    }
    void Interrupt() override { behind_.Interrupt(); }
    std::string Describe() const override { return behind_.Describe(); }

   private:
    ScriptedSource behind_{Frames(1, 2)};
    Image image_{PixelFormat::kMono8, 4, 2};
    Gate& gate_;
    test::Semaphore& both_came_;
    std::function<void()> when_second_dies_;
    int calls_ = 0;
  };
  const auto until_all_has_ended = [&] {
    gate.open.release(10);
    EXPECT_TRUE(published_->WaitForStatuses(1));
  };
  Pipeline pipeline(
      options_, std::make_unique<Watched>(gate, both_came, until_all_has_ended), [&] { return gate.Detector(); },
      std::make_unique<RecordingPublisher>(published_), events_, clock_.clock());
  ASSERT_TRUE(both_came.try_acquire_for(kPatience));
  pipeline.Stop();
  pipeline.Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1));
  EXPECT_EQ(LastStatus().frames_captured, 2u);
  EXPECT_EQ(LastStatus().frames_published, 1u);
  EXPECT_EQ(LastStatus().frames_dropped, 1u);
}

TEST_F(PipelineTest, StopsWhileTheCameraIsSilent) {
  Start(Frames(1, 1));
  EXPECT_TRUE(published_->WaitForPoses(1));
  pipeline_->Stop();
  pipeline_->Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1));
}

TEST_F(PipelineTest, StopsWhileItWaitsForTheCamera) {
  options_.status_period = milliseconds(1);
  Start(std::vector<Step>(100000, OpenFails("not there")));
  clock_.Advance(seconds(1));
  EXPECT_TRUE(published_->WaitForStatuses(1));
  pipeline_->Stop();
  pipeline_->Join();
  EXPECT_TRUE(PublishedSequences().empty());
}

TEST_F(PipelineTest, StopsWhenDestroyed) {
  Start(Frames(1, 1));
  pipeline_.reset();
  EXPECT_EQ(*leases_, 0);
}

TEST_F(PipelineTest, TellsWhenItIsReadyAndWhenItIsOver) {
  std::atomic<int> ready{0};
  test::Semaphore finished{0};
  events_.ready = [&] { ++ready; };
  events_.finished = [&] { finished.release(); };
  options_.when_busy = WhenBusy::kWait;
  Start(Frames(1, 5) + std::vector{kEnd});
  ASSERT_TRUE(finished.try_acquire_for(kPatience));
  pipeline_->Join();
  EXPECT_EQ(ready, 1);
  EXPECT_EQ(published_->poses().size(), 5u);
}

TEST_F(PipelineTest, IsReadyWhenThereIsACameraToWaitFor) {
  test::Semaphore ready{0};
  events_.ready = [&] { ready.release(); };
  options_.status_period = milliseconds(1);
  auto source = std::make_unique<ScriptedSource>(std::vector<Step>(100000, OpenFails("not there")));
  options_.capture.first_reopen = options_.capture.longest_reopen = milliseconds(1);
  // The host's clock: a status comes whenever one is due.
  Pipeline pipeline(options_, std::move(source), FindSequence, std::make_unique<RecordingPublisher>(published_),
                    events_);
  ASSERT_TRUE(ready.try_acquire_for(kPatience));
  EXPECT_TRUE(PublishedSequences().empty());
}

TEST_F(PipelineTest, IsReadyThoughNoFrameIsUsableAndSaysWhatIsWrong) {
  const std::vector<Step> wrong_size(100000, FrameNumber(1, 6));
  const std::vector<Step> corrupt(100000, Gives(CaptureStatus::kCorrupt, "is cut off"));
  options_.capture.size = FrameSize{4, 2};
  options_.status_period = milliseconds(1);
  for (const auto& script : {wrong_size, corrupt}) {
    std::mutex mutex;
    std::vector<std::string> said;  // of statuses and, at the end, of readiness
    test::Semaphore ready{0}, cause_said{0};
    events_.status = [&](const StatusMessage& status) {
      const std::string& cause = status.camera_message;
      {
        const std::lock_guard lock(mutex);
        said.push_back(cause);
      }
      if (cause.find("its calibration is for 4x2") != std::string::npos ||
          cause.find("frames are unusable: is cut off") != std::string::npos)
        cause_said.release();
    };
    events_.ready = [&] {
      {
        const std::lock_guard lock(mutex);
        said.push_back("ready");
      }
      ready.release();
    };
    // The host's clock: a status comes whenever one is due.
    Pipeline pipeline(options_, std::make_unique<ScriptedSource>(script), FindSequence,
                      std::make_unique<RecordingPublisher>(published_), events_);
    ASSERT_TRUE(ready.try_acquire_for(kPatience));
    // It may be ready before the first frame has come: once its camera is open.
    EXPECT_TRUE(cause_said.try_acquire_for(kPatience));
    pipeline.Stop();
    pipeline.Join();
    EXPECT_NE(std::find(said.begin(), said.end(), "ready"), said.begin()) << "a status comes first";
  }
  EXPECT_TRUE(PublishedSequences().empty());
}

TEST_F(PipelineTest, ThrowsWhatMakesASourceUseless) {
  Start({OpenThrows("recording /nowhere is not there")});
  try {
    pipeline_->Join();
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere"));
  }
}

TEST_F(PipelineTest, ThrowsWhatADetectorThrew) {
  options_.workers = 3;
  test::Semaphore finished{0};
  events_.finished = [&] { finished.release(); };
  Start(Frames(1, 100), [] {
    return [](const ImageView& image, DetectedFrame&) {
      if (test::SequenceIn(image) >= 3) throw std::logic_error("a bug");
    };
  });
  ASSERT_TRUE(finished.try_acquire_for(kPatience));
  EXPECT_THROW(pipeline_->Join(), std::logic_error);
  EXPECT_EQ(*leases_, 0);
}

const StageLatency& TotalLatency(const StatusMessage& status) {
  return *std::find_if(status.stages.begin(), status.stages.end(),
                       [](const StageLatency& stage) { return stage.stage == "total"; });
}

TEST_F(PipelineTest, MeasuresLatencyFromTheCapture) {
  // Frames are captured at `sequence` ms; the clock stands at 1000 s.
  Start({FrameNumber(400'000), kEnd});
  pipeline_->Join();
  EXPECT_EQ(TotalLatency(LastStatus()).worst, seconds(600));
}

TEST_F(PipelineTest, MeasuresLatencyFromTheArrivalWhereCaptureTimesAreOfAnotherDay) {
  options_.capture_times_are_live = false;
  Start({FrameNumber(400'000), kEnd});
  pipeline_->Join();
  EXPECT_EQ(TotalLatency(LastStatus()).worst, seconds(0));
  EXPECT_EQ(published_->poses().at(0).captured_monotonic, MonotonicTime(seconds(400)));
}

TEST_F(PipelineTest, DropsFramesOfAnotherSizeThanTheCalibrations) {
  options_.capture.size = FrameSize{4, 2};
  options_.when_busy = WhenBusy::kWait;
  Start({FrameNumber(1, 4), FrameNumber(2, 6), FrameNumber(3, 4), kEnd});
  pipeline_->Join();
  EXPECT_THAT(PublishedSequences(), ElementsAre(1, 3));
  EXPECT_EQ(LastStatus().frames_dropped, 1u);
}

}  // namespace
}  // namespace chequer
