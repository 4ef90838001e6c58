#include "publish/lcm_url.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/unique_fd.h"
#include "publish/channels.h"
#include "publish/lcm_publisher.h"
#include "publish/lcm_subscriber.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Refusal(const std::string& url, LcmDirection direction = LcmDirection::kPublish) {
  return test::ErrorOf([&] { ParseLcmUrl(url, direction); });
}

TEST(LcmUrl, UnderstandsTheDefault) {
  const LcmUrl url = ParseLcmUrl(kDefaultLcmUrl, LcmDirection::kPublish);
  EXPECT_EQ(url.provider, LcmProvider::kUdpMulticast);
  EXPECT_EQ(url.address, "239.255.76.67");
  EXPECT_EQ(url.port, 7667);
  EXPECT_EQ(url.arguments.at("ttl"), "0");
}

TEST(LcmUrl, StandsInTheOptionsAsItsConstant) { EXPECT_EQ(LcmPublisherOptions{}.url, kDefaultLcmUrl); }

TEST(LcmUrl, FillsInAnEmptyNetworkAsLcmDoes) {
  EXPECT_EQ(ParseLcmUrl("udpm://", LcmDirection::kPublish).port, 7667);
  EXPECT_EQ(ParseLcmUrl("tcpq://", LcmDirection::kPublish).port, 7700);
}

TEST(LcmUrl, RefusesWithTheUrlAndWhatWouldBeRight) {
  EXPECT_THAT(Refusal("239.255.76.67:7667"), AllOf(HasSubstr("'239.255.76.67:7667'"), HasSubstr("udpm://")));
  EXPECT_THAT(Refusal("udp://239.255.76.67:7667"), HasSubstr("must begin with udpm://"));
  EXPECT_THAT(Refusal(""), HasSubstr("must begin with"));
  EXPECT_THAT(Refusal("udpm://localhost:7667"), HasSubstr("'localhost' is not an IPv4 address"));
  EXPECT_THAT(Refusal("udpm://127.0.0.1:7667"), HasSubstr("224.0.0.0 to 239.255.255.255"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67"), HasSubstr("port, 1 to 65535"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67:0"), HasSubstr("port, 1 to 65535"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67:70000"), HasSubstr("port, 1 to 65535"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67:7667?tll=0"), HasSubstr("unknown argument 'tll'; udpm knows ttl"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67:7667?ttl=256"), HasSubstr("ttl is '256'; it must be"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67:7667?ttl="), HasSubstr("ttl is ''"));
  EXPECT_THAT(Refusal("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=x"), HasSubstr("recv_buf_size is 'x'"));
  EXPECT_THAT(Refusal("tcpq://127.0.0.1:7700?ttl=1"), HasSubstr("tcpq has none"));
  EXPECT_THAT(Refusal("file://"), HasSubstr("names no file"));
  EXPECT_THAT(Refusal("file:///tmp/a.lcm"), HasSubstr("mode=w"));
  EXPECT_THAT(Refusal("file:///tmp/a.lcm?mode=w", LcmDirection::kSubscribe), HasSubstr("mode=r"));
}

TEST(LcmUrl, AcceptsWhatLcmOpens) {
  EXPECT_THAT(Refusal("udpm://239.1.2.3:9999?ttl=1&recv_buf_size=2000000"), "no error");
  EXPECT_THAT(Refusal("tcpq://10.0.0.1:7700"), "no error");
  EXPECT_THAT(Refusal("file:///tmp/a.lcm?mode=a"), "no error");
  EXPECT_THAT(Refusal("file:///tmp/a.lcm?speed=2", LcmDirection::kSubscribe), "no error");
  EXPECT_THAT(Refusal("memq://"), "no error");
}

TEST(LcmUrl, KnowsWhatLeavesTheHost) {
  const auto leaves = [](const std::string& url) { return ParseLcmUrl(url, LcmDirection::kPublish).LeavesTheHost(); };
  EXPECT_FALSE(leaves("udpm://239.255.76.67:7667?ttl=0"));
  EXPECT_FALSE(leaves("udpm://")) << "LCM's default";
  EXPECT_TRUE(leaves("udpm://239.255.76.67:7667?ttl=1"));
  EXPECT_TRUE(leaves("udpm://239.255.76.67:7667?recv_buf_size=9&ttl=255"));
  EXPECT_FALSE(leaves("tcpq://127.0.0.1:7700"));
  EXPECT_TRUE(leaves("tcpq://192.168.1.2:7700"));
  EXPECT_FALSE(leaves("file:///tmp/a?mode=w"));
  EXPECT_FALSE(leaves("memq://"));
}

TEST(LcmUrl, ProbeNamesATcpServerThatIsMissing) {
  // Port 1 of the loopback: privileged and assigned to nothing anyone runs.
  const LcmUrl url = ParseLcmUrl("tcpq://127.0.0.1:1", LcmDirection::kPublish);
  EXPECT_THAT(ProbeLcmUrl(url), AllOf(HasSubstr("tcpq://127.0.0.1:1"), HasSubstr("port 1")));
}

// LCM would wait at a pipe for its other end.
TEST(LcmUrl, ProbeRefusesALogThatIsNoFile) {
  const test::TemporaryDirectory folder;
  const std::string pipe = (folder / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const auto written = [&](const char* mode) {
    return ProbeLcmUrl(ParseLcmUrl("file://" + pipe + mode, LcmDirection::kPublish));
  };
  EXPECT_THAT(written("?mode=w"), HasSubstr("pipe, not a file"));
  EXPECT_THAT(ProbeLcmUrl(ParseLcmUrl("file://" + pipe, LcmDirection::kSubscribe)), HasSubstr("is a pipe, not a file"));
  const UniqueFd reader(::open(pipe.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  EXPECT_THAT(written("?mode=a"), HasSubstr("not a file"));
  EXPECT_THAT(ProbeLcmUrl(ParseLcmUrl("file:///dev/null?mode=w", LcmDirection::kPublish)), IsEmpty());
}

TEST(ChannelPrefix, AllowsWhatNeedsNoQuoting) {
  EXPECT_TRUE(IsValidPrefix("CHEQUER_cam-1"));
  EXPECT_FALSE(IsValidPrefix(""));
  EXPECT_FALSE(IsValidPrefix("a b"));
  EXPECT_FALSE(IsValidPrefix("a.b"));
  EXPECT_TRUE(IsValidPrefix(std::string(kMaxPrefixLength, 'x')));
  EXPECT_FALSE(IsValidPrefix(std::string(kMaxPrefixLength + 1, 'x')));
  EXPECT_EQ(StatusChannel(std::string(kMaxPrefixLength, 'x')).size(), kMaxChannelLength);
}

TEST(ChannelFilter, RefusesPrefixAndChannelTogether) {
  EXPECT_THAT((ChannelFilter{"A", "B"}.Check()), HasSubstr("exclude each other"));
  EXPECT_THAT((ChannelFilter{"A B", ""}.Check()), HasSubstr("'A B'"));
  EXPECT_THAT((ChannelFilter{"", std::string(64, 'x')}.Check()), HasSubstr("63 bytes"));
  EXPECT_THAT((ChannelFilter{}.Check()), IsEmpty());
}

}  // namespace
}  // namespace chequer
