#include "daemon/scheduling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>

#include <stdexcept>
#include <thread>

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Scheduling, PinsTheThreadThatAsksForIt) {
  const int here = sched_getcpu();
  std::thread([&] {
    EXPECT_THAT(PinThisThread(here), IsEmpty());
    cpu_set_t set;
    CPU_ZERO(&set);
    ASSERT_EQ(sched_getaffinity(0, sizeof set, &set), 0);
    EXPECT_EQ(CPU_COUNT(&set), 1);
    EXPECT_TRUE(CPU_ISSET(static_cast<unsigned>(here), &set));
  }).join();
}

TEST(Scheduling, RefusesProcessorsThatAreNotThereAndNamesThoseThatAre) {
  CheckCpus({});
  CheckCpus({sched_getcpu()});
  for (const int missing : {1023, 4000, -1}) try {
      CheckCpus({missing});
      FAIL() << missing;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), AllOf(HasSubstr(std::to_string(missing)), HasSubstr("it may use ")));
    }
}

TEST(Scheduling, SpreadsThreadsOfAWorkerBehindAllWorkers) {
  const SchedulingOptions options{.cpus = {3, 5, 7, 9}};
  EXPECT_EQ(CpuOf(options, 0), 3);
  EXPECT_EQ(CpuOf(options, 1), 5);
  EXPECT_EQ(CpuOf(options, 0, 1, 2), 7);
  EXPECT_EQ(CpuOf(options, 1, 1, 2), 9);
  EXPECT_EQ(CpuOf(options, 0, 2, 2), 5) << "where its worker is, it would help nobody";
  const SchedulingOptions few{.cpus = {0, 1}}, one{.cpus = {6}};
  EXPECT_EQ(CpuOf(few, 0, 1, 2), 1);
  EXPECT_EQ(CpuOf(few, 1, 1, 2), 0);
  EXPECT_EQ(CpuOf(one, 1, 1, 2), 6);
}

TEST(Scheduling, SaysWhatItTakesToRunInRealTime) {
  std::thread([] {
    const std::string problem = MakeThisThreadRealtime(7);
    sched_param parameter{};
    int policy = 0;
    pthread_getschedparam(pthread_self(), &policy, &parameter);
    if (problem.empty()) {  // as root, mostly
      EXPECT_EQ(policy, SCHED_FIFO);
      EXPECT_EQ(parameter.sched_priority, 7);
    } else {
      EXPECT_NE(policy, SCHED_FIFO);
      EXPECT_THAT(problem, HasSubstr("LimitRTPRIO="));
    }
    EXPECT_THAT(MakeThisThreadRealtime(100), HasSubstr("LimitRTPRIO="));  // there is no such priority
  }).join();
}

}  // namespace
}  // namespace chequer
