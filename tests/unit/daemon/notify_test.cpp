#include "daemon/notify.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "support/service_manager.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

// Where one of these waits, the test never ends.
TEST(Notify, DoesNotWaitForAServiceManagerThatDoesNotRead) {
  const test::TemporaryDirectory folder;
  test::ServiceManager manager(folder / "notify");
  setenv("NOTIFY_SOCKET", (folder / "notify").c_str(), 1);
  for (int i = 0; i < 10'000; ++i) NotifyAlive();
  NotifyReady();
  for (int i = 0; i < 10'000; ++i) NotifyStatus("line " + std::to_string(i));
  // It reads again.
  EXPECT_EQ(manager.WaitFor("WATCHDOG"), "WATCHDOG=1");
  while (manager.Reads("WATCHDOG=1")) {
  }
  NotifyAlive();
  EXPECT_EQ(manager.WaitFor("READY"), "READY=1");
  EXPECT_EQ(manager.WaitFor("STATUS"), "STATUS=line 9999");
  EXPECT_EQ(manager.WaitFor("WATCHDOG"), "WATCHDOG=1");
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace chequer
