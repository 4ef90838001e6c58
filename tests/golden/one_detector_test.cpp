// One detector sees all kinds of frames, one after the other and in any order, and says of each what a new detector
// says of it, to the last bit: nothing of a frame outlasts it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "chequer/detect_trace.h"
#include "chequer/detector.h"
#include "golden/scene_file.h"
#include "support/mixed_frames.h"
#include "support/same_bits.h"

namespace chequer {
namespace {

using test::Detected;
using test::NamedFrame;

/// What a trace says of what was refused, and where it was looked again.
std::string Told(const DetectTrace& trace) {
  std::ostringstream text;
  text << std::hexfloat << trace.corners.size() << " corners, " << trace.links.size() << " links";
  for (const TraceCandidate& candidate : trace.candidates)
    text << "; " << RefusalName(candidate.refusal) << ' ' << candidate.measured << ' ' << candidate.required << ' '
         << candidate.cells.size() << ' ' << candidate.center_px.transpose() << ' ' << candidate.marker;
  for (const TracePlace& place : trace.places)
    text << "; place " << static_cast<int>(place.fate) << ' ' << place.center_px.transpose() << ' ' << place.points
         << ' ' << place.corners << ' ' << place.most_linked << ' ' << place.boards;
  return text.str();
}

/// What a new detector says of a frame.
struct Expected {
  Detected detected;
  std::string told;
  int boards_by_sharpening = 0;
};

Expected ByNewDetector(const DetectorOptions& options, const Image& image) {
  Detector detector(options);
  Expected expected;
  DetectTrace trace;
  detector.Detect(image.view(), expected.detected.markers, &trace);
  expected.detected.stats = detector.stats();
  expected.told = Told(trace);
  Detector untraced(options);
  untraced.Detect(image.view(), expected.detected.markers);
  expected.detected.stats = untraced.stats();
  for (const TracePlace& place : trace.places) expected.boards_by_sharpening += place.sharpened ? place.boards : 0;
  return expected;
}

/// Frames with what new detectors say of them.
class Course {
 public:
  Course(DetectorOptions options, std::vector<NamedFrame> frames)
      : options_(std::move(options)), frames_(std::move(frames)) {
    for (const NamedFrame& frame : frames_) expected_.push_back(ByNewDetector(options_, frame.image));
  }

  std::size_t size() const { return frames_.size(); }
  std::size_t markers() const {
    std::size_t count = 0;
    for (const Expected& expected : expected_) count += expected.detected.markers.size();
    return count;
  }
  /// Frames with boards that only show where smears are made even.
  std::ptrdiff_t motion_blurred_frames() const {
    return std::count_if(expected_.begin(), expected_.end(),
                         [](const Expected& expected) { return expected.boards_by_sharpening > 0; });
  }

  /// All frames by one detector, in several orders.
  void Run(int threads) const {
    DetectorOptions options = options_;
    options.threads = threads;
    Detector detector(options);
    std::vector<std::size_t> order(frames_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::vector<std::size_t> shuffled = order;
    std::mt19937 random(7);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    const std::string by = ", by " + std::to_string(threads) + " threads";
    Pass(shuffled, "shuffled" + by, true, detector);
    Pass(order, "forwards" + by, false, detector);
    std::reverse(order.begin(), order.end());
    Pass(order, "backwards" + by, false, detector);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    Pass(shuffled, "shuffled anew" + by, false, detector);
  }

 private:
  void Pass(const std::vector<std::size_t>& order, const std::string& how, bool traced, Detector& detector) const {
    constexpr int kMostFailures = 5;
    Detected detected;
    std::string before = "nothing";
    int failures = 0;
    for (const std::size_t i : order) {
      DetectTrace trace;
      detector.Detect(frames_[i].image.view(), detected.markers, traced ? &trace : nullptr);
      detected.stats = detector.stats();
      // Who traces looks at more, and counts it.
      if (traced) detected.stats.work = expected_[i].detected.stats.work;
      std::string difference = DifferenceOf(expected_[i].detected, detected);
      if (difference.empty() && traced && Told(trace) != expected_[i].told)
        difference = "the trace tells " + Told(trace) + ", should tell " + expected_[i].told;
      if (!difference.empty()) {
        ADD_FAILURE() << how << ": " << frames_[i].name << " after " << before << ": " << difference;
        if (++failures == kMostFailures) return;
      }
      before = frames_[i].name;
    }
  }

  DetectorOptions options_;
  std::vector<NamedFrame> frames_;
  std::vector<Expected> expected_;
};

void Append(std::vector<NamedFrame> more, std::vector<NamedFrame>& frames) {
  std::move(more.begin(), more.end(), std::back_inserter(frames));
}

std::vector<golden::GoldenScene> GoldenScenes() {
  std::vector<golden::GoldenScene> scenes;
  for (const auto& entry : std::filesystem::directory_iterator(CHEQUER_GOLDEN_SCENES))
    scenes.push_back(golden::LoadScene(entry.path()));
  std::sort(scenes.begin(), scenes.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return scenes;
}

std::vector<NamedFrame> GoldenFrames(const std::vector<golden::GoldenScene>& scenes) {
  std::vector<NamedFrame> frames;
  for (const golden::GoldenScene& scene : scenes)
    for (const golden::ExpectedFrame& frame : scene.frames) {
      const std::filesystem::path path = std::filesystem::path(CHEQUER_GOLDEN_SCENES) / scene.name / frame.file;
      frames.push_back({"golden " + scene.name + "/" + frame.file, golden::LoadFrame(path, scene)});
    }
  return frames;
}

DetectorOptions SwarmOptions() {
  DetectorOptions options;
  options.families = {{.code = MarkerCode({6, 6}, Variant::kSecded), .side_m = test::kMixedSideM, .roster = {}}};
  options.camera = test::MixedCamera();
  return options;
}

/// All that the golden scenes seek, with the camera of one of them.
DetectorOptions OptionsOfAll(const std::vector<golden::GoldenScene>& scenes) {
  DetectorOptions options;
  options.color_space = ColorSpace::kHsv;
  options.families.clear();
  for (const golden::GoldenScene& scene : scenes) {
    if (scene.name == "tilted") options.camera = scene.options.camera;
    for (const MarkerFamily& family : scene.options.families) {
      const bool known = std::any_of(options.families.begin(), options.families.end(), [&](const MarkerFamily& other) {
        return other.code.size() == family.code.size() && other.code.variant() == family.code.variant();
      });
      if (!known) options.families.push_back(family);
    }
  }
  return options;
}

TEST(SameBits, TellsWhatDiffers) {
  Detected one;
  one.markers.resize(2);
  for (MarkerPose& marker : one.markers) marker.corners.fill(Eigen::Vector2f::Constant(NAN));
  EXPECT_EQ(DifferenceOf(one, one), "") << "a NaN is one";
  const auto difference = [&](const auto& change) {
    Detected other = one;
    change(other);
    return DifferenceOf(one, other);
  };
  EXPECT_EQ(difference([](Detected& d) { d.markers.pop_back(); }), "1 markers, should be 2");
  EXPECT_EQ(difference([](Detected& d) { d.markers[1].id = 0; }), "marker 1: has an id is 1, should be 0");
  EXPECT_EQ(difference([](Detected& d) { d.markers[1].ambiguity = -0.0; }), "marker 1: ambiguity is -0, should be 0");
  EXPECT_EQ(difference([](Detected& d) { d.markers[0].corners[129].y() = 3; }),
            "marker 0: corner 129[1] is 3, should be nan");
  EXPECT_EQ(difference([](Detected& d) { d.markers[0].measurement.information(7, 7) = 2; }),
            "marker 0: information[63] is 2, should be 0");
  EXPECT_EQ(difference([](Detected& d) { d.markers[0].warnings = 4; }), "marker 0: warnings is 4, should be 0");
  EXPECT_TRUE(difference([](Detected& d) { d.stats.undecided = 1; }).starts_with("stats: count "));
}

TEST(OneDetector, SaysWhatNewOnesSayOfEverything) {
  std::vector<NamedFrame> frames = test::TroubledFrames();
  Append(GoldenFrames(GoldenScenes()), frames);
  Append(test::StressFrames(), frames);
  Append(test::StreamSample(), frames);
  const Course course(SwarmOptions(), std::move(frames));
  EXPECT_GT(course.size(), 150u);
  EXPECT_GT(course.markers(), 500u);
  EXPECT_GT(course.motion_blurred_frames(), 3);
  for (const int threads : {1, 4}) course.Run(threads);
}

TEST(OneDetector, SaysWhatNewOnesSayOfEverythingOfManyFamilies) {
  const std::vector<golden::GoldenScene> scenes = GoldenScenes();
  std::vector<NamedFrame> frames = GoldenFrames(scenes);
  Append(test::TroubledFrames(12), frames);
  const Course course(OptionsOfAll(scenes), std::move(frames));
  EXPECT_GT(course.markers(), 100u);
  for (const int threads : {1, 4}) course.Run(threads);
}

// What is left of the above for the sanitizers.
TEST(OneDetector, SaysWhatNewOnesSayOfSomeFrames) {
  std::vector<NamedFrame> frames = test::TroubledFrames(6), golden = GoldenFrames(GoldenScenes());
  for (std::size_t i = 0; i < golden.size(); i += 4) frames.push_back(std::move(golden[i]));
  const Course course(SwarmOptions(), std::move(frames));
  EXPECT_GT(course.markers(), 20u);
  EXPECT_GT(course.motion_blurred_frames(), 0);
  course.Run(2);
}

}  // namespace
}  // namespace chequer
