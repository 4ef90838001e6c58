#include "view/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "publish/lcm_log_writer.h"
#include "publish/wire.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "unit/publish/messages.h"
#include "unit/view/page.h"

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::At;

constexpr UtcTime kBegin{seconds(1'700'000'000)};
MonotonicTime Now(int ms) { return MonotonicTime(seconds(50) + milliseconds(ms)); }
double Ms(int ms) { return 1'700'000'000'000.0 + ms; }

/// Ten seconds of frames, ten a second: frame i at i tenths.
std::filesystem::path WriteLog(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "run.lcm";
  std::ofstream file(path, std::ios::binary);
  WireEncoder encoder;
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i <= 100; ++i) {
    PosesMessage poses = test::SamplePoses(1);
    poses.sequence = static_cast<std::uint64_t>(i);
    EncodeLogEvent(i, kBegin + milliseconds(100 * i), "a_POSES", encoder.Encode(poses), bytes);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  return path;
}

class ReplayTest : public ::testing::Test {
 protected:
  double Shown() { return At<double>(replay_.feed().PacketOf(0, TopicKind::kFrame), 8); }

  test::TemporaryDirectory folder_;
  std::shared_ptr<const LogIndex> index_ = std::make_shared<LogIndex>(WriteLog(folder_.path()));
  Replay replay_{index_, Now(0)};
};

TEST_F(ReplayTest, KnowsItsTimes) {
  EXPECT_EQ(index_->first(), kBegin);
  EXPECT_EQ(index_->last(), kBegin + seconds(10));
}

TEST_F(ReplayTest, PlaysAtTheLogsPace) {
  replay_.Play(Now(1050));
  EXPECT_EQ(Shown(), 10);
  replay_.Play(Now(2000));
  EXPECT_EQ(Shown(), 20);
}

TEST_F(ReplayTest, GoesToAnyMomentForwardsAndBackwards) {
  replay_.Seek({.at_ms = Ms(7020), .speed = 1, .playing = false}, Now(0));
  EXPECT_EQ(Shown(), 70);
  replay_.Play(Now(5000));
  EXPECT_EQ(Shown(), 70) << "it stands still";
  replay_.Seek({.at_ms = Ms(1500), .speed = 4, .playing = true}, Now(6000));
  EXPECT_EQ(Shown(), 15);
  replay_.Play(Now(6500));
  EXPECT_EQ(Shown(), 35) << "four times as fast";
  replay_.Seek({.at_ms = 0, .speed = 1, .playing = false}, Now(7000));
  EXPECT_EQ(Shown(), 0) << "no earlier than its beginning";
}

TEST_F(ReplayTest, StandsStillAtTheEnd) {
  replay_.Play(Now(60'000));
  EXPECT_EQ(Shown(), 100);
  EXPECT_FALSE(replay_.State().playing);
  EXPECT_EQ(replay_.State().now, index_->last());
}

TEST(LogIndex, SaysWhatIsNoLog) {
  const test::TemporaryDirectory folder;
  std::ofstream(folder.path() / "text") << "no log";
  EXPECT_THAT(test::ErrorOf([&] { LogIndex(folder.path() / "text"); }), ::testing::HasSubstr("no message of LCM"));
  EXPECT_THAT(test::ErrorOf([&] { LogIndex(folder.path() / "none"); }), ::testing::HasSubstr("none"));
}

}  // namespace
}  // namespace chequer
