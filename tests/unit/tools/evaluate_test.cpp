// `chequer evaluate`: what it reads, measures, prints and draws.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "publish/lcm_publisher.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"
#include "tools/commands.h"
#include "tools/evaluation.h"
#include "tools/run_file.h"
#include "tools/track_figure.h"
#include "unit/publish/messages.h"

namespace chequer {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Marker 7 at x along the track and y beside it, metres.
json Line(double x, double y) {
  return {{"file", "a.png"},
          {"markers", json::array({{{"id", 7}, {"position", {x, y, 1.0}}, {"orientation", {1.0, 0.0, 0.0, 0.0}}}})}};
}

class EvaluateTest : public ::testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  /// Off the line by 2 mm to either side, one frame without the marker.
  std::string WriteRun(const std::string& name = "run.jsonl") const {
    std::string text;
    for (const auto& [x, y] : {std::pair{0.0, 0.002}, {0.0, -0.002}, {1.0, 0.002}, {1.0, -0.002}})
      text += Line(x, y).dump() + "\n";
    return Write(name, text + R"({"file":"e.png","markers":[]})" + "\n");
  }
  std::string ErrorOf(const std::string& path, const std::string& channel = {}) const {
    return test::ErrorOf([&] { ReadRun(path, channel); });
  }
  static void Run(std::vector<std::string> arguments) {
    CLI::App app;
    AddEvaluateCommand(app);
    arguments.insert(arguments.begin(), "evaluate");
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
  }

  test::TemporaryDirectory folder_;
};

TEST_F(EvaluateTest, MeasuresATrack) {
  const Evaluation evaluation = Evaluate(ReadRun(WriteRun()), std::nullopt);
  EXPECT_EQ(evaluation.name, "run");
  EXPECT_EQ(evaluation.recognition.id, 7u);
  EXPECT_DOUBLE_EQ(evaluation.recognition.Rate(), 0.8);
  ASSERT_TRUE(evaluation.track.has_value());
  EXPECT_NEAR(evaluation.linear_mm.rmse, 2, 1e-9);
  EXPECT_NEAR(evaluation.linear_mm.mae, 2, 1e-9);
  EXPECT_NEAR(evaluation.linear_mm.printed_rmse, 1, 1e-9) << "sqrt(16)/4";
  EXPECT_NEAR(evaluation.angular_deg.rmse, 0, 1e-9);
  EXPECT_THAT(Describe(evaluation), HasSubstr("recognition rate 80.00 %"));
}

TEST_F(EvaluateTest, ARoomsLogIsNotCalledWrong) {
  // Marker 7 drives a circle, 8 and 9 stand by.
  std::string text;
  for (int i = 0; i < 60; ++i) {
    json line = Line(std::cos(0.1 * i), std::sin(0.1 * i));
    for (const int id : {8, 9}) line["markers"].push_back({{"id", id}});
    text += line.dump() + "\n";
  }
  const Evaluation evaluation = Evaluate(ReadRun(Write("room.jsonl", text)), 7);
  EXPECT_EQ(evaluation.recognition.wrong, 0);
  EXPECT_EQ(evaluation.others, (std::vector<std::uint64_t>{8, 9}));
  EXPECT_FALSE(evaluation.track.has_value());
  EXPECT_THAT(Describe(evaluation), HasSubstr("other markers in view, not counted as wrong: 8, 9"));
  EXPECT_THAT(Describe(evaluation), HasSubstr("this is no straight track: over 2.0"));
  EXPECT_THAT(Describe(evaluation), ::testing::Not(HasSubstr("RMSE")));
  const json parsed = json::parse(JsonLine(evaluation));
  EXPECT_EQ(parsed["others"], json::array({8, 9}));
  EXPECT_THAT(parsed["objection"].get<std::string>(), HasSubstr("straight"));
}

TEST_F(EvaluateTest, PrintsJson) {
  const json line = json::parse(JsonLine(Evaluate(ReadRun(WriteRun()), 7)));
  EXPECT_EQ(line["frames"], 5);
  EXPECT_EQ(line["poses"], 4);
  EXPECT_NEAR(line["linear_mm"]["rmse"].get<double>(), 2, 1e-9);
  EXPECT_EQ(line["linear_mm"]["errors"].size(), 4u);
  EXPECT_NEAR(line["track"]["length_m"].get<double>(), 1, 1e-9);
}

TEST_F(EvaluateTest, WithoutPosesThereIsARateButNoTrack) {
  const Evaluation evaluation = Evaluate(ReadRun(Write("a.jsonl", R"({"markers":[{"id":3}]})"
                                                                  "\n"
                                                                  R"({"markers":[{"id":null}]})")),
                                         std::nullopt);
  EXPECT_FALSE(evaluation.track.has_value());
  EXPECT_EQ(evaluation.recognition.undecided, 1);
  EXPECT_THAT(Describe(evaluation), HasSubstr("--calibration"));
  EXPECT_FALSE(json::parse(JsonLine(evaluation)).contains("track"));
}

TEST_F(EvaluateTest, ARunWithoutAnyIdIsAnError) {
  const auto run = ReadRun(Write("a.jsonl", R"({"markers":[]})"));
  EXPECT_THROW(Evaluate(run, std::nullopt), std::runtime_error);
  EXPECT_EQ(Evaluate(run, 7).recognition.Rate(), 0) << "with an id, it is a rate of zero";
}

TEST_F(EvaluateTest, ReadsLogs) {
  const std::filesystem::path log = folder_ / "poses.lcm";
  {
    LcmPublisher publisher({"file://" + log.string() + "?mode=w", "CHEQUER"});
    for (int i = 0; i < 3; ++i) publisher.Publish(test::SamplePoses(2));
    publisher.Publish(test::SampleStatus());
  }
  const class Run run = ReadRun(log);
  ASSERT_EQ(run.frames.size(), 3u);
  EXPECT_EQ(run.frames[0].size(), 2u);
  EXPECT_THAT(ErrorOf(log.string(), "OTHER_POSES"), HasSubstr("no frames of channel OTHER_POSES"));
}

TEST_F(EvaluateTest, ReadsConvertedLogsAndKeepsCamerasApart) {
  json a = Line(0, 0), b = Line(1, 0);
  a["type"] = b["type"] = "poses";
  a["channel"] = "A_POSES";
  b["channel"] = "B_POSES";
  const std::string path =
      Write("both.jsonl", a.dump() + "\n" + R"({"type":"status","channel":"A_STATUS"})" + "\n" + b.dump() + "\n");
  EXPECT_THAT(ErrorOf(path), HasSubstr("A_POSES, B_POSES"));
  EXPECT_EQ(ReadRun(path, "B_POSES").frames.size(), 1u);
}

TEST_F(EvaluateTest, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(ErrorOf((folder_ / "missing").string()), HasSubstr("missing"));
  EXPECT_THAT(ErrorOf(folder_.path().string()), HasSubstr("no"));
  EXPECT_THAT(ErrorOf(Write("empty", "")), HasSubstr("holds no frames"));
  EXPECT_THAT(ErrorOf(Write("cut", Line(0, 0).dump() + "\n{\"markers\":[{")), HasSubstr("cut:2"));
  EXPECT_THAT(ErrorOf(Write("list", "[1]")), HasSubstr("list:1"));
  EXPECT_THAT(ErrorOf(Write("markers", R"({"markers":[{"id":-1}]})")), HasSubstr("\"id\""));
  EXPECT_THAT(ErrorOf(Write("short", R"({"markers":[{"id":1,"position":[1,2],"orientation":[1,0,0,0]}]})")),
              HasSubstr("3 numbers"));
  EXPECT_THAT(ErrorOf(Write("null", R"({"markers":[{"id":1,"position":[1,2,null],"orientation":[1,0,0,0]}]})")),
              HasSubstr("3 numbers"));
  EXPECT_THAT(ErrorOf(Write("zero", R"({"markers":[{"id":1,"position":[1,2,3],"orientation":[0,0,0,0]}]})")),
              HasSubstr("quaternion"));
}

TEST_F(EvaluateTest, DrawsBothFigures) {
  Run({WriteRun("near.jsonl"), WriteRun("far.jsonl"), "--figures", (folder_ / "figure").string()});
  for (const char* name : {"figure10.svg", "figure11.svg"}) {
    const std::string svg = ReadFile(folder_ / name, 10'000'000);
    EXPECT_THAT(svg, HasSubstr("<svg"));
    EXPECT_THAT(svg, HasSubstr("</svg>"));
    EXPECT_GT(svg.size(), 5000u);
  }
}

TEST_F(EvaluateTest, WithNothingToDrawItSaysSo) {
  const std::string path = Write("a.jsonl", R"({"markers":[{"id":3}]})");
  EXPECT_THROW(Run({path, "--figures", (folder_ / "figure").string()}), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "figure10.svg"));
}

TEST(TrackFigure, SkipsRunsWithoutATrack) {
  Evaluation without, with;
  with.name = "with";
  with.track = TrackFit{};
  with.track->along_m = {-1, 0, 1};
  with.track->distance_m = {0, 0, 0};
  with.track->angle_deg = {0, 0, 0};
  const auto svg = DrawTrackFigure(TrackFigure::kAngular, std::array{without, with});
  EXPECT_THAT(std::string(svg.begin(), svg.end()), HasSubstr("</svg>")) << "errors of nothing but zero can be drawn";
}

}  // namespace
}  // namespace chequer
