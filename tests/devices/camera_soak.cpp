// camera_soak SECONDS [SEED]: chequerd on a camera of GigE Vision that is killed, halted and brought back at random
// times, in a private network (tests/support/in_namespace). By hand, for hours if need be. Status 0 if poses were right
// throughout, came back after each fault, no frame was lost but in faults, and the daemon holds no more than at first.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <stdexcept>

#include "devices/camera_test_tools.h"
#include "devices/swarm_truth.h"
#include "integration/workspace.h"
#include "support/process.h"
#include "support/temporary_directory.h"

namespace {

using chequer::PosesMessage;
using chequer::test::Holdings;
using chequer::test::HoldingsOf;
using chequer::test::Process;
using chequer::test::Received;
using chequer::test::Subscriber;
using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

void Require(bool right, const std::string& what) {
  if (!right) throw std::runtime_error(what);
}

/// What is checked of messages as they come; they are not kept, so that the soak itself stays small.
class Judge {
 public:
  explicit Judge(const std::filesystem::path& recording) : truth_(recording) {}

  void Look(const PosesMessage& message) {
    ++frames_;
    const std::string wrong = truth_.Judge(message);
    Require(wrong.empty(), wrong);
    Require(message.sequence > last_, "the sequence went back");
    last_ = message.sequence;
  }
  std::uint64_t frames() const { return frames_; }

 private:
  chequer::test::SwarmTruth truth_;
  std::uint64_t frames_ = 0;
  std::uint64_t last_ = 0;
};

/// Frames that the camera, or the way from it, lost so far. What a busy machine leaves out for newer ones does not
/// count.
std::uint64_t LostByCapture(const chequer::StatusMessage& status) {
  std::uint64_t lost = 0;
  for (const chequer::NamedCount& drop : status.drops)
    if (drop.name == "lost_before" || drop.name == "corrupt") lost += drop.count;
  return lost;
}

class Soak {
 public:
  explicit Soak(unsigned seed) : random_(seed) {
    Process render({CHEQUER, "render", "--size", "640x480", "--frames", "6", "--swarm", "5", "--distance", "1",
                    "--marker", "6x6", "--variant", "secded", "--side", "0.12", "--out", Swarm().string()});
    Require(render.Wait(seconds(100)) == 0, render.output());
    judge_ = std::make_unique<Judge>(Swarm());
    StartCamera();
    daemon_ = std::make_unique<Process>(std::vector<std::string>{
        CHEQUERD, "--config",
        chequer::test::CameraConfig(folder_.path(), "source = \"aravis\"\nfps = 60\npixel_format = \"BayerRG8\"",
                                    Swarm() / "camera.toml")});
  }

  void Run(double run_seconds) {
    const auto end = steady_clock::now() + std::chrono::duration<double>(run_seconds);
    Calm(3);
    DoFault();  // what libraries make once they have made by now
    Calm(3);
    const Holdings first = HoldingsOf(daemon_->pid());
    Tell(first);
    while (steady_clock::now() < end) {
      DoFault();
      Calm(std::uniform_real_distribution<double>(1, 20)(random_));
      const Holdings now = HoldingsOf(daemon_->pid());
      Tell(now);
      Require(now.descriptors <= first.descriptors && now.threads <= first.threads,
              "the daemon holds more than at first");
      Require(now.memory_kb < first.memory_kb + first.memory_kb / 5, "the daemon grows");
    }
    Require(lost_in_calm_ == 0, "frames were lost between faults");
    daemon_->Signal(SIGTERM);
    Require(daemon_->Wait() == 0, "the daemon did not end well");
  }

 private:
  void Tell(const Holdings& now) const {
    std::printf("%d faults, %llu frames, %llu lost between faults, %zu descriptors, %zu threads, %zu kB\n", faults_,
                static_cast<unsigned long long>(judge_->frames()), static_cast<unsigned long long>(lost_in_calm_),
                now.descriptors, now.threads, now.memory_kb);
    std::fflush(stdout);
  }

  std::filesystem::path Swarm() const { return folder_.path() / "swarm"; }

  void StartCamera() {
    camera_ = std::make_unique<Process>(std::vector<std::string>{GIGE_CAMERA, "127.0.0.1", "SOAK", Swarm().string()});
    Require(camera_->WaitForOutput("is up", seconds(60)), "the fake camera did not start: " + camera_->output());
  }

  /// Looks at messages until a condition holds.
  template <typename Condition>
  void Receive(bool calm, seconds longest, const Condition& condition) {
    Subscriber subscriber;
    std::size_t looked_at = 0;
    const bool held = subscriber.ReceiveUntil(
        [&](const Received& got) {
          for (; looked_at < got.poses.size(); ++looked_at) judge_->Look(got.poses[looked_at]);
          return condition(got);
        },
        longest);
    // Takes what it wrote, too: in a full pipe it would wait for a reader.
    Require(daemon_->IsRunning(), "the daemon ended: " + daemon_->output());
    Require(held, "no poses: " + daemon_->output());
    const auto& statuses = subscriber.received().statuses;
    if (calm && !statuses.empty()) lost_in_calm_ += LostByCapture(statuses.back()) - LostByCapture(statuses.front());
  }

  void Calm(double calm_seconds) {
    const auto end = steady_clock::now() + std::chrono::duration<double>(calm_seconds);
    Receive(true, seconds(60),
            [&](const Received& got) { return steady_clock::now() >= end && got.poses.size() > 10; });
  }

  void DoFault() {
    ++faults_;
    const milliseconds away(std::uniform_int_distribution<int>(0, 4000)(random_));
    const bool is_killed = std::bernoulli_distribution(0.5)(random_);
    camera_->Signal(is_killed ? SIGKILL : SIGSTOP);
    const auto back = steady_clock::now() + away;
    Process rest({"sleep", std::to_string(static_cast<double>(away.count()) / 1000)});
    rest.Wait();
    if (is_killed)
      StartCamera();
    else
      camera_->Signal(SIGCONT);
    Receive(false, seconds(15),
            [&](const Received& got) { return steady_clock::now() >= back && got.poses.size() > 10; });
  }

  chequer::test::TemporaryDirectory folder_;
  std::mt19937 random_;
  std::unique_ptr<Judge> judge_;
  std::unique_ptr<Process> camera_;
  std::unique_ptr<Process> daemon_;
  int faults_ = 0;
  std::uint64_t lost_in_calm_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: camera_soak SECONDS [SEED]\n");
    return 2;
  }
  const unsigned seed = argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1;
  std::printf("seed %u\n", seed);
  try {
    Soak(seed).Run(std::atof(argv[1]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "camera_soak: %s\n", error.what());
    return 1;
  }
  std::printf("all right\n");
  return 0;
}
