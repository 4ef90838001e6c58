// What an image may cost: tests count the detector's work, never its time.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "chequer/detector.h"
#include "detect/common/work_meter.h"
#include "detect/deferred_places.h"
#include "detect/fit_schedule.h"
#include "detect/work_plan.h"
#include "support/adversarial_frames.h"
#include "support/same_bits.h"

namespace chequer {
namespace {

using test::DifferenceOf;
using test::DrawHardFrame;
using test::HardFrame;

constexpr int kWidth = 960, kHeight = 540;

test::Detected Detect(Detector& detector, const HardFrame& frame) {
  test::Detected detected;
  detector.Detect(frame.image.view(), detected.markers);
  detected.stats = detector.stats();
  return detected;
}

Detector WithBudget(DetectorOptions options, std::uint64_t units, int threads = 1) {
  options.budget = units;
  options.threads = threads;
  return Detector(std::move(options));
}

const HardFrame& Calm() {
  static const HardFrame frame = DrawHardFrame(test::kCalm, kWidth, kHeight);
  return frame;
}

std::uint64_t WorkOnCalm() {
  static const std::uint64_t work = [] {
    Detector detector(Calm().options);
    return Detect(detector, Calm()).stats.work;
  }();
  return work;
}

class HardFrames : public testing::TestWithParam<const char*> {};

TEST_P(HardFrames, CostAtMostTenTimesACalmFrameWithTheBudget) {
  const HardFrame frame = DrawHardFrame(GetParam(), kWidth, kHeight);
  Detector detector = WithBudget(frame.options, 9 * WorkOnCalm());
  // What waits since the image before goes first, at no extra cost.
  for (int image = 0; image < 3; ++image)
    EXPECT_LE(Detect(detector, frame).stats.work, 10 * WorkOnCalm()) << "image " << image;
  // Without a budget, there is a bound on all but the fits.
  detector.set_budget(0);
  const test::Detected detected = Detect(detector, frame);
  if (detected.stats.boards == 0) {
    EXPECT_LE(detected.stats.work, 20 * WorkOnCalm());
  }
}

INSTANTIATE_TEST_SUITE_P(Budget, HardFrames,
                         testing::Values("knocked16", "knocked50", "knocked100", "moved50", "bled50", "bled8",
                                         "nameless50", "mirrored50", "thousand", "chess4", "chess10", "inkchess6",
                                         "inkchess10", "borders10", "inks3", "halftone6", "page10", "noise3", "moire9",
                                         "stripes3"),
                         [](const testing::TestParamInfo<const char*>& param) { return std::string(param.param); });

TEST(Budget, LeavesCalmFramesAsTheyAre) {
  Detector unlimited(Calm().options), limited = WithBudget(Calm().options, 9 * WorkOnCalm());
  const test::Detected expected = Detect(unlimited, Calm());
  EXPECT_EQ(expected.markers.size(), Calm().boards);
  for (int image = 0; image < 3; ++image) EXPECT_EQ(DifferenceOf(expected, Detect(limited, Calm())), "");
}

TEST(Budget, IsSpentAlikeByAnyNumberOfThreads) {
  for (const char* name : {"thousand", "knocked16", "nameless50"}) {
    const HardFrame frame = DrawHardFrame(name, kWidth, kHeight);
    Detector one = WithBudget(frame.options, 4 * WorkOnCalm(), 1),
             four = WithBudget(frame.options, 4 * WorkOnCalm(), 4);
    for (int image = 0; image < 3; ++image) {
      const test::Detected by_one = Detect(one, frame);
      EXPECT_EQ(DifferenceOf(by_one, Detect(four, frame)), "") << name << ", image " << image;
    }
  }
}

TEST(Budget, GivesTheSameForTheSameImagesInTheSameOrder) {
  const HardFrame frame = DrawHardFrame("thousand", kWidth, kHeight);
  std::vector<test::Detected> first;
  for (int run = 0; run < 2; ++run) {
    Detector detector = WithBudget(frame.options, 5 * WorkOnCalm());
    for (std::size_t image = 0; image < 4; ++image) {
      const test::Detected detected = Detect(detector, image % 2 ? Calm() : frame);
      if (run == 0)
        first.push_back(detected);
      else
        EXPECT_EQ(DifferenceOf(first[image], detected), "") << "image " << image;
    }
  }
}

TEST(Budget, LeavesNothingBehindOnceItIsUnlimited) {
  const HardFrame frame = DrawHardFrame("thousand", kWidth, kHeight);
  Detector detector = WithBudget(frame.options, 3 * WorkOnCalm()), fresh(frame.options);
  EXPECT_GT(Detect(detector, frame).stats.deferred, 0);
  detector.set_budget(0);
  EXPECT_EQ(DifferenceOf(Detect(fresh, frame), Detect(detector, frame)), "");
}

TEST(Budget, StarvesNobody) {
  const HardFrame frame = DrawHardFrame("nameless50", 1280, 720);
  Detector unlimited(frame.options);
  const test::Detected whole = Detect(unlimited, frame);
  ASSERT_EQ(whole.markers.size(), frame.boards);
  // Of what is left of the work when all boards are found, a fifth.
  Detector detector = WithBudget(frame.options, whole.stats.work * 6 / 10);
  std::set<std::pair<int, int>> seen;
  int images = 0;
  std::size_t fewest = frame.boards;
  for (; images < 20 && seen.size() < frame.boards; ++images) {
    const test::Detected detected = Detect(detector, frame);
    EXPECT_GT(detected.stats.deferred, 0);
    fewest = std::min(fewest, detected.markers.size());
    for (const MarkerPose& marker : detected.markers)
      seen.insert({static_cast<int>(std::lround(marker.center_px.x() / 10)),
                   static_cast<int>(std::lround(marker.center_px.y() / 10))});
  }
  ASSERT_GT(fewest, 0u);
  EXPECT_LT(fewest, frame.boards / 2);
  EXPECT_GE(seen.size(), frame.boards);
  EXPECT_LE(static_cast<std::size_t>(images), (frame.boards + fewest - 1) / fewest);
}

TEST(Budget, RefinesEveryBoardInItsTurn) {
  const HardFrame frame = DrawHardFrame("soft50", 1280, 720);
  Detector unlimited(frame.options);
  const test::Detected whole = Detect(unlimited, frame);
  ASSERT_EQ(whole.markers.size(), frame.boards);
  Detector plain = WithBudget(frame.options, whole.stats.work / 2);
  // A pose by the plain fit alone says so by its covariance; a better one is as without a budget, or nearly.
  const auto is_refined = [&](const MarkerPose& marker) {
    return std::any_of(whole.markers.begin(), whole.markers.end(), [&](const MarkerPose& other) {
      return (other.center_px - marker.center_px).norm() < 5 && marker.covariance(0, 0) < 2 * other.covariance(0, 0);
    });
  };
  std::set<std::pair<int, int>> refined;
  std::size_t fewest = frame.boards;
  int images = 0;
  for (; images < 40 && refined.size() < frame.boards; ++images) {
    const test::Detected detected = Detect(plain, frame);
    EXPECT_EQ(detected.markers.size(), frame.boards) << "all are read plainly";
    std::size_t now = 0;
    for (const MarkerPose& marker : detected.markers) {
      if (!is_refined(marker)) continue;
      ++now;
      refined.insert({static_cast<int>(std::lround(marker.center_px.x() / 10)),
                      static_cast<int>(std::lround(marker.center_px.y() / 10))});
    }
    EXPECT_EQ(static_cast<std::size_t>(detected.stats.deferred), frame.boards - now);
    fewest = std::min(fewest, now);
  }
  ASSERT_GT(fewest, 0u);
  EXPECT_LT(fewest, frame.boards / 2);
  EXPECT_GE(refined.size(), frame.boards);
  EXPECT_LE(static_cast<std::size_t>(images), (frame.boards + fewest - 1) / fewest);
}

// What one board shows of the image helps the others as it does without a budget.
TEST(Budget, SharesAStrongDotGain) {
  const HardFrame frame = DrawHardFrame("bled8", kWidth, kHeight);
  Detector unlimited(frame.options);
  const test::Detected whole = Detect(unlimited, frame);
  ASSERT_EQ(whole.markers.size(), frame.boards);
  Detector detector = WithBudget(frame.options, 8 * whole.stats.work);
  for (int image = 0; image < 3; ++image) {
    const test::Detected detected = Detect(detector, frame);
    EXPECT_EQ(detected.markers.size(), frame.boards);
    EXPECT_LE(detected.stats.work, 2 * whole.stats.work) << "image " << image;
  }
}

/// A frame over and over, as a stream with a memory.
class Streams : public testing::TestWithParam<const char*> {};

TEST_P(Streams, ReadOnWhatTheirFirstFrameShows) {
  const HardFrame frame = DrawHardFrame(GetParam(), 1920, 1080);
  Detector unlimited(frame.options);
  const std::uint64_t whole = Detect(unlimited, frame).stats.work;
  for (const std::uint64_t budget : {std::uint64_t{0}, whole, 2 * whole, 5 * whole / 2}) {
    Detector detector = WithBudget(frame.options, budget);
    DetectorMemory memory;
    test::Detected detected;
    std::size_t first = 0;
    for (int image = 1; image <= 5; ++image) {
      detector.Detect(frame.image.view(), image * std::chrono::milliseconds(16), memory, detected.markers);
      const std::size_t read = static_cast<std::size_t>(std::count_if(detected.markers.begin(), detected.markers.end(),
                                                                      [](const auto& m) { return m.id.has_value(); }));
      if (image == 1) first = read;
      EXPECT_GE(read, first) << "image " << image << ", budget " << budget;
      // Boards that were expected in vain are sought once more.
      EXPECT_LE(detector.stats().work, 2 * whole + whole / 4) << "image " << image << ", budget " << budget;
    }
    EXPECT_GE(first, frame.boards * 2 / 5) << "budget " << budget;
  }
}
INSTANTIATE_TEST_SUITE_P(Budget, Streams, testing::Values("calm", "knocked16", "bled50", "bled8", "bled12"),
                         [](const testing::TestParamInfo<const char*>& param) { return std::string(param.param); });

// Plain fits of boards with much dot gain that do not know it cost several times as much.
TEST(Budget, StreamsKeepADotGainThatSparesWork) {
  const HardFrame frame = DrawHardFrame("bled8", 1920, 1080);
  const auto play = [&](std::uint64_t budget) {
    Detector detector = WithBudget(frame.options, budget);
    DetectorMemory memory;
    std::vector<MarkerPose> markers;
    std::vector<std::uint64_t> works;
    for (int image = 1; image <= 4; ++image) {
      detector.Detect(frame.image.view(), image * std::chrono::milliseconds(16), memory, markers);
      EXPECT_EQ(markers.size(), frame.boards) << "image " << image << ", budget " << budget;
      works.push_back(detector.stats().work);
    }
    return works;
  };
  const std::vector<std::uint64_t> unlimited = play(0), limited = play(4 * unlimited[0]);
  for (std::size_t image = 1; image < limited.size(); ++image)
    EXPECT_LE(limited[image], unlimited[image] + unlimited[image] / 8) << "image " << image + 1;
}

TEST(Budget, FitsABoardHoweverSmallItIs) {
  Detector detector = WithBudget(Calm().options, kLeastBudget);
  EXPECT_GE(Detect(detector, Calm()).markers.size(), 1u);
}

TEST(Budget, MustBeNoneOrEnoughForAnImage) {
  DetectorOptions options;
  options.budget = kLeastBudget - 1;
  EXPECT_NE(options.Check().find("budget 999"), std::string::npos) << options.Check();
  for (const std::uint64_t units : {std::uint64_t{0}, kLeastBudget}) {
    options.budget = units;
    EXPECT_EQ(options.Check(), "");
  }
}

TEST(DeferredPlaces, RememberHowLongTheyHaveWaited) {
  DeferredPlaces places;
  EXPECT_EQ(places.Waited({10, 10}), 0);
  for (int image = 1; image <= 3; ++image) {
    places.Defer({10, 10}, 5, places.Waited({10, 10}));
    EXPECT_EQ(places.Waited({10, 10}), image - 1) << "in the image itself";
    places.EndImage();
    EXPECT_EQ(places.Waited({12, 13}), image);
    EXPECT_EQ(places.Waited({14, 14}), 0) << "beyond reach";
  }
  places.EndImage();
  EXPECT_EQ(places.Waited({10, 10}), 0) << "nothing was left undone in the last image";
}

TEST(DeferredPlaces, KeepThoseThatHaveWaitedLongestOfTooMany) {
  DeferredPlaces places;
  for (int i = 0; i < 3000; ++i) places.Defer({static_cast<float>(10 * i), 0}, 1, i == 2500 ? 4 : 0);
  places.EndImage();
  EXPECT_EQ(places.size(), DeferredPlaces::kMost);
  EXPECT_EQ(places.Waited({25000, 0}), 5);
  EXPECT_EQ(places.Waited({0, 0}), 1);
  EXPECT_EQ(places.Waited({29990, 0}), 0);
}

TEST(WorkPlan, WithoutABudgetAllowsEverything) {
  const WorkPlan plan(0);
  EXPECT_FALSE(plan.limited());
  EXPECT_GT(plan.MostPeaks(1e6), 1'000'000u);
  EXPECT_TRUE(plan.MayLookAgain(1'000'000'000, 1'000'000'000, false));
  EXPECT_GT(plan.Left(1'000'000'000), 1'000'000'000u);
  EXPECT_GT(plan.MostForBoards(1000), 1'000'000'000u);
}

TEST(WorkPlan, LeavesSomethingForEveryStep) {
  const WorkPlan plan(100'000);
  EXPECT_GT(plan.MostPeaks(1e6), 1000u);
  EXPECT_EQ(plan.MostForBoards(0), 60'000u);
  EXPECT_EQ(plan.MostForBoards(50'000), 50'000u) << "a second look that waits";
  EXPECT_EQ(plan.MostForBoards(90'000), 40'000u) << "one that takes too much";
  EXPECT_TRUE(plan.MayLookAgain(60'000, 15'000, false));
  EXPECT_FALSE(plan.MayLookAgain(60'000, 15'001, false));
  EXPECT_TRUE(plan.MayLookAgain(60'000, 40'000, true));
  EXPECT_FALSE(plan.MayLookAgain(60'000, 40'001, true));
  EXPECT_TRUE(plan.MayLookAgain(99'000, 0, false)) << "that finds nothing to look at";
  EXPECT_EQ(plan.Left(75'000), 25'000u);
  EXPECT_EQ(plan.Left(100'001), 0u);
}

TEST(WorkPlan, LeavesTheSearchItsShareOfWhatExpectedBoardsLeave) {
  WorkPlan plan(100'000);
  plan.StartSearch(70'000);
  EXPECT_EQ(plan.MostForBoards(0), 88'000u);
  EXPECT_EQ(plan.MostForBoards(15'000), 85'000u) << "a second look that waits";
  EXPECT_EQ(plan.MostForBoards(90'000), 82'000u) << "one that takes too much";
  plan.StartSearch(100'001);
  EXPECT_EQ(plan.MostForBoards(0), 100'000u);
}

TEST(WorkPlan, TakesNoPeaksFromFramesOfBoardsHoweverSmallItIs) {
  // A swarm of 50 in 1920 × 1080 has 2,800.
  EXPECT_GE(WorkPlan(kLeastBudget).MostPeaks(1920 * 1080), 8000u);
}

std::vector<FitTask> Tasks(std::initializer_list<std::uint64_t> most) {
  std::vector<FitTask> tasks;
  for (const std::uint64_t units : most)
    tasks.push_back({.board = tasks.size(), .most = units, .expected = units, .least = units / 4});
  return tasks;
}

TEST(FitSchedule, GrantsWhatTheBudgetLastsForInTheWorstCase) {
  const WorkPlan plan(100'000);
  std::vector<FitTask> tasks = Tasks({20'000, 20'000, 20'000, 20'000});
  EXPECT_EQ(GrantRound(plan, 50'000, false, tasks), 2u);
  EXPECT_EQ(tasks[1].granted, 20'000u);
  EXPECT_EQ(GrantRound(plan, 96'000, false, tasks), 0u);
  EXPECT_EQ(GrantRound(plan, 96'000, true, tasks), 1u);
  EXPECT_EQ(tasks[0].granted, 5'000u);
  EXPECT_EQ(GrantRound(plan, 90'000, true, tasks), 1u);
  EXPECT_EQ(tasks[0].granted, 10'000u);
}

TEST(FitSchedule, LetsNoTaskTakeAllOfTheBudget) {
  std::vector<FitTask> tasks = Tasks({90'000, 90'000});
  EXPECT_EQ(GrantRound(WorkPlan(100'000), 0, false, tasks), 1u);
  EXPECT_EQ(tasks[0].granted, 25'000u);
}

TEST(FitSchedule, LetsATaskGoALittleBeyondTheBudgetAtMost) {
  // That is expected to take as little as others did.
  std::vector<FitTask> tasks = Tasks({20'000});
  tasks[0].expected = 8'000;
  EXPECT_EQ(GrantRound(WorkPlan(100'000), 90'000, false, tasks), 1u);
  EXPECT_EQ(tasks[0].granted, 15'000u);
}

TEST(FitSchedule, DoesAllAtOnceWithoutABudget) {
  std::vector<FitTask> tasks = Tasks({1, 1'000'000'000});
  EXPECT_EQ(GrantRound(WorkPlan(0), 1'000'000'000, false, tasks), 2u);
  EXPECT_EQ(tasks[1].granted, ~0ull);
}

TEST(FitSchedule, GoesOnWithWhatTheRoundsBeforeDidNotTake) {
  std::vector<FitTask> tasks = Tasks(std::initializer_list<std::uint64_t>{
      20'000, 20'000, 20'000, 20'000, 20'000, 20'000, 20'000, 20'000, 20'000, 20'000, 20'000});
  std::uint64_t spent = 0;
  std::vector<std::size_t> rounds;
  const std::size_t done = RunInRounds(
      WorkPlan(100'000), true, false, tasks, [&] { return spent; },
      [&](std::span<const FitTask> round) {
        rounds.push_back(round.size());
        spent += round.size() * 10'000;
      });
  EXPECT_EQ(done, 9u);
  EXPECT_EQ(rounds.front(), kFewAtOnce);
  EXPECT_LE(rounds.size(), 5u);
}

TEST(FitSchedule, LearnsFromTheFirstWhatTheOthersTake) {
  for (const std::uint64_t each : {16'000u, 250u}) {
    std::vector<FitTask> tasks;
    for (std::size_t board = 0; board < 200; ++board)
      tasks.push_back({.board = board, .most = 1'000, .expected = 1'000, .least = 1'000});
    std::uint64_t spent = 0;
    const std::size_t done = RunInRounds(
        WorkPlan(100'000), false, false, tasks, [&] { return spent; },
        [&](std::span<const FitTask> round) { spent += round.size() * each; });
    EXPECT_LE(spent, 100'000u);
    EXPECT_GT(spent, done == tasks.size() ? 0u : 70'000u);
    EXPECT_EQ(done, each > 1'000 ? 6u : 200u);
  }
}

TEST(FitSchedule, BeginsAnewWithTasksThatAreClearAsTheyTakeMore) {
  std::vector<FitTask> tasks;
  for (std::size_t board = 0; board < 62; ++board)
    tasks.push_back({.board = board, .unclear = board < 31, .most = 20'000, .expected = 10'000, .least = 1'000});
  std::uint64_t spent = 0;
  const std::size_t done = RunInRounds(
      WorkPlan(100'000), false, false, tasks, [&] { return spent; },
      [&](std::span<const FitTask> round) { spent += round.size() * (round[0].unclear ? 100 : 10'000); });
  EXPECT_GT(done, 36u);
  EXPECT_LE(spent, 110'000u);
}

TEST(FitSchedule, BeginsWithThoseThatSayNothingUnlessOthersHaveWaitedLonger) {
  std::vector<FitTask> tasks = Tasks({30, 20, 10, 40, 5});
  tasks[3].waited = kUnclearFirst + 1;
  tasks[4].waited = kUnclearFirst;
  tasks[0].unclear = true;
  SortByWorth(tasks);
  std::vector<std::size_t> order;
  for (const FitTask& task : tasks) order.push_back(task.board);
  EXPECT_EQ(order, (std::vector<std::size_t>{3, 0, 4, 2, 1}));
}

TEST(WorkMeter, AddsUpUnits) {
  WorkMeter one, other;
  one.Add(WorkStep::kPixel, 1000);
  other.Add(WorkStep::kPixel, 3000);
  one.Add(other);
  EXPECT_EQ(one.times(WorkStep::kPixel), 4000u);
  EXPECT_EQ(one.units(), 4u * WorkMeter::Instructions(WorkStep::kPixel));
}

TEST(WorkMeter, KnowsWhatEveryStepCosts) {
  for (std::size_t step = 0; step < WorkMeter::kSteps; ++step) EXPECT_GT(WorkMeter::kInstructions[step], 0u) << step;
}

}  // namespace
}  // namespace chequer
