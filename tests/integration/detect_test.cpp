#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "simulate/truth.h"
#include "support/process.h"
#include "support/temporary_directory.h"

// `chequer detect` as a whole program: what it prints, and what it says of bad input.

namespace chequer {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::TemporaryDirectory;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;
using ::testing::UnorderedElementsAre;

const fs::path kDemo = fs::path(CHEQUER_TEST_DATA) / "data/demo_swarm";
const fs::path kScenes = fs::path(CHEQUER_TEST_DATA) / "golden/scenes";

struct Detection {
  std::optional<int> status;
  std::string output;  ///< standard output and error together
  std::vector<json> images;
};

Detection Detect(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {CHEQUER, "detect"});
  test::Process process(arguments);
  Detection result;
  result.status = process.Wait(std::chrono::seconds(60));
  result.output = process.output();
  std::istringstream lines(result.output);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("{")) result.images.push_back(json::parse(line));
  return result;
}

std::string Frame(const std::string& name) { return (kDemo / name).string(); }

/// The first part of a file.
void CopyCut(const fs::path& from, const fs::path& to, double part) {
  fs::copy_file(from, to);
  fs::resize_file(to, static_cast<std::uintmax_t>(part * static_cast<double>(fs::file_size(from))));
}

TEST(Detect, FindsTheMarkersWithTheirPosesWithinOnePercent) {
  const Detection result = Detect({"--calibration", Frame("camera.toml"), "--marker", "6x6", "--variant", "secded",
                                   "--side", "0.12", "--json", "--repeat", "2", "--threads", "2", Frame("000000.jpg")});
  ASSERT_EQ(result.status, 0) << result.output;
  ASSERT_EQ(result.images.size(), 1u);
  EXPECT_EQ(result.images[0]["file"], Frame("000000.jpg"));
  EXPECT_EQ(result.images[0]["width"], 640);
  EXPECT_EQ(result.images[0]["height"], 480);
  EXPECT_GT(result.images[0]["detect_ms"], 0);
  EXPECT_GT(result.images[0]["work"], 1000);
  const FrameTruth truth = ReadTruth(kDemo / "truth.jsonl").at(0);
  ASSERT_EQ(result.images[0]["markers"].size(), truth.markers.size());
  for (const json& marker : result.images[0]["markers"]) {
    const auto same = std::find_if(truth.markers.begin(), truth.markers.end(),
                                   [&](const TrueMarker& known) { return marker["id"] == known.id; });
    ASSERT_NE(same, truth.markers.end()) << marker["id"];
    const auto position = marker["position"].get<std::vector<double>>();
    const Eigen::Vector3d found(position[0], position[1], position[2]);
    const Eigen::Vector3d known = same->camera_from_marker.translation;
    EXPECT_LT((found - known).norm(), 0.01 * known.norm()) << marker["id"];
    EXPECT_EQ(marker["corners"].size(), 25u);
    EXPECT_EQ(marker["covariance"].size(), 21u);
  }
}

TEST(Detect, LeavesPosesOutWithoutCalibration) {
  const Detection result = Detect({"--json", Frame("000000.jpg")});
  ASSERT_EQ(result.status, 0) << result.output;
  ASSERT_EQ(result.images[0]["markers"].size(), 8u);
  for (const json& marker : result.images[0]["markers"]) EXPECT_FALSE(marker.contains("position"));
}

TEST(Detect, SeeksSeveralKindsInARawFrame) {
  const fs::path scene = kScenes / "families";
  const Detection result =
      Detect({"--json", "--calibration", (scene / "camera.toml").string(), "--pixel-format", "BayerRG8", "--marker",
              "8x8:golay:0.12", "--marker", "6x7:secded:0.12", (scene / "0.png").string(), (scene / "0.png").string()});
  ASSERT_EQ(result.status, 0) << result.output;
  ASSERT_EQ(result.images.size(), 2u) << "files after --marker are files";
  std::vector<std::string> found;  // the scene holds boards of four other kinds, too
  for (const json& marker : result.images[0]["markers"])
    found.push_back(marker["variant"].get<std::string>() + " " + marker["id"].dump());
  EXPECT_THAT(found, IsSupersetOf({"golay 907", "secded 13402"}));
}

TEST(Detect, ReadsKernelsOfATable) {
  const fs::path scene = kScenes / "own_table";
  const Detection result = Detect({"--json", "--pixel-format", "BayerRG8", "--marker", "4x6", "--variant", "table",
                                   "--table", (scene / "table.txt").string(), (scene / "0.png").string()});
  ASSERT_EQ(result.status, 0) << result.output;
  EXPECT_EQ(result.images[0]["markers"].size(), 6u);
}

TEST(Detect, PrintsATableForPeople) {
  const Detection result = Detect({Frame("000000.jpg")});
  EXPECT_EQ(result.status, 0);
  EXPECT_THAT(result.output, AllOf(HasSubstr("000000.jpg: 640x480, 8 markers"), HasSubstr("25/25")));
}

TEST(Detect, TakesARecordingFrameByFrame) {
  const Detection result = Detect({"--json", kDemo.string()});
  EXPECT_EQ(result.status, 0);
  ASSERT_EQ(result.images.size(), 60u);
  EXPECT_EQ(result.images[7]["file"], Frame("000007.jpg"));
}

/// Robots drive by up to three cells from frame to frame, so that boards fit where others of their cells were expected.
TEST(Detect, ReadsEveryMarkerOfAStreamOnceInEachFrame) {
  const Detection result = Detect({"--calibration", Frame("camera.toml"), "--marker", "6x6", "--variant", "secded",
                                   "--side", "0.12", "--sequence", "--json", kDemo.string()});
  EXPECT_EQ(result.status, 0);
  ASSERT_EQ(result.images.size(), 60u);
  for (const json& image : result.images) {
    std::vector<int> ids;
    for (const json& marker : image["markers"]) ids.push_back(marker["id"].is_null() ? -1 : marker["id"].get<int>());
    EXPECT_THAT(ids, UnorderedElementsAre(0, 1, 2, 3, 4, 5, 6, 7)) << image["file"];
  }
}

TEST(Detect, SaysWherePosesRestOnLevelsOfEarlierFrames) {
  const std::vector<std::string> options = {
      "--calibration", Frame("camera.toml"), "--marker", "6x6:secded:0.12", "--learn-levels", "--json", kDemo.string()};
  EXPECT_EQ(Detect(options).status, 2) << "there is nothing to learn without --sequence";
  std::vector<std::string> of_stream = options;
  of_stream.insert(of_stream.begin(), "--sequence");
  const Detection result = Detect(of_stream);
  EXPECT_EQ(result.status, 0);
  ASSERT_EQ(result.images.size(), 60u);
  std::ptrdiff_t learnt = 0;
  for (const json& image : result.images)
    for (const json& marker : image["markers"])
      learnt += std::count(marker["warnings"].begin(), marker["warnings"].end(), "levels_learnt");
  EXPECT_GT(learnt, 0);
}

TEST(DetectOnBadInput, NamesEachBadImageAndProcessesTheOthers) {
  const TemporaryDirectory folder;
  CopyCut(kDemo / "000000.jpg", folder / "cut.jpg", 0.6);
  CopyCut(kScenes / "families/0.png", folder / "cut.png", 0.6);
  std::ofstream(folder / "text.png") << "this is no image";
  const Detection result = Detect({"--json", (folder / "missing.png").string(), (folder / "cut.jpg").string(),
                                   (folder / "cut.png").string(), (folder / "text.png").string(), Frame("000001.jpg")});
  EXPECT_EQ(result.status, 1);
  for (const char* name : {"missing.png", "cut.jpg", "cut.png", "text.png"})
    EXPECT_THAT(result.output, HasSubstr("chequer detect: " + (folder / name).string() + ": "));
  ASSERT_EQ(result.images.size(), 1u);
  EXPECT_EQ(result.images[0]["file"], Frame("000001.jpg"));
}

TEST(DetectOnBadInput, NamesBothSizesWhereTheCalibrationIsOfAnother) {
  const fs::path scene = kScenes / "families";
  const Detection result = Detect({"--json", "--calibration", Frame("camera.toml"), "--side", "0.12",
                                   (scene / "0.png").string(), Frame("000000.jpg")});
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.output, AllOf(HasSubstr((scene / "0.png").string() + ": the image is "),
                                   HasSubstr("camera.toml is for 640x480")));
  ASSERT_EQ(result.images.size(), 1u);
}

TEST(DetectOnBadInput, NamesAMissingFrameOfARecording) {
  const TemporaryDirectory folder;
  const fs::path recording = folder / "recording";
  fs::copy(kDemo, recording);
  fs::remove(recording / "000004.jpg");
  const Detection result = Detect({"--json", recording.string()});
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.output, HasSubstr((recording / "000004.jpg").string()));
  EXPECT_EQ(result.images.size(), 59u);
}

TEST(DetectOnBadInput, NamesABrokenCameraFile) {
  const TemporaryDirectory folder;
  std::ofstream(folder / "camera.toml") << "[camera]\nwidth = 640\nheight = \"many\"\n";
  const Detection result =
      Detect({"--calibration", (folder / "camera.toml").string(), "--side", "0.1", Frame("000000.jpg")});
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.output, AllOf(HasSubstr("camera.toml"), HasSubstr("height")));
}

struct BadUse {
  std::string name;
  std::vector<std::string> arguments;
  std::vector<std::string> said;
};

void PrintTo(const BadUse& use, std::ostream* out) { *out << ::testing::PrintToString(use.arguments); }

class DetectOnBadUse : public ::testing::TestWithParam<BadUse> {};

TEST_P(DetectOnBadUse, SaysWhatIsWrongAndWhatWouldBeRight) {
  std::vector<std::string> arguments = GetParam().arguments;
  arguments.push_back(Frame("000000.jpg"));
  const Detection result = Detect(arguments);
  EXPECT_EQ(result.status, 2);
  EXPECT_THAT(result.output, HasSubstr("chequer detect: "));
  for (const std::string& words : GetParam().said) EXPECT_THAT(result.output, HasSubstr(words));
}

INSTANTIATE_TEST_SUITE_P(
    , DetectOnBadUse,
    ::testing::Values(BadUse{"NegativeSide", {"--side", "-0.12"}, {"--side", "-0.12", "positive metres"}},
                      BadUse{"NegativeSideInAMarker", {"--marker", "6x6:secded:-1"}, {"-1", "positive metres"}},
                      BadUse{"NoSide", {"--calibration", (kDemo / "camera.toml").string()}, {"--side 0.12"}},
                      BadUse{
                          "UnknownVariant", {"--variant", "hamming"}, {"hamming", "unconstrained", "secded", "golay"}},
                      BadUse{"VariantOfAnotherSize", {"--variant", "golay"}, {"golay", "8x8"}},
                      BadUse{"TooSmallAMarker", {"--marker", "2x2"}, {"2x2", "at least 3x3"}},
                      BadUse{"IdThatNoMarkerHas", {"--ids", "17,5000"}, {"5000", "0 to 2047"}},
                      BadUse{"OnlyIdsThatNoMarkerHas", {"--ids", "5000"}, {"5000", "0 to 2047"}},
                      BadUse{"PixelFormatOfThreeChannels", {"--pixel-format", "BGR8"}, {"BGR8", "BayerRG8"}},
                      BadUse{"GammaOutOfRange", {"--gamma", "0"}, {"0.2 to 5"}},
                      BadUse{"UnknownColorSpace", {"--color-space", "rgb"}, {"rgb", "lab or hsv"}},
                      BadUse{"NoThread", {"--threads", "0"}, {"--threads", "1 to 64"}},
                      BadUse{"ThreadsInWords", {"--threads", "two"}, {"--threads", "two"}},
                      BadUse{"NoRepetition", {"--repeat", "0"}, {"--repeat", "0 is outside 1 to"}},
                      BadUse{"UnknownOption", {"--frob"}, {"--frob"}}),
    [](const auto& use) { return use.param.name; });

TEST(Tool, ListsItsCommandsWhereThereIsNone) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{CHEQUER}, std::vector<std::string>{CHEQUER, "detekt"}}) {
    test::Process process(arguments);
    EXPECT_EQ(process.Wait(), 2);
    EXPECT_THAT(process.output(),
                AllOf(HasSubstr("convert"), HasSubstr("detect"), HasSubstr("listen"), HasSubstr("render")));
  }
}

TEST(Tool, HelpOfEveryCommandHasAnExample) {
  for (const std::string command : {"convert", "detect", "listen", "render"}) {
    test::Process process({CHEQUER, command, "--help"});
    EXPECT_EQ(process.Wait(), 0);
    EXPECT_THAT(process.output(), HasSubstr("  chequer " + command + " ")) << command;
  }
}

TEST(Tool, NamesANumberThatIsNotAboveZero) {
  for (const std::string option : {"--seconds", "--count"}) {
    test::Process process({CHEQUER, "listen", option, "-1"});
    EXPECT_EQ(process.Wait(), 2);
    EXPECT_EQ(process.output(), "chequer listen: " + option + ": '-1' must be a number above 0\n");
  }
}

TEST(Tool, SaysThatItsOutputCannotBeWritten) {
  for (const std::string redirection : {">/dev/full", ">&-"}) {
    test::Process process({"/bin/sh", "-c", "exec '" CHEQUER "' detect '" + Frame("000000.jpg") + "' " + redirection});
    EXPECT_EQ(process.Wait(), 1);
    EXPECT_THAT(process.output(), HasSubstr("standard output could not be written"));
  }
}

TEST(Tool, TellsItsVersion) {
  test::Process process({CHEQUER, "--version"});
  EXPECT_EQ(process.Wait(), 0);
  EXPECT_THAT(process.output(), ::testing::StartsWith("chequer "));
}

}  // namespace
}  // namespace chequer
