#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "integration/workspace.h"
#include "publish/lcm_publisher.h"
#include "support/process.h"
#include "support/service_manager.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::Process;
using test::Received;
using test::ServiceManager;
using test::Subscriber;
using test::Workspace;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Service, ChecksAConfigurationWithoutStarting) {
  const Workspace workspace;
  Process good({CHEQUERD, "--check", "--config", workspace.Configure("loop = true")});
  EXPECT_EQ(good.Wait(), 0) << good.output();
  EXPECT_EQ(good.output(), "");
  Process bad({CHEQUERD, "--check", "--config", workspace.Configure("loop = 7")});
  EXPECT_EQ(bad.Wait(), 78);
  EXPECT_THAT(bad.output(), HasSubstr("capture.loop = 7"));
  Process no_processor({CHEQUERD, "--check", "--config", workspace.Configure("", "[pipeline]\ncpus = [1023]")});
  EXPECT_EQ(no_processor.Wait(), 78);
  EXPECT_THAT(no_processor.output(), HasSubstr("processor 1023 is not there"));
}

/// Those with an identity: a board that is not in the roster is still seen, without one.
std::ptrdiff_t Identified(const PosesMessage& message) {
  return std::count_if(message.markers.begin(), message.markers.end(),
                       [](const MarkerPose& marker) { return marker.id.has_value(); });
}

/// Receives until a frame has so many markers with an identity.
bool SeesMarkers(Subscriber& subscriber, std::ptrdiff_t count) {
  return subscriber.ReceiveUntil(
      [&](const Received& got) { return !got.poses.empty() && Identified(got.poses.back()) == count; });
}

// The camera waits for workers that are busy: a frame that is lost is lost by the change.
TEST(Service, TakesAChangedConfigurationOnSighup) {
  const Workspace workspace;
  ServiceManager manager(workspace.path() / "notify");
  Subscriber subscriber;
  const std::string config = workspace.Configure("loop = true", "[pipeline]\nwhen_busy = \"wait\"");
  Process daemon({CHEQUERD, "--config", config}, {manager.variable()});
  ASSERT_TRUE(SeesMarkers(subscriber, 8)) << daemon.output();
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  Process sed({"sed", "-i", "/^side/a roster = [\"0-2\"]", config});
  ASSERT_EQ(sed.Wait(), 0);
  daemon.Signal(SIGHUP);
  EXPECT_THAT(manager.WaitFor("RELOADING"), HasSubstr("RELOADING=1"));
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  ASSERT_TRUE(SeesMarkers(subscriber, 3)) << daemon.output();
  EXPECT_TRUE(daemon.WaitForOutput("marker changed")) << daemon.output();
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  const std::vector<PosesMessage>& poses = subscriber.received().poses;
  for (std::size_t i = 1; i < poses.size(); ++i) EXPECT_EQ(poses[i].sequence, poses[i - 1].sequence + 1);
  EXPECT_EQ(poses.back().frames_dropped, 0u);
}

TEST(Service, RefusesAConfigurationThatCannotWorkWhole) {
  const Workspace workspace;
  ServiceManager manager(workspace.path() / "notify");
  Subscriber subscriber;
  // The roster alone would be fine: nothing of a file is taken where something is wrong.
  const std::string config = workspace.Configure("loop = true");
  Process daemon({CHEQUERD, "--config", config}, {manager.variable()});
  ASSERT_TRUE(SeesMarkers(subscriber, 8)) << daemon.output();
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  Process sed({"sed", "-i", "-e", "/^side/a roster = [\"0-2\"]", "-e", "$a [pipeline]\\nworkers = -1", config});
  ASSERT_EQ(sed.Wait(), 0);
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitForOutput("pipeline.workers = -1")) << daemon.output();
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  EXPECT_THAT(manager.WaitFor("STATUS"), HasSubstr("changed configuration refused"));
  Process remove({"rm", config});
  ASSERT_EQ(remove.Wait(), 0);
  daemon.Signal(SIGHUP);
  EXPECT_TRUE(daemon.WaitForOutput("chequerd.toml: cannot be")) << daemon.output();
  const std::size_t before = subscriber.received().poses.size();
  ASSERT_TRUE(subscriber.ReceiveUntil([&](const Received& got) { return got.poses.size() > before + 5; }));
  EXPECT_EQ(Identified(subscriber.received().poses.back()), 8);
  EXPECT_TRUE(daemon.IsRunning());
}

TEST(Service, SurvivesManyReloadsInARow) {
  const Workspace workspace;
  Subscriber subscriber;
  const std::string config = workspace.Configure("loop = true\npace = \"unlimited\"");
  Process daemon({CHEQUERD, "--config", config});
  ASSERT_TRUE(SeesMarkers(subscriber, 8)) << daemon.output();
  for (int i = 0; i < 20; ++i) {
    daemon.Signal(SIGHUP);
    const std::size_t before = subscriber.received().poses.size();
    ASSERT_TRUE(subscriber.ReceiveUntil([&](const Received& got) { return got.poses.size() > before + 3; }));
  }
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0) << daemon.output();
}

TEST(Service, WaitsWhereItIsStartedAgainAfterAFailure) {
  const Workspace workspace;
  const std::string folder = "RUNTIME_DIRECTORY=" + workspace.path().string();
  const std::string config = workspace.Configure("loop = true");
  Process first({CHEQUERD, "--config", config}, {folder});
  ASSERT_TRUE(first.WaitForOutput("chequerd")) << first.output();
  first.Signal(SIGKILL);
  EXPECT_EQ(first.Wait(), 128 + SIGKILL);
  Process second({CHEQUERD, "--config", config}, {folder});
  EXPECT_TRUE(second.WaitForOutput("waiting 1 s")) << second.output();
  second.Signal(SIGHUP);  // is heeded when it has begun
  second.Signal(SIGTERM);
  EXPECT_EQ(second.Wait(milliseconds(500)), 0);
  EXPECT_THAT(second.output(), Not(HasSubstr("workers")));  // it has not begun
}

/// Lines of a table of the kernel's sockets whose state is LISTEN.
int ListeningTcpSockets() {
  int count = 0;
  for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    std::ifstream file(table);
    for (std::string line; std::getline(file, line);) {
      std::istringstream fields(line);
      std::string number, local, remote, state;
      fields >> number >> local >> remote >> state;
      count += state == "0A" ? 1 : 0;
    }
  }
  return count;
}

TEST(Service, ListensOnNoSocketUnlessAskedTo) {
  const Workspace workspace;
  {
    Subscriber subscriber;
    Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
    ASSERT_TRUE(SeesMarkers(subscriber, 8)) << daemon.output();
    EXPECT_EQ(ListeningTcpSockets(), 0);
  }
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true", "[metrics]\nport = 9464")});
  ASSERT_TRUE(SeesMarkers(subscriber, 8)) << daemon.output();
  EXPECT_EQ(ListeningTcpSockets(), 1);
}

TEST(Service, HeedsNothingFromTheNetwork) {
  const Workspace workspace;
  Subscriber subscriber;
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(SeesMarkers(subscriber, 8)) << daemon.output();
  // Messages of its own kind on its own channels, and rubbish to LCM's group.
  LcmPublisherOptions options;
  options.prefix = "CHEQUER_test";
  LcmPublisher forger(options);
  StatusMessage status;
  status.camera = "forged";
  status.camera_state = CameraState::kEnded;
  const UniqueFd socket_fd(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(7667);
  inet_pton(AF_INET, "239.255.76.67", &group.sin_addr);
  const std::string rubbish(1400, '\xFF');
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(forger.Publish(status));
    EXPECT_TRUE(forger.Publish(PosesMessage{}));
    EXPECT_GT(sendto(socket_fd.get(), rubbish.data(), rubbish.size(), 0, reinterpret_cast<const sockaddr*>(&group),
                     sizeof group),
              0);
  }
  ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) {
    return !got.statuses.empty() && got.statuses.back().camera == "test" && got.statuses.back().frames_published > 30;
  }));
  EXPECT_TRUE(daemon.IsRunning()) << daemon.output();
  EXPECT_EQ(subscriber.received().statuses.back().camera_state, CameraState::kRunning);
}

/// Receives what is sent to a multicast group, and with which time to live.
class GroupMember {
 public:
  GroupMember() {
    const int yes = 1;
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(7667);
    ip_mreq group{};
    inet_pton(AF_INET, "239.255.76.67", &group.imr_multiaddr);
    const timeval timeout{20, 0};
    if (setsockopt(fd_.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        setsockopt(fd_.get(), SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout) != 0 ||
        setsockopt(fd_.get(), IPPROTO_IP, IP_RECVTTL, &yes, sizeof yes) != 0 ||
        bind(fd_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        setsockopt(fd_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0)
      throw std::runtime_error("the group cannot be joined");
  }

  /// Of the next datagram; −1 if none comes.
  int TimeToLive() const {
    std::array<char, 65536> bytes{};
    std::array<char, 256> control{};
    iovec part{bytes.data(), bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (recvmsg(fd_.get(), &message, 0) < 0) return -1;
    for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header))
      if (header->cmsg_level == IPPROTO_IP && header->cmsg_type == IP_TTL) {
        int ttl = 0;
        std::memcpy(&ttl, CMSG_DATA(header), sizeof ttl);
        return ttl;
      }
    return -1;
  }

 private:
  UniqueFd fd_{socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
};

TEST(Service, KeepsItsMessagesOnThisHostUnlessToldOtherwise) {
  const Workspace workspace;
  {
    const GroupMember member;
    Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
    EXPECT_EQ(member.TimeToLive(), 0) << daemon.output();
  }
  const GroupMember member;
  Process daemon({CHEQUERD, "--config",
                  workspace.Configure("loop = true", "[publish]\nurl = \"udpm://239.255.76.67:7667?ttl=1\"")});
  EXPECT_EQ(member.TimeToLive(), 1) << daemon.output();
}

TEST(Status, TellsHowServicesFareByItsExitStatusToo) {
  const Workspace workspace;
  Process nobody({CHEQUER, "status", "--seconds", "0.2"});
  EXPECT_EQ(nobody.Wait(), 4);
  EXPECT_THAT(nobody.output(), HasSubstr("no camera was heard"));
  Process daemon({CHEQUERD, "--config", workspace.Configure("loop = true")});
  ASSERT_TRUE(daemon.WaitForOutput("workers")) << daemon.output();
  Process well({CHEQUER, "status", "test", "--seconds", "20"});
  EXPECT_EQ(well.Wait(), 0) << well.output();
  EXPECT_THAT(well.output(), AllOf(HasSubstr("running"), HasSubstr("8.0")));
  Process as_json({CHEQUER, "status", "test", "--json", "--seconds", "20"});
  EXPECT_EQ(as_json.Wait(), 0);
  EXPECT_THAT(as_json.output(), HasSubstr("\"warning_poor_illumination\":"));
  Process other({CHEQUER, "status", "north", "--seconds", "1.2"});
  EXPECT_EQ(other.Wait(), 4);
  EXPECT_THAT(other.output(), HasSubstr("no camera named north"));
  daemon.Signal(SIGTERM);
  EXPECT_EQ(daemon.Wait(), 0);
  Process waiting({CHEQUERD, "--config", workspace.Configure("faults = [\"vanish 0 1000000 opens\"]")});
  ASSERT_TRUE(waiting.WaitForOutput("cannot be opened"));
  Process unwell({CHEQUER, "status", "test", "--seconds", "20"});
  EXPECT_EQ(unwell.Wait(), 3) << unwell.output();
  EXPECT_THAT(unwell.output(), HasSubstr("test: the camera"));
}

}  // namespace
}  // namespace chequer
