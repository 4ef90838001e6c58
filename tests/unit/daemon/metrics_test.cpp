#include "daemon/metrics.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <prometheus/metric_family.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <iterator>
#include <vector>

#include "core/unique_fd.h"
#include "support/deadline.h"
#include "support/log_capture.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

StatusMessage SampleStatus() {
  StatusMessage status;
  status.version = "1.2.3";
  status.camera = "north";
  status.camera_state = CameraState::kRunning;
  status.publisher.state = PublisherState::kReady;
  status.publisher.sent = 70;
  status.publish_rate_hz = 59.5;
  status.frames_published = 66;
  status.drops = {{"superseded", 4}};
  status.detections = {{"boards", 50}};
  status.stages = {{"total", 60, milliseconds(5), milliseconds(8), milliseconds(9)}, {"queue", 0, {}, {}, {}}};
  return status;
}

std::string Text(const StatusMessage& status) {
  MetricTotals totals;
  totals.Add(status);
  return MetricsText(status, totals);
}

TEST(Metrics, OffersTheFiguresOfTheStatus) {
  const std::string text = Text(SampleStatus());
  for (const char* line :
       {"chequer_info{version=\"1.2.3\",camera=\"north\"} 1\n", "chequer_camera_running{camera=\"north\"} 1\n",
        "# TYPE chequer_frames_published_total counter\n", "chequer_frames_published_total{camera=\"north\"} 66\n",
        "chequer_frames_dropped_total{reason=\"superseded\",camera=\"north\"} 4\n",
        "chequer_messages_total{result=\"sent\",camera=\"north\"} 70\n",
        "chequer_latency_seconds{stage=\"total\",quantile=\"0.99\",camera=\"north\"} 0.008",
        "chequer_detections_total{what=\"boards\",camera=\"north\"} 50\n"})
    EXPECT_THAT(text, HasSubstr(line));
  EXPECT_THAT(text, Not(HasSubstr("stage=\"queue\"")));  // no frame went through: its times say nothing
}

TEST(Metrics, TellsACameraThatIsNotThere) {
  StatusMessage status = SampleStatus();
  status.camera_state = CameraState::kWaiting;
  status.publisher.state = PublisherState::kFailing;
  EXPECT_THAT(Text(status), AllOf(HasSubstr("chequer_camera_running{camera=\"north\"} 0\n"),
                                  HasSubstr("chequer_publisher_ready{camera=\"north\"} 0\n")));
}

TEST(Metrics, AddsUpWhatIsToldOfAWindowOnly) {
  MetricTotals totals;
  StatusMessage status = SampleStatus();
  totals.Add(status);
  status.detections = {{"boards", 7}, {"refused_fit", 1}};
  totals.Add(status);
  EXPECT_THAT(MetricsText(status, totals), AllOf(HasSubstr("what=\"boards\",camera=\"north\"} 57\n"),
                                                 HasSubstr("what=\"refused_fit\",camera=\"north\"} 1\n")));
}

TEST(Metrics, WritesAFileWithEachStatus) {
  const test::TemporaryDirectory folder;
  Metrics metrics({.port = 0, .file = folder / "chequer.prom"});
  metrics.Update(SampleStatus());
  std::ifstream file(folder / "chequer.prom");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), Text(SampleStatus()));
}

TEST(Metrics, ComplainsOnceOfAFileThatCannotBeWritten) {
  test::LogCapture log;
  Metrics metrics({.port = 0, .file = "/nowhere/at/all.prom"});
  for (int i = 0; i < 3; ++i) metrics.Update(SampleStatus());
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("/nowhere/at/all.prom"));
}

TEST(Metrics, DoNotWaitForTheReaderOfAPipe) {
  const test::TemporaryDirectory folder;
  ASSERT_EQ(::mkfifo((folder / "chequer.prom").c_str(), 0600), 0);
  const UniqueFd reader(::open((folder / "chequer.prom").c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  test::LogCapture log;
  Metrics metrics({.port = 0, .file = folder / "chequer.prom"});
  // More than a pipe holds.
  for (int i = 0; i < 400; ++i) metrics.Update(SampleStatus());
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("its reader has not read"));
}

/// A listening socket on a free port of the loopback interface.
struct Listening {
  UniqueFd fd{socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  sockaddr_in address{};

  Listening() {
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    if (bind(fd.get(), reinterpret_cast<sockaddr*>(&address), size) != 0 || listen(fd.get(), 1) != 0 ||
        getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0)
      throw std::runtime_error("no port can be had");
  }
  std::uint16_t port() const { return ntohs(address.sin_port); }
};

/// A connection over which a request, or a part of one, was sent.
UniqueFd Request(std::uint16_t port, const std::string& request) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  UniqueFd fd(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const timeval patience{test::kPatience.count(), 0};
  if (setsockopt(fd.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
      connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      write(fd.get(), request.data(), request.size()) < 0)
    return {};
  return fd;
}

std::string Ask(std::uint16_t port) {
  const UniqueFd fd = Request(port, "GET /metrics HTTP/1.0\r\n\r\n");
  std::string answer;
  std::array<char, 4096> bytes{};
  for (ssize_t count = 0; (count = read(fd.get(), bytes.data(), bytes.size())) > 0;)
    answer.append(bytes.data(), static_cast<std::size_t>(count));
  return answer;
}

TEST(Metrics, AnswersOnTheLoopbackInterface) {
  const std::uint16_t port = Listening().port();  // free again
  Metrics metrics({.port = port, .file = {}});
  metrics.Update(SampleStatus());
  EXPECT_THAT(Ask(port), AllOf(HasSubstr("200 OK"), HasSubstr("chequer_frames_published_total{camera=\"north\"} 66")));
}

TEST(Metrics, AnswersWhileOthersSendHalfARequest) {
  const std::uint16_t port = Listening().port();
  Metrics metrics({.port = port, .file = {}});
  metrics.Update(SampleStatus());
  std::vector<UniqueFd> half;
  for (int i = 0; i < 20; ++i) half.push_back(Request(port, "GET /metr"));
  EXPECT_THAT(Ask(port), HasSubstr("200 OK"));
}

TEST(Metrics, GoesOnWithoutAPortThatIsTaken) {
  test::LogCapture log;
  const Listening other;
  Metrics metrics({.port = other.port(), .file = {}});
  metrics.Update(SampleStatus());
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("is the port taken?"));
}

}  // namespace
}  // namespace chequer
