// The client kit of examples/: each client's latest, new and next; the followers in a closed loop.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <latch>
#include <lcm/lcm-cpp.hpp>
#include <numbers>
#include <thread>

#include "cpp/chequer_client.h"
#include "example/drive_t.hpp"
#include "publish/lcm_publisher.h"
#include "publish/wire.h"
#include "support/process.h"
#include "support/temporary_directory.h"

extern "C" {
#include "c/chequer_client.h"
}

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Process;
using test::TemporaryDirectory;
using ::testing::HasSubstr;

/// A robot that drives as it is told.
struct Robot {
  double x = 0, y = 0, heading = 0, speed = 0, yaw_rate = 0;

  void Drive(double time_s) {
    x += speed * std::cos(heading) * time_s;
    y += speed * std::sin(heading) * time_s;
    heading += yaw_rate * time_s;
  }
};

TrackState TrackOf(const std::string& name, const Robot& robot) {
  TrackState track;
  track.key.robot = name;
  track.frame_from_body = {RotationFromVector({0, 0, robot.heading}), {robot.x, robot.y, 0}};
  track.velocity = robot.speed * Eigen::Vector3d(std::cos(robot.heading), std::sin(robot.heading), 0);
  track.angular_velocity = {0, 0, robot.yaw_rate};
  return track;
}

PosesMessage PosesOf(std::uint64_t id, double x) {
  PosesMessage message;
  MarkerPose marker;
  marker.id = id;
  marker.has_pose = true;
  marker.camera_from_marker.translation = {x, 2, 3};
  message.markers.push_back(marker);
  return message;
}

TracksMessage Message(const std::vector<TrackState>& tracks) {
  TracksMessage message;
  message.header.frame = "world";
  message.tracks = tracks;
  return message;
}

LcmPublisher ArenaPublisher(const std::string& url = LcmPublisherOptions{}.url) {
  return LcmPublisher({.url = url, .prefix = "ARENA"});
}

std::string Example(const std::string& name) { return std::string(EXAMPLES_BUILD) + "/" + name; }
std::string Script(const std::string& name) { return std::string(EXAMPLES_SOURCE) + "/python/" + name; }
std::vector<std::string> PythonPath() {
  return {"PYTHONPATH=" + std::string(EXAMPLES_BUILD) + "/generated/python", "PYTHONDONTWRITEBYTECODE=1"};
}

/// Sends over and over until a program has understood; false when it does not in time.
template <typename Send, typename Understood>
bool SendUntil(const Send& send, const Understood& understood) {
  const auto deadline = std::chrono::steady_clock::now() + seconds(20);
  while (std::chrono::steady_clock::now() < deadline) {
    send();
    if (understood()) return true;
  }
  return false;
}

TEST(CppClient, GivesTheLatestTheNewAndTheNext) {
  chequer::client::Target<int> target;
  EXPECT_EQ(target.Latest(), std::nullopt);
  EXPECT_EQ(target.New(milliseconds(1)), std::nullopt);
  target.Put(1);
  EXPECT_EQ(target.New(milliseconds(0)), 1);
  EXPECT_EQ(target.New(milliseconds(1)), std::nullopt) << "it was given before";
  EXPECT_EQ(target.Latest(), 1) << "that may be had again and again";
  target.Put(2);
  target.Put(3);
  EXPECT_EQ(target.New(milliseconds(0)), 3);
  target.Put(4);
  EXPECT_EQ(target.Next(milliseconds(1)), std::nullopt) << "it came before the call";
  std::jthread later([&] { target.Put(5); });
  const auto next = target.New(seconds(10));
  EXPECT_TRUE(next == 4 || next == 5);
}

TEST(CppClient, NextWaitsForWhatComesAfterTheCall) {
  chequer::client::Target<int> target;
  target.Put(1);
  std::jthread later([&](const std::stop_token& stop) {
    for (int i = 2; !stop.stop_requested(); ++i) target.Put(i);
  });
  const auto next = target.Next(seconds(10));
  ASSERT_TRUE(next.has_value());
  EXPECT_GT(*next, 1);
}

TEST(CClient, GivesTheLatestTheNewAndTheNext) {
  chequer_client* client = chequer_open("ARENA", nullptr);
  ASSERT_NE(client, nullptr);
  chequer_target* alice = chequer_watch_track(client, "alice");
  chequer_target* marker = chequer_watch_marker(client, 1ull << 63);
  chequer_state state{};
  EXPECT_EQ(chequer_latest(alice, &state), 0);
  EXPECT_EQ(chequer_new(alice, &state, 1), 0);
  LcmPublisher publisher = ArenaPublisher();
  const auto send = [&](double x) {
    publisher.Publish(Message({TrackOf("alice", {.x = x, .heading = 0.5, .speed = 2})}));
  };
  // Datagrams may be lost where much is sent: each is sent again until it comes.
  ASSERT_TRUE(SendUntil([&] { send(1); }, [&] { return chequer_new(alice, &state, 1000) == 1; }));
  EXPECT_EQ(state.position[0], 1);
  EXPECT_NEAR(state.heading, 0.5, 1e-12);
  EXPECT_NEAR(std::hypot(state.velocity[0], state.velocity[1]), 2, 1e-12);
  EXPECT_EQ(chequer_new(alice, &state, 1), 0) << "it was given before";
  EXPECT_EQ(chequer_latest(alice, &state), 1);
  EXPECT_EQ(chequer_next(alice, &state, 1), 0) << "it came before the call";
  std::jthread later([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) send(2);
  });
  ASSERT_EQ(chequer_next(alice, &state, 10'000), 1);
  EXPECT_EQ(state.position[0], 2);
  later.request_stop();
  later.join();
  // What was sent without a pause has filled the socket, so that the first that comes after it may find no place.
  ASSERT_TRUE(SendUntil([&] { publisher.Publish(PosesOf(1ull << 63, 7)); },
                        [&] { return chequer_new(marker, &state, 1000) == 1; }));
  EXPECT_EQ(state.position[0], 7);
  chequer_close(client);
}

TEST(Watch, PrintsTheTrackOfARobotInEachLanguage) {
  LcmPublisher publisher = ArenaPublisher();
  const std::vector<std::vector<std::string>> commands{{Example("example_watch_cpp"), "ARENA", "alice"},
                                                       {Example("example_watch_c"), "ARENA", "alice"},
                                                       {"/usr/bin/python3", Script("watch.py"), "ARENA", "alice"}};
  for (const auto& command : commands) {
    Process watch(command, PythonPath());
    ASSERT_TRUE(watch.WaitForOutput("watching")) << command[0] << watch.output();
    EXPECT_TRUE(SendUntil(
        [&] {
          publisher.Publish(Message({TrackOf("bob", {.x = 9}), TrackOf("alice", {.x = 1.5, .speed = 0.25})}));
        },
        [&] {
          return watch.WaitForOutput("alice 1.5000 0.0000 m, heading 0.0000 rad, 0.2500 m/s", milliseconds(100));
        }))
        << command[0] << watch.output();
  }
}

TEST(Watch, PrintsTheRawPoseOfAMarkerToo) {
  LcmPublisher publisher = ArenaPublisher();
  const std::vector<std::vector<std::string>> commands{{Example("example_watch_c"), "ARENA", "17"},
                                                       {Example("example_watch_cpp"), "ARENA", "17"},
                                                       {"/usr/bin/python3", Script("watch.py"), "ARENA", "17"}};
  for (const auto& command : commands) {
    Process watch(command, PythonPath());
    ASSERT_TRUE(watch.WaitForOutput("watching")) << command[0] << watch.output();
    EXPECT_TRUE(SendUntil([&] { publisher.Publish(PosesOf(17, 0.25)); },
                          [&] { return watch.WaitForOutput("17 0.2500 2.0000 m", milliseconds(100)); }))
        << command[0] << watch.output();
  }
}

/// A message of nothing but its head, whose count of elements, which comes last, is what an attacker wishes.
template <typename Message>
std::vector<std::uint8_t> WithCount(const Message& empty, std::uint32_t count) {
  WireEncoder encoder;
  const auto encoded = encoder.Encode(empty);
  std::vector<std::uint8_t> bytes(encoded.begin(), encoded.end());
  for (std::size_t i = 0; i < 4; ++i) bytes[bytes.size() - 1 - i] = static_cast<std::uint8_t>(count >> (8 * i));
  return bytes;
}

/// What plain lcm-gen's decoders end a program with: counts that are negative, or far beyond the message's bytes; texts
/// of no, of negative and of endless length.
std::vector<std::vector<std::uint8_t>> HostileMessages() {
  std::vector<std::vector<std::uint8_t>> messages;
  for (const std::uint32_t count : {0xffffffffu, 0x80000000u, 0x7fffffffu, 1u, 100'000u}) {
    messages.push_back(WithCount(TracksMessage{}, count));
    messages.push_back(WithCount(PosesMessage{}, count));
  }
  const std::vector<std::uint8_t> tracks = WithCount(TracksMessage{}, 0);
  constexpr std::size_t kLengthOfCamera = 8 + 7 * 8 + 1;  // after the fingerprint, the times, and the sequence
  for (const int length : {0x00, 0x7f, 0x80, 0xff}) {
    messages.push_back(tracks);
    std::fill_n(messages.back().begin() + kLengthOfCamera, 4, static_cast<std::uint8_t>(length));
  }
  for (std::vector<std::uint8_t> cut = tracks; !cut.empty(); messages.push_back(cut)) cut.pop_back();
  return messages;
}

TEST(Watch, LivesOnAfterHostileMessagesInEachLanguage) {
  const std::vector<std::vector<std::uint8_t>> hostile = HostileMessages();
  lcm::LCM attacker;
  LcmPublisher publisher = ArenaPublisher();
  const std::vector<std::vector<std::string>> commands{{Example("example_watch_cpp"), "ARENA", "alice"},
                                                       {Example("example_watch_c"), "ARENA", "alice"},
                                                       {"/usr/bin/python3", Script("watch.py"), "ARENA", "alice"}};
  for (const auto& command : commands) {
    Process watch(command, PythonPath());
    ASSERT_TRUE(watch.WaitForOutput("watching")) << command[0] << watch.output();
    const auto understood = [&](double x) {
      char text[64];
      std::snprintf(text, sizeof text, "alice %.4f 0.0000 m", x);
      return SendUntil([&] { publisher.Publish(Message({TrackOf("alice", {.x = x})})); },
                       [&] { return watch.WaitForOutput(text, milliseconds(100)); });
    };
    ASSERT_TRUE(understood(1)) << "before the attack: " << command[0] << watch.output();
    for (std::size_t i = 0; i < hostile.size(); ++i) {
      for (const char* channel : {"ARENA_TRACKS", "ARENA_POSES"})
        attacker.publish(channel, hostile[i].data(), static_cast<unsigned>(hostile[i].size()));
      // LCM keeps 30 messages; more would be dropped before they were decoded.
      if (i % 10 == 9) {
        ASSERT_TRUE(understood(2 + static_cast<double>(i))) << i << command[0] << watch.output();
      }
    }
    EXPECT_TRUE(understood(1000)) << command[0] << watch.output();
  }
}

/// Two robots: the leader goes round a circle, the follower does what it is told.
class ClosedLoop {
 public:
  ClosedLoop() { lcm_.subscribe("bob_DRIVE", &ClosedLoop::OnDrive, this); }

  /// Waits until a follower listens, then drives on.
  bool Begin() {
    return SendUntil([this] { Send(); }, [this] { return lcm_.handleTimeout(100) > 0 && drive_.yaw_rate != 0; });
  }
  /// False where no command comes in time.
  bool Step() {
    constexpr double kStepS = 0.05;
    alice_.Drive(kStepS);
    bob_.Drive(kStepS);
    Send();
    return lcm_.handleTimeout(5000) > 0;
  }
  double distance() const { return std::hypot(alice_.x - bob_.x, alice_.y - bob_.y); }

 private:
  void Send() { publisher_.Publish(Message({TrackOf("alice", alice_), TrackOf("bob", bob_)})); }
  void OnDrive(const lcm::ReceiveBuffer* /*buffer*/, const std::string& /*channel*/, const example::drive_t* drive) {
    drive_ = *drive;
    bob_.speed = drive->speed;
    bob_.yaw_rate = drive->yaw_rate;
  }

  LcmPublisher publisher_ = ArenaPublisher();
  lcm::LCM lcm_;
  example::drive_t drive_{};
  Robot alice_{.x = 1, .y = 0, .heading = std::numbers::pi / 2, .speed = 0.2, .yaw_rate = 0.2};
  Robot bob_{.x = -0.5, .y = 0.5, .heading = 2.5};
};

TEST(Follow, ClosesTheLoopInEachLanguage) {
  const std::vector<std::vector<std::string>> commands{
      {Example("example_follow_cpp"), "ARENA", "alice", "bob"},
      {Example("example_follow_c"), "ARENA", "alice", "bob"},
      {"/usr/bin/python3", Script("follow.py"), "ARENA", "alice", "bob"}};
  for (const auto& command : commands) {
    Process follow(command, PythonPath());
    ClosedLoop loop;
    ASSERT_TRUE(loop.Begin()) << command[0] << follow.output();
    EXPECT_GT(loop.distance(), 1.0);
    for (int i = 0; i < 400; ++i) ASSERT_TRUE(loop.Step()) << command[0] << follow.output();
    EXPECT_GT(loop.distance(), 0.3) << command[0];
    EXPECT_LT(loop.distance(), 0.5) << command[0];
  }
}

/// An LCM log of alice driving along x.
std::string WriteLog(const TemporaryDirectory& folder) {
  const std::string path = folder / "tracks.lcm";
  LcmPublisher publisher = ArenaPublisher("file://" + path + "?mode=w");
  for (int i = 0; i < 3; ++i) {
    publisher.Publish(Message({TrackOf("alice", {.x = 0.5 * i, .speed = 0.25}), TrackOf("bob", {.y = 1})}));
    publisher.Publish(PosesOf(17, 0.25 * i));
  }
  return path;
}

TEST(PythonWithoutTheLcmModule, ReceivesMessagesOfSeveralDatagrams) {
  LcmPublisher publisher = ArenaPublisher();
  PosesMessage many = PosesOf(17, 0.25);
  for (std::uint64_t id = 1000; id < 2000; ++id) many.markers.push_back(PosesOf(id, 0).markers.front());
  std::swap(many.markers.front(), many.markers.back());
  Process watch({"/usr/bin/python3", Script("watch.py"), "ARENA", "17"}, PythonPath());
  ASSERT_TRUE(watch.WaitForOutput("watching")) << watch.output();
  EXPECT_TRUE(SendUntil([&] { publisher.Publish(many); },
                        [&] { return watch.WaitForOutput("17 0.2500 2.0000 m", milliseconds(100)); }))
      << watch.output();
}

TEST(PythonWithoutTheLcmModule, ReadsALog) {
  const TemporaryDirectory folder;
  const std::string log = WriteLog(folder);
  Process watch({"/usr/bin/python3", Script("watch.py"), "ARENA", "alice", log}, PythonPath());
  EXPECT_EQ(watch.Wait(), 0) << watch.output();
  for (const char* line :
       {"alice 0.0000 0.0000 m", "alice 0.5000 0.0000 m", "alice 1.0000 0.0000 m, heading 0.0000 rad, 0.2500 m/s"})
    EXPECT_THAT(watch.output(), HasSubstr(line));
  Process marker({"/usr/bin/python3", Script("watch.py"), "ARENA", "17", log}, PythonPath());
  EXPECT_EQ(marker.Wait(), 0) << marker.output();
  EXPECT_THAT(marker.output(), HasSubstr("17 0.5000 2.0000 m"));
  Process follow({"/usr/bin/python3", Script("follow.py"), "ARENA", "alice", "bob", log}, PythonPath());
  EXPECT_EQ(follow.Wait(), 0) << follow.output();
  EXPECT_THAT(follow.output(), HasSubstr("-2.000 rad/s"));
}

TEST(PythonWithoutTheLcmModule, NamesALogThatIsNone) {
  const TemporaryDirectory folder;
  const std::string log = WriteLog(folder);
  const auto complaint = [&](const std::string& file) {
    Process watch({"/usr/bin/python3", Script("watch.py"), "ARENA", "nobody", file}, PythonPath());
    EXPECT_EQ(watch.Wait(), 1);
    return watch.output();
  };
  EXPECT_THAT(complaint(log), HasSubstr("nothing of nobody came"));
  std::filesystem::resize_file(log, std::filesystem::file_size(log) - 5);
  EXPECT_THAT(complaint(log), HasSubstr("cut off"));
  std::ofstream(folder / "text") << std::string(100, 'x');
  EXPECT_THAT(complaint(folder / "text"), HasSubstr("no LCM log"));
  EXPECT_THAT(complaint(folder / "none"), HasSubstr("none"));
}

}  // namespace
}  // namespace chequer
