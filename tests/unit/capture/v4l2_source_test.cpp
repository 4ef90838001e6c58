#include "capture/v4l2_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "support/fake_v4l2.h"

// With a driver that can be told what to do; tests/devices/v4l2_test has the kernel's own.

namespace chequer {
namespace {

using std::chrono::seconds;
using ::testing::HasSubstr;

class V4l2SourceTest : public ::testing::Test {
 protected:
  V4l2SourceTest() {
    options_.camera.device = "Fake";
    options_.camera.fps = 60;
    options_.camera.buffers = 4;
    source_ = std::make_unique<V4l2Source>(options_, driver_.Roots());
  }

  CaptureResult Next() { return source_->Next(seconds(10)); }

  test::FakeV4l2 driver_;
  V4l2Options options_;
  std::unique_ptr<V4l2Source> source_;
};

TEST_F(V4l2SourceTest, FramesLieInTheDriversBuffersWhichGoBack) {
  ASSERT_EQ(source_->Open(), "");
  EXPECT_EQ(driver_.held(), 4u);
  {
    const CaptureResult first = Next(), second = Next();
    ASSERT_EQ(second.status, CaptureStatus::kFrame) << second.message;
    EXPECT_TRUE(driver_.Owns(first.frame.image.row(0)) && driver_.Owns(second.frame.image.row(1079)));
    EXPECT_EQ(second.frame.sequence, first.frame.sequence + 1);
    EXPECT_EQ(driver_.held(), 2u);
  }
  EXPECT_EQ(driver_.held(), 4u);
}

TEST_F(V4l2SourceTest, CopiesWhereTheDriverWouldHaveNoBufferLeft) {
  ASSERT_EQ(source_->Open(), "");
  std::vector<CaptureResult> kept;
  for (int i = 0; i < 10; ++i) {
    kept.push_back(Next());
    ASSERT_EQ(kept.back().status, CaptureStatus::kFrame) << i;
    EXPECT_EQ(driver_.Owns(kept.back().frame.image.row(0)), i < 3) << i;
  }
  EXPECT_EQ(driver_.held(), 1u);
  source_.reset();
  for (const CaptureResult& result : kept) EXPECT_EQ(*result.frame.image.row(1079), 0) << "frames outlive the source";
}

TEST_F(V4l2SourceTest, NeverGivesFramesThatAreDamagedOrCutOff) {
  ASSERT_EQ(source_->Open(), "");
  driver_.Say({.is_damaged = true, .sequence = 7});
  const CaptureResult damaged = Next();
  EXPECT_EQ(damaged.status, CaptureStatus::kCorrupt);
  EXPECT_THAT(damaged.message, HasSubstr("marked frame 7 as damaged"));
  driver_.Say({.bytes_left_out = 1, .sequence = 8});
  const CaptureResult cut_off = Next();
  EXPECT_EQ(cut_off.status, CaptureStatus::kCorrupt);
  EXPECT_THAT(cut_off.message, HasSubstr("only 4147199 bytes"));
  EXPECT_EQ(driver_.held(), 4u) << "their buffers go back at once";
}

TEST_F(V4l2SourceTest, CountsOnWhereTheDriversNumbersTurnOver) {
  ASSERT_EQ(source_->Open(), "");
  driver_.Say({.sequence = 0xffffffff});
  const std::uint64_t last = Next().frame.sequence;
  EXPECT_EQ(Next().frame.sequence, last + 1);
}

TEST_F(V4l2SourceTest, SaysThatTheCameraWasUnplugged) {
  ASSERT_EQ(source_->Open(), "");
  const CaptureResult kept = Next();
  driver_.Unplug();
  const CaptureResult result = Next();
  EXPECT_EQ(result.status, CaptureStatus::kDisconnected);
  EXPECT_THAT(result.message, HasSubstr("(Fake): No such device"));
  EXPECT_THAT(source_->Open(), HasSubstr("No such device"));
}

}  // namespace
}  // namespace chequer
