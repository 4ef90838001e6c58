// The golden runner's own tests: it must be able to fail.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "golden/judge.h"
#include "golden/scene_file.h"
#include "support/temporary_directory.h"

namespace chequer::golden {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

CameraModel Camera() { return {.width = 640, .height = 480, .fx = 500, .fy = 500, .cx = 320, .cy = 240}; }

ExpectedMarker MarkerAt(std::uint64_t id, double x) {
  ExpectedMarker marker;
  marker.id = id;
  marker.side_m = 0.12;
  marker.camera_from_marker = {Eigen::Quaterniond(0, 1, 0, 0), {x, 0, 1}};
  marker.center_px = Camera().Project(marker.camera_from_marker.translation);
  marker.cell_px = 10;
  return marker;
}

GoldenScene SceneOfTwo() {
  GoldenScene scene;
  scene.options.camera = Camera();
  scene.min_detections = 2;
  scene.tolerances = {0.5, 1, 1};
  scene.frames = {{"a.png", {MarkerAt(7, 0), MarkerAt(9, 0.3)}}};
  return scene;
}

MarkerPose PerfectDetection(const ExpectedMarker& marker) {
  MarkerPose detection;
  detection.id = marker.id;
  detection.size = marker.size;
  detection.variant = marker.variant;
  detection.center_px = marker.center_px;
  detection.has_pose = true;
  detection.camera_from_marker = marker.camera_from_marker;
  detection.corners.fill(Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (std::size_t i = 0; const Eigen::Vector2d& corner : marker.CornersPx(Camera())) {
    detection.corners[i++] = corner.cast<float>();
  }
  detection.corners_used = CornerCount(marker.size);
  return detection;
}

std::vector<MarkerPose> PerfectDetections(const GoldenScene& scene) {
  std::vector<MarkerPose> detections;
  for (const ExpectedMarker& marker : scene.frames[0].markers) detections.push_back(PerfectDetection(marker));
  return detections;
}

Verdict Judge(const GoldenScene& scene, const std::vector<MarkerPose>& detections) {
  Verdict verdict;
  JudgeFrame(scene, scene.frames[0], detections, verdict);
  JudgeCount(scene, verdict);
  return verdict;
}

TEST(Judge, PassesWhatIsRight) {
  const GoldenScene scene = SceneOfTwo();
  const Verdict verdict = Judge(scene, PerfectDetections(scene));
  EXPECT_THAT(verdict.failures, IsEmpty());
  EXPECT_EQ(verdict.expected, 2);
  EXPECT_EQ(verdict.detected, 2);
  EXPECT_LT(verdict.worst_corner_px, 1e-3);
}

TEST(Judge, FailsTooFewDetections) {
  const GoldenScene scene = SceneOfTwo();
  EXPECT_THAT(Judge(scene, {PerfectDetections(scene)[1]}).failures, ElementsAre(HasSubstr("found 1 markers of 2")));
}

TEST(Judge, FailsAWrongIdSizeOrVariant) {
  GoldenScene scene = SceneOfTwo();
  scene.min_detections = 0;
  MarkerPose detection = PerfectDetections(scene)[0];
  detection.id = 8;
  EXPECT_THAT(Judge(scene, {detection}).failures, ElementsAre(HasSubstr("id 8 at (320, 240) is in truth")));
  detection.id = 7;
  detection.size = {8, 8};
  EXPECT_EQ(Judge(scene, {detection}).failures.size(), 1u);
  detection.size = {6, 6};
  detection.variant = Variant::kUnconstrained;
  EXPECT_EQ(Judge(scene, {detection}).failures.size(), 1u);
}

TEST(Judge, FailsAGhostEvenWithoutAnId) {
  const GoldenScene scene = SceneOfTwo();
  std::vector<MarkerPose> detections = PerfectDetections(scene);
  detections.push_back(detections[0]);
  detections.back().id = std::nullopt;
  detections.back().center_px = {50, 50};
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("board without id at (50, 50)")));
}

TEST(Judge, FailsAMarkerFoundTwice) {
  const GoldenScene scene = SceneOfTwo();
  std::vector<MarkerPose> detections = PerfectDetections(scene);
  detections.push_back(detections[0]);
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("found twice")));
}

TEST(Judge, AnUndecidedBoardInAMarkersPlaceIsNoFailureByItself) {
  GoldenScene scene = SceneOfTwo();
  scene.min_detections = 1;
  std::vector<MarkerPose> detections = PerfectDetections(scene);
  detections[0].id = std::nullopt;
  const Verdict verdict = Judge(scene, detections);
  EXPECT_THAT(verdict.failures, IsEmpty());
  EXPECT_EQ(verdict.undecided, 1);
  EXPECT_EQ(verdict.detected, 1);
}

TEST(Judge, FailsBeyondEachTolerance) {
  const GoldenScene scene = SceneOfTwo();
  std::vector<MarkerPose> detections = PerfectDetections(scene);
  detections[0].corners[3].x() += 0.6f;
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("a corner (px) off by 0.6")));
  detections = PerfectDetections(scene);
  detections[0].camera_from_marker.translation.z() += 0.0015;
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("position (mm) off by 1.5")));
  detections = PerfectDetections(scene);
  detections[0].camera_from_marker.rotation =
      RotationFromVector({0, 0, 2 * std::numbers::pi / 180}) * detections[0].camera_from_marker.rotation;
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("orientation (deg) off by 2")));
  detections[0].warnings = static_cast<std::uint32_t>(Warning::kAmbiguous);
  EXPECT_THAT(Judge(scene, detections).failures, IsEmpty());
  detections[0].has_pose = false;
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("no pose")));
}

TEST(Judge, UnseenCornersAreLeftOutAndCounted) {
  const GoldenScene scene = SceneOfTwo();
  std::vector<MarkerPose> detections = PerfectDetections(scene);
  detections[0].corners[3].fill(std::numeric_limits<float>::quiet_NaN());
  EXPECT_THAT(Judge(scene, detections).failures, ElementsAre(HasSubstr("corners_used")));
  detections[0].corners_used = 24;
  EXPECT_THAT(Judge(scene, detections).failures, IsEmpty());
}

constexpr char kSceneToml[] = R"(description = "nothing"
frames = 2
[[marker]]
size = "6x6"
variant = "secded"
side = 0.12
[expect]
min_detections = 0
)";
constexpr char kCameraToml[] = R"([camera]
width = 640
height = 480
fx = 500
fy = 500
cx = 320
cy = 240
model = "pinhole"
)";
constexpr char kTruth[] = "{\"file\":\"a.png\",\"markers\":[]}\n{\"file\":\"b.png\",\"markers\":[]}\n";

class SceneFolder : public testing::Test {
 protected:
  SceneFolder() {
    Write("scene.toml", kSceneToml);
    Write("camera.toml", kCameraToml);
    Write("truth.jsonl", kTruth);
    Write("a.png", "");
    Write("b.png", "");
  }
  void Write(const std::string& name, const std::string& text) { std::ofstream(folder_.path() / name) << text; }
  std::string LoadError() {
    try {
      LoadScene(folder_.path());
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  test::TemporaryDirectory folder_;
};

TEST_F(SceneFolder, IsRead) {
  const GoldenScene scene = LoadScene(folder_.path());
  EXPECT_EQ(scene.frames.size(), 2u);
  EXPECT_EQ(scene.options.families.size(), 1u);
  EXPECT_EQ(scene.options.camera->fx, 500);
}

TEST_F(SceneFolder, FailsOnAnotherNumberOfFiles) {
  Write("c.png", "");
  EXPECT_THAT(LoadError(), HasSubstr("states 2 frames, the folder holds 3 images"));
  std::filesystem::remove(folder_.path() / "c.png");
  std::filesystem::remove(folder_.path() / "b.png");
  EXPECT_THAT(LoadError(), HasSubstr("the folder holds 1 images"));
  Write("c.png", "");
  EXPECT_THAT(LoadError(), HasSubstr("must be the same files"));
}

TEST_F(SceneFolder, FailsOnUnknownKeysAndMissingTolerances) {
  Write("scene.toml", std::string(kSceneToml) + "max_wrong = 3\n");
  EXPECT_THAT(LoadError(), HasSubstr("max_wrong"));
  std::string some(kSceneToml);
  some.replace(some.find("min_detections = 0"), 18, "min_detections = 1");
  Write("scene.toml", some);
  EXPECT_THAT(LoadError(), HasSubstr("corner_px"));
}

TEST_F(SceneFolder, FailsOnAFrameThatIsNoImage) {
  const GoldenScene scene = LoadScene(folder_.path());
  EXPECT_THROW(LoadFrame(folder_.path() / "a.png", scene), std::runtime_error);
}

}  // namespace
}  // namespace chequer::golden
