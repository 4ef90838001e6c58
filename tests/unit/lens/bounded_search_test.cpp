#include "lens/bounded_search.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <stdexcept>

namespace chequer {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(SearchWithin, GivesWhatIsFound) {
  const auto found = SearchWithin(seconds(60), [] { return std::vector<cv::Point2f>(3000, {1.5f, 2.5f}); });
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), 3000u);
  EXPECT_EQ(found->back(), cv::Point2f(1.5f, 2.5f));
}

TEST(SearchWithin, GivesNothingFoundAsSuch) {
  const auto found = SearchWithin(seconds(60), [] { return std::vector<cv::Point2f>(); });
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->empty());
}

TEST(SearchWithin, EndsASearchThatGoesOnForEver) {
  EXPECT_FALSE(SearchWithin(milliseconds(50), []() -> std::vector<cv::Point2f> {
    while (true) pause();
  }));
}

TEST(SearchWithin, SurvivesASearchThatFails) {
  const auto thrown =
      SearchWithin(seconds(60), []() -> std::vector<cv::Point2f> { throw std::runtime_error("out of memory"); });
  ASSERT_TRUE(thrown);
  EXPECT_TRUE(thrown->empty());
  const auto crashed = SearchWithin(seconds(60), []() -> std::vector<cv::Point2f> { _exit(3); });
  ASSERT_TRUE(crashed);
  EXPECT_TRUE(crashed->empty());
}

}  // namespace
}  // namespace chequer
