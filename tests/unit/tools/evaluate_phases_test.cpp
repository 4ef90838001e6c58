// `chequer render --scenario` and `chequer evaluate --phases`: what is written, read, counted and drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "capture/recording.h"
#include "chequer/camera_file.h"
#include "core/file.h"
#include "publish/lcm_publisher.h"
#include "support/error_of.h"
#include "support/stream_frames.h"
#include "support/temporary_directory.h"
#include "tools/commands.h"
#include "tools/phase_report.h"
#include "tools/phase_results.h"

namespace chequer {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// A stream of 2 calm frames, a gap and 3 dark frames, with 3 robots.
constexpr const char* kStream = R"([camera]
size = "320x240"
focal_px = 400
distance = 1.5
fps = 50
[swarm]
robots = 3
side = 0.15
[[phase]]
kind = "calm"
frames = 2
[[phase]]
kind = "gap"
frames = 4
[[phase]]
kind = "dark"
frames = 3
)";

void RunTool(void (*add)(CLI::App&), const std::string& name, std::vector<std::string> arguments) {
  CLI::App app;
  add(app);
  arguments.insert(arguments.begin(), name);
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
}

class EvaluatePhasesTest : public ::testing::Test {
 protected:
  EvaluatePhasesTest() {
    std::ofstream(folder_ / "stream.toml") << kStream;
    RunTool(AddRenderCommand, "render", {"--scenario", (folder_ / "stream.toml").string(), "--out", stream().string()});
    truth_ = ReadTruth(stream() / "truth.jsonl");
  }

  std::filesystem::path stream() const { return folder_ / "stream"; }

  /// The truth of a frame as detections.
  json TrueLine(std::size_t index) const {
    json line{{"file", "any/" + truth_[index].file},
              {"detect_ms", 1.0 + static_cast<double>(index)},
              {"markers", json::array()}};
    for (const TrueMarker& marker : truth_[index].markers) {
      const Eigen::Vector3d& t = marker.camera_from_marker.translation;
      const Eigen::Quaterniond& q = marker.camera_from_marker.rotation;
      line["markers"].push_back({{"id", marker.id},
                                 {"variant", "secded"},
                                 {"position", {t.x(), t.y(), t.z()}},
                                 {"orientation", {q.w(), q.x(), q.y(), q.z()}}});
    }
    return line;
  }
  PosesMessage TrueMessage(std::size_t index, std::uint64_t sequence) const {
    PosesMessage message;
    message.sequence = sequence;
    message.captured_monotonic = MonotonicTime(std::chrono::seconds(5));
    message.published_monotonic = message.captured_monotonic + std::chrono::milliseconds(4);
    for (const TrueMarker& marker : truth_[index].markers) {
      MarkerPose pose;
      pose.id = marker.id;
      pose.has_pose = true;
      pose.camera_from_marker = marker.camera_from_marker;
      message.markers.push_back(pose);
    }
    return message;
  }
  std::string Write(const std::vector<json>& lines) const {
    std::ofstream file(folder_ / "found.jsonl");
    for (const json& line : lines) file << line.dump() << "\n";
    return (folder_ / "found.jsonl").string();
  }
  std::vector<PhaseScore> Phases(const std::string& results) const {
    return ScorePhases(ReadPhaseRun(results, stream(), "").frames);
  }
  std::string ErrorOf(const std::string& results) const {
    return test::ErrorOf([&] { ReadPhaseRun(results, stream(), ""); });
  }

  test::TemporaryDirectory folder_;
  std::vector<FrameTruth> truth_;
};

TEST_F(EvaluatePhasesTest, TheStreamIsARecordingWithPhases) {
  const Recording recording = OpenRecording(stream());
  ASSERT_EQ(recording.frames.size(), 5u);
  EXPECT_EQ(recording.frames[1].sequence, 1u);
  EXPECT_EQ(recording.frames[2].sequence, 6u) << "four frames were lost";
  EXPECT_EQ(recording.frames[2].captured_utc - recording.frames[1].captured_utc, std::chrono::milliseconds(100));
  EXPECT_EQ(LoadFrame(recording, 4).width(), 320);
  EXPECT_EQ(LoadCamera(stream() / recording.info.calibration).fx, 400);
  ASSERT_EQ(truth_.size(), 5u);
  EXPECT_EQ(truth_[1].phase, "calm");
  EXPECT_EQ(truth_[2].phase, "dark");
  EXPECT_NEAR(*truth_[2].time_s, 0.12, 1e-12);
  EXPECT_EQ(truth_[2].markers.size(), 3u);
}

TEST_F(EvaluatePhasesTest, TheStreamInMemoryIsTheSame) {
  const Recording recording = OpenRecording(stream());
  const test::StreamFrames frames(kStream);
  ASSERT_EQ(frames.size(), recording.frames.size());
  for (std::size_t i = frames.size(); i-- > 0;) {
    const test::StreamFrame frame = frames.Frame(i);
    EXPECT_TRUE(std::ranges::equal(frame.image.bytes(), LoadFrame(recording, i).bytes())) << i;
    EXPECT_EQ(frames.phase(i), truth_[i].phase);
    EXPECT_EQ(frame.truth.markers.size(), truth_[i].markers.size());
  }
  const test::StreamFrame frame = frames.Frame(0);
  const test::StreamScore score = test::ScoreFrame(Detector(frames.Options()).Detect(frame.image.view()), frame.truth);
  EXPECT_EQ(score.expected, 3);
  EXPECT_EQ(score.read, 3);
  EXPECT_EQ(score.wrong, 0);
}

TEST_F(EvaluatePhasesTest, CountsAHandMadeExample) {
  json all = TrueLine(0), one_less = TrueLine(2), wrong = TrueLine(3);
  one_less["markers"].erase(1);
  wrong["markers"][0]["id"] = 1000;
  wrong["markers"].push_back(wrong["markers"][1]);
  wrong["markers"].push_back({{"id", 9}, {"corners", {{1, 1}, nullptr, {3, 1}}}});
  const auto phases = Phases(Write({all, one_less, wrong}));
  ASSERT_EQ(phases.size(), 2u);
  EXPECT_EQ(phases[0].name, "calm");
  EXPECT_EQ(phases[0].frames, 2);
  EXPECT_EQ(phases[0].missing, 1);
  EXPECT_EQ(phases[0].total.Recall(), 1);
  EXPECT_EQ(phases[1].frames, 3);
  EXPECT_EQ(phases[1].missing, 1);
  EXPECT_EQ(phases[1].total.expected, 6);
  EXPECT_EQ(phases[1].total.read, 4);
  EXPECT_EQ(phases[1].total.wrong, 1);
  EXPECT_EQ(phases[1].total.twice, 1);
  EXPECT_EQ(phases[1].total.ghosts, 1) << "at (2, 1)";
  EXPECT_EQ(phases[1].detect_ms.largest, 4);
  EXPECT_LT(phases[1].position_mm.largest, 1e-6);
}

TEST_F(EvaluatePhasesTest, ReadsLogsOfStreamsThatArePlayedOverAndOver) {
  const std::string log = (folder_ / "poses.lcm").string();
  {
    LcmPublisher publisher({"file://" + log + "?mode=w", "CHEQUER"});
    // Sequence numbers of a round: 0, 1, 6, 7, 8. The second round's go on with 9.
    for (const auto& [index, sequence] :
         {std::pair<std::size_t, std::uint64_t>{0, 0}, {2, 6}, {3, 7}, {4, 8}, {0, 9}, {2, 15}})
      publisher.Publish(TrueMessage(index, sequence));
  }
  const PhaseRun run = ReadPhaseRun(log, stream(), "");
  EXPECT_EQ(run.frames.size(), 8u) << "as far as the log goes";
  for (std::size_t i = 1; i < run.frames.size(); ++i) EXPECT_GT(run.frames[i].time_s, run.frames[i - 1].time_s);
  const auto phases = ScorePhases(run.frames);
  EXPECT_EQ(phases[0].frames, 4);
  EXPECT_EQ(phases[0].missing, 2);
  EXPECT_EQ(phases[1].frames, 4);
  EXPECT_EQ(phases[1].missing, 0);
  EXPECT_EQ(phases[1].total.Recall(), 1);
  EXPECT_NEAR(phases[1].latency_ms.median, 4, 1e-9);
}

TEST_F(EvaluatePhasesTest, SaysWhatIsWrongAndWhere) {
  json strange = TrueLine(0);
  strange["file"] = "strange.png";
  EXPECT_THAT(ErrorOf(Write({TrueLine(1), strange})), HasSubstr("found.jsonl:2: strange.png"));
  EXPECT_THAT(ErrorOf(Write({TrueLine(1), TrueLine(1)})), HasSubstr("is there twice"));
  EXPECT_THAT(ErrorOf(Write({})), HasSubstr("holds no frames"));
  EXPECT_THAT(ErrorOf("nowhere.jsonl"), HasSubstr("nowhere.jsonl"));
  json world = TrueLine(0);
  world["frame"] = "world";
  EXPECT_THAT(ErrorOf(Write({world})), HasSubstr("in the frame 'world'"));
  const std::string line = Write({TrueLine(0)});
  EXPECT_THAT(
      test::ErrorOf([&] { ReadPhaseRun(line, std::filesystem::path(CHEQUER_TEST_DATA) / "data/demo_swarm", ""); }),
      HasSubstr("names no phases"));
}

TEST_F(EvaluatePhasesTest, PrintsAndDraws) {
  const std::string found = Write({TrueLine(0), TrueLine(1), TrueLine(2), TrueLine(3)});
  const PhaseRun run = ReadPhaseRun(found, stream(), "");
  const std::string table = DescribePhases(run);
  EXPECT_THAT(table, HasSubstr("\ncalm "));
  EXPECT_THAT(table, HasSubstr("\nall "));
  std::istringstream lines(PhasesJson(run));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(json::parse(line)["phase"], "calm");
  EXPECT_EQ(json::parse(line)["recall"], 1.0);
  EXPECT_TRUE(json::parse(line)["latency_ms"].is_null());
  std::getline(lines, line);
  EXPECT_EQ(json::parse(line)["missing"], 1);
  std::getline(lines, line);
  EXPECT_TRUE(json::parse(line)["phase"].is_null());
  RunTool(AddEvaluateCommand, "evaluate",
          {"--phases", found, "--truth", stream().string(), "--figures", (folder_ / "run-").string()});
  EXPECT_EQ(ReadFile(folder_ / "run-phases.png", 10'000'000).substr(1, 3), "PNG");
}

TEST_F(EvaluatePhasesTest, RefusesOptionsThatDoNotGoTogether) {
  const std::string found = Write({TrueLine(0)});
  EXPECT_THROW(RunTool(AddEvaluateCommand, "evaluate", {"--phases", found}), CLI::ValidationError);
  EXPECT_THROW(RunTool(AddEvaluateCommand, "evaluate", {found, "--truth", stream().string()}), CLI::RequiresError);
  EXPECT_THROW(RunTool(AddEvaluateCommand, "evaluate", {"--phases", found, "--truth", stream().string(), "--id", "3"}),
               CLI::ValidationError);
  const std::string scenario = (folder_ / "stream.toml").string(), out = (folder_ / "other").string();
  EXPECT_THROW(RunTool(AddRenderCommand, "render", {"--scenario", scenario, "--out", out, "--fps", "3"}),
               CLI::ValidationError);
  EXPECT_NO_THROW(RunTool(AddRenderCommand, "render", {"--scenario", scenario, "--out", out, "--seed", "3"}));
  EXPECT_NE(ReadFile(folder_ / "other/truth.jsonl", 1'000'000), ReadFile(stream() / "truth.jsonl", 1'000'000));
}

}  // namespace
}  // namespace chequer
