#include "daemon/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <fstream>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "support/deadline.h"
#include "support/log_capture.h"
#include "support/no_room_for_threads.h"
#include "support/recording_publisher.h"
#include "support/scripted_source.h"
#include "support/semaphore.h"
#include "support/stepped_clock.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using test::FrameNumber;
using test::Frames;
using test::Gives;
using test::kEnd;
using test::Opens;
using test::OpenThrows;
using test::Published;
using test::RecordingPublisher;
using test::ScriptedSource;
using test::Step;
using test::operator+;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::string Text(const std::string& rest, const std::string& capture = "path = \"swarm\"\n") {
  return "[capture]\n" + capture + "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\n" + rest;
}

DaemonConfig Config(const std::string& rest = {}, const std::string& capture = "path = \"swarm\"\n") {
  return ParseDaemonConfig(Text(rest, capture), "a.toml", "/base");
}

TEST(ChangedSections, AreThoseThatSaySomethingElse) {
  EXPECT_THAT(ChangedSections(Config(), Config()), IsEmpty());
  EXPECT_EQ(ChangedSections(Config(), Config("[log]\nlevel = \"debug\"\n")), "log");
  EXPECT_EQ(ChangedSections(Config("[pipeline]\nworkers = 2\n"), Config("", "path = \"other\"\n")),
            "capture, pipeline");
  EXPECT_EQ(ChangedSections(Config(), ParseDaemonConfig(Text("[[marker]]\nsize = \"8x8\"\nvariant = \"golay\"\n"),
                                                        "a.toml", "/base")),
            "marker");
}

TEST(ChangedSections, AreNotThoseThatSayTheSameInAnotherWay) {
  EXPECT_THAT(ChangedSections(Config("[log]\nlevel = \"debug\"\ntarget = \"auto\"\n"),
                              Config("# a comment\n[log] \ntarget='auto'\n\n  level   = \"debug\" # loud\n")),
              IsEmpty());
}

/// A roster that is edited takes effect with the next reload, which says so.
TEST(ChangedSections, AreThoseWhoseFilesSaySomethingElse) {
  const test::TemporaryDirectory folder;
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(folder / name) << text; };
  write("camera.toml",
        "[camera]\nwidth = 640\nheight = 480\nfx = 500\nfy = 500\ncx = 320\ncy = 240\nmodel = \"pinhole\"\n");
  write("world.toml", "[world]\nposition = [0, 0, 2]\norientation = [0, 1, 0, 0]\n");
  write("robots.toml", "[[robot]]\nname = \"alice\"\nid = 1\nheight = 0.1\n");
  write("kernels.txt", "0110100110010110\n");
  const std::string text =
      "[camera]\ncalibration = \"camera.toml\"\n[capture]\npath = \"swarm\"\n"
      "[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 0.1\n"
      "[[marker]]\nsize = \"6x6\"\nvariant = \"table\"\nside = 0.1\ntable = \"kernels.txt\"\n"
      "[world]\nfile = \"world.toml\"\n[robots]\nfile = \"robots.toml\"\n";
  const auto load = [&] { return ParseDaemonConfig(text, "a.toml", folder.path()); };
  const DaemonConfig before = load();
  EXPECT_THAT(ChangedSections(before, load()), IsEmpty());
  write("robots.toml", "[[robot]]\nname = \"bob\"\nid = 1\nheight = 0.1\n");
  EXPECT_EQ(ChangedSections(before, load()), "robots");
  write("world.toml", "[world]\nposition = [0, 0, 3]\norientation = [0, 1, 0, 0]\n");
  EXPECT_EQ(ChangedSections(before, load()), "robots, world");
  write("kernels.txt", "0110100110010111\n");
  EXPECT_EQ(ChangedSections(before, load()), "marker, robots, world");
  write("camera.toml",
        "[camera]\nwidth = 640\nheight = 480\nfx = 501\nfy = 500\ncx = 320\ncy = 240\nmodel = \"pinhole\"\n");
  EXPECT_EQ(ChangedSections(before, load()), "camera, marker, robots, world");
}

/// A service of scripted sources, one for each time that one is made, whose sequence numbers are those of a camera that
/// counts on.
class ServiceTest : public ::testing::Test {
 protected:
  ServiceTest() {
    parts_.make_source = [this](const CaptureOptions&) {
      ++sources_made_;
      std::vector<Step> script;
      if (!scripts_.empty()) {
        script = scripts_.front();
        scripts_.pop_front();
      }
      return std::make_unique<ScriptedSource>(std::move(script));
    };
    parts_.make_publisher = [this](const LcmPublisherOptions&) {
      ++publishers_made_;
      return std::make_unique<RecordingPublisher>(published_);
    };
    parts_.make_detect = [this](const DetectorOptions& options) {
      if (options.threads == 13) throw std::runtime_error("no detector has 13 threads");
      ++detectors_made_;
      return [](const ImageView& image, DetectedFrame& found) {
        MarkerPose marker;
        marker.id = test::SequenceIn(image);
        found.markers.push_back(marker);
      };
    };
    parts_.set_up_logging = [this](const DaemonConfig& config) { logged_as_ = config.log.level; };
    parts_.while_waiting = [this] { return ++looked_while_waiting_, goes_on_waiting_; };
    events_.ready = [this] { ++ready_; };
    events_.finished = [this] { finished_.release(); };
  }

  void Start(DaemonConfig config) { service_.emplace(std::move(config), "1.0", parts_, events_); }

  std::vector<std::uint64_t> Sequences() const {
    std::vector<std::uint64_t> sequences;
    for (const PosesMessage& message : published_->poses()) sequences.push_back(message.sequence);
    return sequences;
  }

  test::LogCapture log_;
  ServiceParts parts_;
  PipelineEvents events_;
  std::deque<std::vector<Step>> scripts_;
  std::atomic<int> ready_{0};
  test::Semaphore finished_{0};
  int looked_while_waiting_ = 0;
  bool goes_on_waiting_ = true;
  int sources_made_ = 0;
  int publishers_made_ = 0;
  int detectors_made_ = 0;
  LogLevel logged_as_ = LogLevel::kInfo;
  std::shared_ptr<Published> published_ = std::make_shared<Published>();
  std::optional<Service> service_;
};

const std::string kOneWorker = "[pipeline]\nworkers = 1\nwhen_busy = \"wait\"\n";

TEST_F(ServiceTest, KeepsCameraAndCountsWhereOnlyOtherThingsChange) {
  scripts_ = {std::vector{Opens()} + Frames(1, 3) + std::vector{test::WaitsForInterrupt()} + Frames(4, 6)};
  Start(Config(kOneWorker));
  ASSERT_TRUE(published_->WaitForPoses(3));
  service_->Reload(Config("[pipeline]\nworkers = 2\nwhen_busy = \"wait\"\n[log]\nlevel = \"error\"\n"));
  ASSERT_TRUE(published_->WaitForPoses(6));
  service_->Stop();
  service_->Join();
  EXPECT_THAT(Sequences(), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(sources_made_, 1);
  EXPECT_EQ(publishers_made_, 1);
  EXPECT_EQ(detectors_made_, 1 + 2);
  EXPECT_EQ(logged_as_, LogLevel::kError);
  EXPECT_EQ(ready_, 1);
  const StatusMessage last = published_->statuses().back();
  EXPECT_EQ(last.frames_captured, 6u);
  EXPECT_EQ(last.frames_published, 6u);
  EXPECT_EQ(last.frames_dropped, 0u);
  EXPECT_EQ(last.workers, 2);
  EXPECT_FALSE(finished_.try_acquire_for(milliseconds(0)) && finished_.try_acquire_for(milliseconds(0)));
}

/// Workers that are busy at once slow each other down.
TEST_F(ServiceTest, MeasuresTheMachineOnceForEachNumberOfWorkers) {
  std::vector<int> measured_with;
  parts_.measure_speed = [&](int workers) {
    measured_with.push_back(workers);
    return 1e7;
  };
  scripts_ = {std::vector{Opens()} + Frames(1, 1) + std::vector{test::WaitsForInterrupt()} + Frames(2, 2) +
              std::vector{test::WaitsForInterrupt()} + Frames(3, 3)};
  Start(Config("[pipeline]\nworkers = 1\n"));
  ASSERT_TRUE(published_->WaitForPoses(1));
  service_->Reload(Config("[pipeline]\nworkers = 2\n"));
  ASSERT_TRUE(published_->WaitForPoses(2));
  service_->Reload(Config("[pipeline]\nworkers = 2\n[log]\nlevel = \"error\"\n"));
  ASSERT_TRUE(published_->WaitForPoses(3));
  service_->Stop();
  service_->Join();
  EXPECT_THAT(measured_with, ElementsAre(1, 2));
}

TEST_F(ServiceTest, GoesOnCountingWithAnotherCamera) {
  // Before a reloaded recording is played it is tried, with a source of its own.
  scripts_ = {std::vector{Opens()} + Frames(10, 12), std::vector{Opens()} + Frames(0, 2), {}};
  Start(Config(kOneWorker));
  ASSERT_TRUE(published_->WaitForPoses(3));
  service_->Reload(Config(kOneWorker, "path = \"other\"\n"));
  ASSERT_TRUE(published_->WaitForPoses(6));
  service_->Stop();
  service_->Join();
  EXPECT_THAT(Sequences(), ElementsAre(10, 11, 12, 13, 14, 15));
  EXPECT_EQ(published_->statuses().back().frames_dropped, 0u);
}

TEST_F(ServiceTest, GivesMessagesToAnotherPublisherWithoutLosingCount) {
  scripts_ = {std::vector{Opens()} + Frames(1, 3) + std::vector{test::WaitsForInterrupt()} + Frames(4, 4)};
  Start(Config(kOneWorker));
  ASSERT_TRUE(published_->WaitForPoses(3));
  service_->Reload(Config(kOneWorker + "[publish]\nprefix = \"OTHER\"\n"));
  ASSERT_TRUE(published_->WaitForPoses(4));
  service_->Stop();
  service_->Join();
  EXPECT_EQ(publishers_made_, 2);
  // Each message so far: 4 frames, and the statuses before the last.
  EXPECT_EQ(published_->statuses().back().publisher.sent, 4 + published_->statuses().size() - 1);
}

TEST_F(ServiceTest, RefusesWhatCannotWorkAndGoesOnUndisturbed) {
  // The last is the one that is tried; the one before would have been played.
  scripts_ = {std::vector{Opens()} + Frames(1, 3), {}, {OpenThrows("recording /base/none is not there")}};
  Start(Config(kOneWorker));
  ASSERT_TRUE(published_->WaitForPoses(3));
  const std::size_t statuses = published_->statuses().size();
  EXPECT_THROW(service_->Reload(Config(kOneWorker + "[detect]\nthreads = 13\n")), std::runtime_error);
  EXPECT_THROW(service_->Reload(Config("[pipeline]\ncpus = [1023]\n")), std::runtime_error);
  EXPECT_THROW(service_->Reload(Config(kOneWorker, "path = \"none\"\n")), std::runtime_error);
  EXPECT_THAT(ChangedSections(service_->config(), Config(kOneWorker)), IsEmpty());
  EXPECT_EQ(published_->statuses().size(), statuses);  // a pipeline that ends sends one
  EXPECT_FALSE(finished_.try_acquire_for(milliseconds(0)));
}

/// A configuration whose source is not a recording: it can be tried only when the camera there is was given up.
DaemonConfig CameraConfig(const std::string& path) {
  DaemonConfig config = Config(kOneWorker, "path = \"" + path + "\"\n");
  config.capture.source = static_cast<SourceKind>(99);
  return config;
}

TEST_F(ServiceTest, ReturnsToTheFormerConfigurationWhereTheReloadedCameraCanNeverWork) {
  scripts_ = {
      std::vector{Opens()} + Frames(1, 3), {OpenThrows("no such pixel format")}, std::vector{Opens()} + Frames(7, 9)};
  Start(CameraConfig("one"));
  ASSERT_TRUE(published_->WaitForPoses(3));
  service_->Reload(CameraConfig("two"));
  ASSERT_TRUE(finished_.try_acquire_for(test::kPatience));
  EXPECT_TRUE(service_->GoesOn());
  ASSERT_TRUE(published_->WaitForPoses(6));
  EXPECT_THAT(Sequences(), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_EQ(service_->config().capture.replay.path, "/base/one");
  service_->Stop();
  service_->Join();
  std::string log;
  for (const std::string& line : log_.lines()) log += line + "\n";
  EXPECT_THAT(log, HasSubstr("no such pixel format"));
  EXPECT_THAT(log, HasSubstr("in force again"));
}

TEST_F(ServiceTest, EndsWhereAReloadedCameraHadProvedItsWorth) {
  scripts_ = {std::vector{Opens()} + Frames(1, 1),
              std::vector{Opens()} + Frames(1, 1) +
                  std::vector{Gives(CaptureStatus::kTimeout), test::WaitsForInterrupt(),
                              Gives(CaptureStatus::kDisconnected, "unplugged"), OpenThrows("another camera")}};
  Start(CameraConfig("one"));
  ASSERT_TRUE(published_->WaitForPoses(1));
  service_->Reload(CameraConfig("two"));
  ASSERT_TRUE(published_->WaitForPoses(2));
  service_->Settle();
  service_->Reload(CameraConfig("two"));  // wakes the script up
  ASSERT_TRUE(finished_.try_acquire_for(test::kPatience));
  EXPECT_THROW(service_->GoesOn(), std::runtime_error);
}

TEST_F(ServiceTest, IsLookedAfterWhileItWaitsForACameraThatIsBeingOpened) {
  test::Semaphore opening{0};
  class Slow final : public FrameSource {
   public:
    explicit Slow(test::Semaphore& opening) : opening_(opening) {}
    std::string Open() override {
      opening_.release();
      std::unique_lock lock(mutex_);
      // It heeds no interruption for longer than the service waits without being looked after.
      changed_.wait_for(lock, std::chrono::seconds(10), [this] { return interrupted_; });
      changed_.wait_for(lock, milliseconds(600), [] { return false; });
      return "not there";
    }
    CaptureResult Next(milliseconds) override { return {}; }
    void Interrupt() override {
      const std::lock_guard lock(mutex_);
      interrupted_ = true;
      changed_.notify_all();
    }
    std::string Describe() const override { return "slow camera"; }

   private:
    test::Semaphore& opening_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool interrupted_ = false;
  };
  parts_.make_source = [&](const CaptureOptions&) { return std::make_unique<Slow>(opening); };
  Start(CameraConfig("one"));
  ASSERT_TRUE(opening.try_acquire_for(test::kPatience));
  DaemonConfig next = CameraConfig("one");
  next.workers = 2;
  service_->Reload(next);
  EXPECT_GE(looked_while_waiting_, 1);
  service_.reset();  // while there is what its threads wait for
}

TEST_F(ServiceTest, StopsWaitingForAReloadWhenItIsToStop) {
  scripts_ = {{Opens(), FrameNumber(1)}};
  test::Semaphore entered{0}, open{0};
  parts_.make_detect = [&](const DetectorOptions&) {
    return [&](const ImageView&, DetectedFrame&) {
      entered.release();
      EXPECT_TRUE(open.try_acquire_for(test::kPatience));
    };
  };
  Start(Config(kOneWorker));
  ASSERT_TRUE(entered.try_acquire_for(test::kPatience));
  goes_on_waiting_ = false;
  EXPECT_THROW(service_->Reload(Config(kOneWorker + "[log]\nlevel = \"error\"\n")), ReloadInterrupted);
  service_->Stop();
  open.release();
  service_->Join();
  EXPECT_THAT(Sequences(), ElementsAre(1));
}

TEST_F(ServiceTest, SaysThatItIsLostWhereAReloadCannotStartItsThreads) {
  scripts_ = {{Opens(), FrameNumber(1)}};
  Start(Config(kOneWorker));
  ASSERT_TRUE(published_->WaitForPoses(1));
  const test::NoRoomForThreads no_room;
  EXPECT_THROW(service_->Reload(Config(kOneWorker + "[log]\nlevel = \"error\"\n")), ServiceLost);
}

TEST_F(ServiceTest, AFrameHasThreadsByWhatThereIsUnlessTheyAreCounted) {
  std::vector<int> threads;
  parts_.make_detect = [&](const DetectorOptions& options) {
    threads.push_back(options.threads);
    return [](const ImageView&, DetectedFrame&) {};
  };
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const std::string here = std::to_string(sched_getcpu());
  Start(Config("[pipeline]\nworkers = 1\n"));
  service_->Reload(Config("[pipeline]\nworkers = 1\ncpus = [" + here + "]\n"));
  service_->Reload(Config(kOneWorker));
  service_->Reload(Config(kOneWorker + "[detect]\nthreads = 3\n"));
  EXPECT_THAT(threads, ElementsAre(std::min(cores, 4), 1, 1, 3));
}

TEST_F(ServiceTest, DetectorsThreadsAreBegunAsTheirWorkerIs) {
  std::vector<DetectorOptions> made;
  parts_.make_detect = [&](const DetectorOptions& options) {
    made.push_back(options);
    return [](const ImageView&, DetectedFrame&) {};
  };
  const std::string here = std::to_string(sched_getcpu());
  Start(Config("[pipeline]\nworkers = 2\ncpus = [" + here + "]\nrealtime_priority = 5\n[detect]\nthreads = 2\n"));
  ASSERT_EQ(made.size(), 2u);
  std::thread([&] {
    made[1].on_thread_start(1);
    std::array<char, 16> name{};
    pthread_getname_np(pthread_self(), name.data(), name.size());
    EXPECT_STREQ(name.data(), "chq-help1.1");
    cpu_set_t set;
    CPU_ZERO(&set);
    ASSERT_EQ(sched_getaffinity(0, sizeof set, &set), 0);
    EXPECT_EQ(CPU_COUNT(&set), 1);
    sched_param parameter{};
    int policy = 0;
    pthread_getschedparam(pthread_self(), &policy, &parameter);
    // Refused without the right, as it is to the worker.
    if (policy == SCHED_FIFO) {
      EXPECT_EQ(parameter.sched_priority, 5);
    }
  }).join();
}

TEST_F(ServiceTest, HearsOfProgressWithinAFrame) {
  scripts_ = {{Opens(), FrameNumber(1)}};
  test::Semaphore entered{0}, open{0};
  std::function<void()> progress;
  parts_.make_detect = [&](const DetectorOptions& options) {
    progress = options.on_progress;
    return [&](const ImageView&, DetectedFrame&) {
      entered.release();
      EXPECT_TRUE(open.try_acquire_for(test::kPatience));
    };
  };
  test::SteppedClock clock;
  service_.emplace(Config(kOneWorker), "1.0", parts_, events_, clock.clock());
  ASSERT_TRUE(entered.try_acquire_for(test::kPatience));
  clock.Advance(std::chrono::seconds(6));
  progress();
  EXPECT_THAT(service_->Stuck({}), Not(HasSubstr("worker 0")));
  clock.Advance(std::chrono::seconds(6));
  EXPECT_THAT(service_->Stuck({}), HasSubstr("worker 0"));
  open.release();
  service_.reset();  // while there is what its threads wait for
}

TEST_F(ServiceTest, EndsWhenTheRecordingIsOver) {
  scripts_ = {std::vector{Opens()} + Frames(1, 2) + std::vector{kEnd}};
  Start(Config(kOneWorker));
  ASSERT_TRUE(finished_.try_acquire_for(test::kPatience));
  EXPECT_FALSE(service_->GoesOn());
  EXPECT_THAT(Sequences(), ElementsAre(1, 2));
}

TEST_F(ServiceTest, EndsOnceThoughItIsReloadedAtTheEnd) {
  scripts_ = {std::vector{Opens()} + Frames(1, 2) + std::vector{kEnd, kEnd}};
  Start(Config(kOneWorker));
  ASSERT_TRUE(finished_.try_acquire_for(test::kPatience));
  service_->Reload(Config(kOneWorker + "[log]\nlevel = \"error\"\n"));
  ASSERT_TRUE(finished_.try_acquire_for(test::kPatience));
  EXPECT_FALSE(service_->GoesOn());
  EXPECT_THAT(Sequences(), ElementsAre(1, 2));
}

}  // namespace
}  // namespace chequer
