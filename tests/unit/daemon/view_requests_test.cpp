#include "daemon/view_requests.h"

#include <gtest/gtest.h>

namespace chequer {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using Kind = ViewRequests::Kind;

MonotonicTime At(int ms) { return MonotonicTime(std::chrono::seconds(1000) + milliseconds(ms)); }

AskMessage Preview(std::int64_t asker) {
  return {.asker = asker, .wants_camera = false, .preview = AskMessage::Preview{}, .detail = {}};
}

TEST(ViewRequests, RunOutAfterTwoSeconds) {
  ViewRequests requests;
  EXPECT_FALSE(requests.NextFrame());
  requests.Take(Preview(1), At(0));
  EXPECT_TRUE(requests.IsDue(Kind::kPreview, At(0)));
  requests.Expire(At(1999));
  EXPECT_TRUE(requests.Any());
  requests.Expire(At(2000));
  EXPECT_FALSE(requests.Any());
  EXPECT_FALSE(requests.IsDue(Kind::kPreview, At(2000)));
}

TEST(ViewRequests, GiveAtMostTenPreviewsASecond) {
  ViewRequests requests;
  int given = 0;
  for (int ms = 0; ms < 10'000; ms += 7) {
    requests.Take(Preview(1), At(ms));
    if (!requests.IsDue(Kind::kPreview, At(ms))) continue;
    requests.Done(Kind::kPreview, At(ms), microseconds(500));
    ++given;
  }
  EXPECT_LE(given, 101);
  EXPECT_GE(given, 95) << "frames do not come just when one is due";
}

TEST(ViewRequests, TakeAFiftiethOfACore) {
  ViewRequests requests;
  milliseconds taken{0};
  for (int ms = 0; ms < 60'000; ms += 10) {
    requests.Take(Preview(1), At(ms));
    if (!requests.IsDue(Kind::kPreview, At(ms))) continue;
    requests.Done(Kind::kPreview, At(ms), milliseconds(20));
    taken += milliseconds(20);
  }
  EXPECT_LE(taken, milliseconds(60'000 / 50 + 20));
  EXPECT_GE(taken, milliseconds(60'000 / 50 - 60));
}

TEST(ViewRequests, AskersTakeTurnsAndAFifthHasToWait) {
  ViewRequests requests;
  for (std::int64_t asker = 1; asker <= 5; ++asker) requests.Take(Preview(asker), At(0));
  std::vector<std::int64_t> served;
  for (int i = 0; i < 8; ++i) {
    const AskMessage* next = requests.Next(Kind::kPreview);
    ASSERT_NE(next, nullptr);
    served.push_back(next->asker);
    requests.Done(Kind::kPreview, At(100 * i), microseconds(1));
  }
  for (std::int64_t asker = 1; asker <= 4; ++asker) EXPECT_EQ(std::count(served.begin(), served.end(), asker), 2);
  EXPECT_EQ(std::count(served.begin(), served.end(), 5), 0);
  requests.Take(Preview(5), At(2500));
  ASSERT_NE(requests.Next(Kind::kPreview), nullptr) << "the others' requests have run out";
  EXPECT_EQ(requests.Next(Kind::kPreview)->asker, 5);
}

TEST(ViewRequests, ALaterRequestTakesThePlaceOfTheOneBefore) {
  ViewRequests requests;
  requests.Take(Preview(1), At(0));
  requests.Take({.asker = 1, .wants_camera = true, .preview = {}, .detail = {}}, At(10));
  EXPECT_EQ(requests.Next(Kind::kPreview), nullptr);
  EXPECT_TRUE(requests.IsDue(Kind::kCamera, At(10)));
  EXPECT_FALSE(requests.NextFrame()) << "the camera is told without one";
}

}  // namespace
}  // namespace chequer
