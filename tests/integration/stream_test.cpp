// A stream in which much happens: rendered, played through chequerd and LCM, and judged, as a user would.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "integration/workspace.h"
#include "publish/lcm_publisher.h"
#include "support/process.h"

namespace chequer {
namespace {

using nlohmann::json;
using test::Process;
using test::Received;
using test::Subscriber;

class StreamTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  void Render() {
    Process render(
        {CHEQUER, "render", "--scenario", CHEQUER_TEST_DATA "/data/scenarios/short.toml", "--out", path("stream")});
    ASSERT_EQ(render.Wait(), 0) << render.output();
  }

  /// Two workers: each has a detector that sees every second frame or so.
  void Play() {
    std::ofstream(path("chequerd.toml")) << "[camera]\nname = \"test\"\ncalibration = \"" << path("stream/camera.toml")
                                         << "\"\n[[marker]]\nsize = \"6x6\"\nvariant = \"secded\"\nside = 0.1\n"
                                         << "[capture]\npace = \"unlimited\"\npath = \"" << path("stream")
                                         << "\"\n[pipeline]\nworkers = 2\n";
    Subscriber subscriber;
    Process daemon({CHEQUERD, "--config", path("chequerd.toml")});
    ASSERT_TRUE(subscriber.ReceiveUntil([](const Received& got) { return got.HasEnded(); })) << daemon.output();
    ASSERT_EQ(daemon.Wait(), 0) << daemon.output();
    LcmPublisher log({"file://" + path("poses.lcm") + "?mode=w", "CHEQUER"});
    for (const PosesMessage& message : subscriber.received().poses) log.Publish(message);
    received_ = subscriber.received();
  }

  /// What `evaluate` says of each phase.
  std::map<std::string, json> Judge() {
    Process evaluate({CHEQUER, "evaluate", "--phases", path("poses.lcm"), "--truth", path("stream"), "--json"});
    EXPECT_EQ(evaluate.Wait(), 0) << evaluate.output();
    std::map<std::string, json> phases;
    std::istringstream lines(evaluate.output());
    for (std::string line; std::getline(lines, line);) {
      const json phase = json::parse(line);
      phases[phase["phase"].is_null() ? "all" : phase["phase"].get<std::string>()] = phase;
    }
    return phases;
  }

  test::TemporaryDirectory folder_;
  Received received_;
};

TEST_F(StreamTest, LosesNobodyWhateverHappens) {
  ASSERT_NO_FATAL_FAILURE(Render());
  ASSERT_NO_FATAL_FAILURE(Play());
  const auto phases = Judge();
  ASSERT_EQ(phases.size(), 14u);
  const json& all = phases.at("all");
  EXPECT_EQ(all["missing"], 0) << all;
  EXPECT_EQ(all["wrong"], 0) << all;
  EXPECT_EQ(all["twice"], 0) << all;
  EXPECT_EQ(all["ghosts"], 0) << all;
  // What occludes or blurs boards may cost some of them while it lasts; afterwards all are there again.
  const std::map<std::string, double> harder{{"knock", 0.6}, {"hands", 0.7}, {"fast", 0.95}, {"traffic", 0.9}};
  for (const auto& [name, phase] : phases) {
    if (name == "all") continue;
    const auto least = harder.find(name);
    EXPECT_GE(phase["recall"].get<double>(), least == harder.end() ? 1.0 : least->second) << phase;
  }
  EXPECT_EQ(received_.statuses.back().frames_dropped, 5u) << "those of the gap, and none for the camera's reopening";
}

}  // namespace
}  // namespace chequer
