#include "publish/tcpq_connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>

#include "publish/lcm_publisher.h"
#include "support/error_of.h"
#include "support/log_capture.h"
#include "support/stepped_clock.h"
#include "support/tcp_server.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using std::chrono::seconds;
using test::ErrorOf;
using test::LcmGreeting;
using test::TcpServer;
using ::testing::HasSubstr;

LcmUrl UrlOf(const TcpServer& server) { return ParseLcmUrl(server.url(), LcmDirection::kPublish); }

TEST(TcpqConnection, SendsWhatLcmItselfSends) {
  const std::string text = "what is sent";
  const std::vector<std::uint8_t> message(text.begin(), text.end());
  // Twice a greeting's answer, then the message: kind, length, channel, length, payload.
  const std::size_t length = 8 + 4 + 4 + 7 + 4 + message.size();
  std::string expected, sent;
  {
    TcpServer server(TcpServer::Manner::kListens, LcmGreeting());
    lcm::LCM lcm(server.url());
    ASSERT_TRUE(lcm.good());
    ASSERT_EQ(lcm.publish("CHANNEL", message.data(), static_cast<unsigned>(message.size())), 0);
    expected = server.WaitForBytes(length);
  }
  {
    TcpServer server(TcpServer::Manner::kListens, LcmGreeting());
    TcpqConnection connection(UrlOf(server));
    EXPECT_EQ(connection.Send("CHANNEL", message), "");
    sent = server.WaitForBytes(length);
  }
  EXPECT_EQ(expected.size(), length);
  EXPECT_EQ(sent, expected);
}

TEST(TcpqConnection, GivesUpAServerThatSaysNothing) {
  const TcpServer server(TcpServer::Manner::kSilent);
  EXPECT_THAT(ErrorOf([&] { TcpqConnection{UrlOf(server)}; }), HasSubstr("accepts and says nothing"));
}

TEST(TcpqConnection, KnowsAServerOfAnotherKind) {
  const TcpServer server(TcpServer::Manner::kGreets, "HTTP/1.1 400 Bad Request");
  EXPECT_THAT(ErrorOf([&] { TcpqConnection{UrlOf(server)}; }), HasSubstr("no LCM TCP server"));
}

TEST(TcpqConnection, GivesUpAServerThatStopsReading) {
  const TcpServer server(TcpServer::Manner::kGreets, LcmGreeting());
  TcpqConnection connection(UrlOf(server));
  const std::vector<std::uint8_t> message(1 << 20);
  std::string why;
  for (int i = 0; i < 64 && why.empty(); ++i) why = connection.Send("CHANNEL", message);  // buffers of the kernel
  EXPECT_THAT(why, HasSubstr("does not read"));
}

TEST(TcpqConnection, SurvivesAServerThatIsGone) {
  auto server = std::make_unique<TcpServer>(TcpServer::Manner::kListens, LcmGreeting());
  TcpqConnection connection(UrlOf(*server));
  server.reset();
  const std::vector<std::uint8_t> message(1000);
  std::string why;
  for (int i = 0; i < 100 && why.empty(); ++i) why = connection.Send("CHANNEL", message);
  EXPECT_NE(why, "");  // and no SIGPIPE
}

TEST(LcmPublisher, ConnectsAgainToATcpServerThatFailed) {
  test::SteppedClock time;
  test::LogCapture log;
  TcpServer server(TcpServer::Manner::kListens);  // silent at first
  LcmPublisher publisher({server.url(), "CHEQUER"}, time.clock());
  EXPECT_EQ(publisher.health().state, PublisherState::kWaiting);
  EXPECT_THAT(publisher.health().message, HasSubstr(server.url()));
  EXPECT_FALSE(publisher.Publish(test::SamplePoses(1)));
  EXPECT_EQ(publisher.health().failed, 1u);
  ASSERT_EQ(log.lines().size(), 1u);
  EXPECT_THAT(log.lines()[0], HasSubstr("accepts and says nothing"));
  server.SetGreeting(LcmGreeting());
  time.Advance(seconds(60));
  EXPECT_TRUE(publisher.Publish(test::SamplePoses(1)));
  EXPECT_EQ(publisher.health().state, PublisherState::kReady);
  EXPECT_GT(server.WaitForBytes(16 + 187).size(), 187u);
}

}  // namespace
}  // namespace chequer
