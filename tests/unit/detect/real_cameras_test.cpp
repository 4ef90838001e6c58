// Cameras and prints that are not ideal, one knob of the simulator each: what is read, how exactly, and whether
// covariances say so. Prints' scale, register and dot gain are constant_errors_test's, bent paper bent_paper_test's,
// small cells in subsampled colour cell_unmixer_test's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "simulate/print_quality.h"
#include "simulate/processing.h"
#include "simulate/random.h"
#include "support/pose_errors.h"
#include "support/scenes.h"
#include "support/stream_frames.h"

namespace chequer {
namespace {

const MarkerCode kCode66({6, 6}, Variant::kSecded);
constexpr double kBoardSideM = 0.08, kCameraFocalPx = 990;
constexpr int kFramesOfEach = 6;

/// Four boards of cells of so many pixels that lie beside each other, tilted by up to 30°, before noise.
test::KnownFrame FourBoards(double cell_px, std::uint64_t seed) {
  Random random(seed);
  test::KnownFrame frame;
  frame.seed = seed;
  frame.options.camera = test::PlainCamera(640, 480, kCameraFocalPx);
  frame.scene.background = {.kind = BackgroundKind::kNoise, .seed = seed};
  const double distance_m = kBoardSideM / 6 * kCameraFocalPx / cell_px;
  for (int i = 0; i < 4; ++i) {
    const double x = (i % 2 * 2 - 1) * 0.13 + random.Uniform(-0.04, 0.04), y = (i / 2 * 2 - 1) * 0.11;
    const Eigen::Vector3d at = distance_m * Eigen::Vector3d(x, y, 1);
    const double heading = random.Uniform(0, 2 * M_PI), tilt = random.Uniform(0, 0.5);
    frame.scene.markers.push_back(test::MarkerOf(kCode66, static_cast<std::uint64_t>(random.Below(2048)),
                                                 FacingPose(at, heading, tilt, random.Uniform(0, 2 * M_PI)),
                                                 kBoardSideM));
    frame.scene.markers.back().margin_cells = 1;
  }
  return frame;
}

/// What is not ideal, and what it may cost.
struct CameraCondition {
  const char* name;
  std::function<void(test::KnownFrame&)> change;
  double least_read;     ///< share of the boards
  double most_depth_mm;  ///< RMS
  double most_squared;   ///< mean of squared errors over what covariances say, per dimension
  double cell_px = 11;
  PrintTolerance tolerance{};
};

void PrintTo(const CameraCondition& condition, std::ostream* out) { *out << condition.name; }

std::function<void(test::KnownFrame&)> Processing(double ProcessingOptions::*knob, double amount) {
  return [=](test::KnownFrame& frame) { frame.options.processing.*knob = amount; };
}

std::function<void(test::KnownFrame&)> Delivered(PixelFormat format, std::optional<int> jpeg_quality = {}) {
  return [=](test::KnownFrame& frame) {
    frame.options.format = format;
    frame.options.jpeg_quality = jpeg_quality;
  };
}

std::function<void(test::KnownFrame&)> Webcam(const char* name) {
  return [=](test::KnownFrame& frame) {
    const CameraPreset preset = FindCameraPreset(name).value();
    frame.options.processing = preset.processing;
    frame.options.format = preset.format;
    frame.options.jpeg_quality = preset.jpeg_quality;
  };
}

std::function<void(test::KnownFrame&)> Printed(const PrintQuality& quality) {
  return [=](test::KnownFrame& frame) {
    for (std::size_t i = 0; i < frame.scene.markers.size(); ++i)
      Print(quality, DeriveSeed(frame.seed, i), frame.scene.markers[i]);
  };
}

void WithoutMargin(test::KnownFrame& frame) {
  for (SceneMarker& marker : frame.scene.markers) marker.margin_cells = 0;
}

/// A twentieth of the light, and a small sensor's noise.
void LowLight(test::KnownFrame& frame) {
  frame.options.sensor.exposure = 0.05;
  frame.options.sensor.full_well_electrons = 5000;
}

class RealCameras : public testing::TestWithParam<CameraCondition> {};

TEST_P(RealCameras, AreReadExactlyAndHonestly) {
  const CameraCondition& condition = GetParam();
  DetectorOptions options;
  options.families = {{.code = kCode66, .side_m = kBoardSideM, .roster = {}}};
  options.camera = test::PlainCamera(640, 480, kCameraFocalPx);
  options.print_tolerance = condition.tolerance;
  Detector detector(options);
  test::PoseErrors errors;
  double square_mm = 0;
  int boards = 0, read = 0;
  for (std::uint64_t seed = 700; seed < 700 + kFramesOfEach; ++seed) {
    test::KnownFrame frame = FourBoards(condition.cell_px, seed);
    condition.change(frame);
    boards += static_cast<int>(frame.scene.markers.size());
    const Image image = frame.Draw();
    for (const MarkerPose& found : detector.Detect(image.view())) {
      const auto truth = std::find_if(frame.scene.markers.begin(), frame.scene.markers.end(), [&](const auto& marker) {
        return (CenterPx(marker, frame.options.camera) - found.center_px).norm() < 3 * condition.cell_px;
      });
      ASSERT_NE(truth, frame.scene.markers.end()) << "a board where there is none, seed " << seed;
      if (found.id) {
        EXPECT_EQ(*found.id, truth->board.id) << "wrong id, seed " << seed;
        ++read;
      }
      errors.Add(truth->camera_from_marker, found);
      const double off = (found.camera_from_marker.translation - truth->camera_from_marker.translation).z();
      square_mm += 1e6 * off * off;
    }
  }
  const double depth_mm = std::sqrt(square_mm / std::max(errors.poses(), 1));
  EXPECT_GE(read, condition.least_read * boards) << "of " << boards;
  EXPECT_LT(depth_mm, condition.most_depth_mm);
  EXPECT_LT(errors.position(), condition.most_squared);
  EXPECT_LT(errors.orientation(), condition.most_squared);
}

// Bounds lie half as high again as what these seeds give. Where squared errors are large, something bends or moves the
// image that is no part of the model: red and blue lie off green, enlarged pixels off where they were. They may only
// fall.
INSTANTIATE_TEST_SUITE_P(
    Knobs, RealCameras,
    testing::Values(CameraCondition{"ideal", [](test::KnownFrame&) {}, 1, 0.07, 1.5},
                    CameraCondition{"sharpening", Processing(&ProcessingOptions::sharpening, 0.6), 1, 0.6, 1.5},
                    CameraCondition{"denoising", Processing(&ProcessingOptions::denoising_levels, 4), 1, 0.4, 1.5},
                    CameraCondition{"chromatic_aberration",
                                    Processing(&ProcessingOptions::chromatic_aberration_px, 0.5), 1, 0.15, 5.5},
                    CameraCondition{"upscaling", Processing(&ProcessingOptions::upscaling, 1.5), 1, 0.9, 13},
                    CameraCondition{"yuyv", Delivered(PixelFormat::kYuyv), 1, 0.4, 1.5},
                    CameraCondition{"nv12", Delivered(PixelFormat::kNv12), 1, 0.4, 1.5},
                    CameraCondition{"mjpeg", Delivered(PixelFormat::kYuv422p, 75), 1, 0.45, 1.5},
                    CameraCondition{"webcam_mjpeg", Webcam("webcam-mjpeg"), 1, 1.4, 9, 11, kOfficePrints},
                    CameraCondition{"webcam_yuyv", Webcam("webcam-yuyv"), 1, 1.5, 10, 11, kOfficePrints},
                    CameraCondition{"webcam_nv12", Webcam("webcam-nv12"), 1, 1.5, 7, 11, kOfficePrints},
                    CameraCondition{"no_margin", WithoutMargin, 1, 0.08, 1.5},
                    CameraCondition{"dirt", Printed({.dirt = 0.02}), 1, 0.4, 1.8},
                    CameraCondition{"gloss", Printed({.gloss = 1}), 0.8, 0.12, 1.5},
                    CameraCondition{"much_gloss", Printed({.gloss = 2}), 0.5, 0.12, 1.5},
                    CameraCondition{"inkjet_worn", Printed(NamedPrint("inkjet-worn")->quality), 1, 2.6, 3.4, 11,
                                    kOfficePrints},
                    CameraCondition{"low_light", LowLight, 1, 2.8, 1.7, 7}),
    [](const testing::TestParamInfo<CameraCondition>& info) { return std::string(info.param.name); });

/// How long the shutter takes from the first to the last row, and what bands of light then make of covariances.
struct ReadOut {
  const char* rows_read_ms;
  double most_squared;
};

void PrintTo(const ReadOut& read_out, std::ostream* out) { *out << read_out.rows_read_ms << " ms"; }

/// A lamp's mirror image pales colours, but leaves the difference of yellow's light and blue's as it is.
/// By saturation alone 50 of these 60 boards are read; by whichever tells the border's inks best 53, and 52 where
/// another compiler rounds otherwise.
TEST(Gloss, PalesNoYellow) {
  DetectorOptions options;
  options.families = {{.code = kCode66, .side_m = kBoardSideM, .roster = {}}};
  Detector detector(options);
  int boards = 0, read = 0;
  for (std::uint64_t seed = 720; seed < 735; ++seed) {
    test::KnownFrame frame = FourBoards(11, seed);
    Printed({.gloss = 1})(frame);
    boards += static_cast<int>(frame.scene.markers.size());
    for (const MarkerPose& found : detector.Detect(frame.Draw().view())) {
      if (!found.id) continue;
      ++read;
      EXPECT_TRUE(std::any_of(frame.scene.markers.begin(), frame.scene.markers.end(),
                              [&](const SceneMarker& marker) { return marker.board.id == *found.id; }))
          << "wrong id, seed " << seed;
    }
  }
  EXPECT_GE(read, 0.85 * boards);
}

/// Boards at 1.2 m as bench/real_prints draws them, with a lamp's mirror image twice as bright as paper.
test::KnownFrame FrameOfTheGlossBench(std::uint64_t seed) {
  Random random(900 + seed);
  test::KnownFrame frame;
  frame.seed = seed;
  frame.options.camera = test::PlainCamera(640, 480, kCameraFocalPx);
  for (int i = 0; i < 4; ++i) {
    const double tilt = random.Uniform(0, 40) * M_PI / 180, axis = random.Uniform(0, 2 * M_PI);
    const double z = random.Uniform(1.15, 1.25), x = (i % 2 == 0 ? -1 : 1) * random.Uniform(0.12, 0.2);
    const Eigen::Vector3d at(x, (i / 2 == 0 ? -1 : 1) * random.Uniform(0.1, 0.17), z);
    const RigidTransform pose = FacingPose(at, random.Uniform(0, 2 * M_PI), tilt, axis);
    SceneMarker marker = test::MarkerOf(kCode66, random.Bits() % (kCode66.max_id() + 1), pose, kBoardSideM);
    marker.margin_cells = 1;
    Print({.gloss = 2}, random.Bits(), marker);
    frame.scene.markers.push_back(std::move(marker));
  }
  return frame;
}

/// Under a highlight a black cell has as much blue light as a blue one elsewhere, but red light as well.
/// Board 1151 was read as 191, without a warning.
TEST(Gloss, MakesNoBlackCellBlue) {
  const test::KnownFrame frame = FrameOfTheGlossBench(114);
  const auto shown = [&](std::uint64_t id) {
    return std::any_of(frame.scene.markers.begin(), frame.scene.markers.end(),
                       [&](const SceneMarker& marker) { return marker.board.id == id; });
  };
  ASSERT_TRUE(shown(1151)) << "another frame than the one that was misread";
  DetectorOptions options;
  options.families = {{.code = kCode66, .side_m = kBoardSideM, .roster = {}}};
  int read = 0;
  for (const MarkerPose& found : Detector(options).Detect(frame.Draw().view())) {
    if (!found.id) continue;
    EXPECT_TRUE(shown(*found.id)) << *found.id;
    ++read;
  }
  EXPECT_GE(read, 2);
}

class RollingShutter : public testing::TestWithParam<ReadOut> {};

TEST_P(RollingShutter, LosesNoBoardToBandsOfFlicker) {
  // Lamps that lose a third of their light 100 times a second, as cheap LED lamps do, under a short exposure.
  const test::StreamFrames stream(
      "[camera]\nsize = \"640x480\"\nfocal_px = 990\nfps = 30\nexposure_ms = 2\ndistance = 1.2\n"
      "background = \"noise\"\nrows_read_ms = " +
      std::string(GetParam().rows_read_ms) +
      "\n[swarm]\nrobots = 6\nside = 0.08\nmargin_cells = 1\nspeed = 0\n"
      "[[phase]]\nkind = \"flicker\"\nframes = 6\ndepth = 0.3\n");
  Detector detector(stream.Options());
  test::PoseErrors errors;
  test::StreamScore score;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const test::StreamFrame frame = stream.Frame(i);
    const std::vector<MarkerPose> found = detector.Detect(frame.image.view());
    score += test::ScoreFrame(found, frame.truth);
    errors.AddDifferences(found, frame.truth.markers);
  }
  EXPECT_EQ(score.expected, 36);
  EXPECT_EQ(score.read, score.expected);
  EXPECT_EQ(score.wrong, 0);
  EXPECT_LT(errors.position(), GetParam().most_squared);
  EXPECT_LT(errors.orientation(), GetParam().most_squared);
}

// Bands as wide as two boards: light that no plane describes, so a board's covariance is too small. It may only grow
// more honest.
INSTANTIATE_TEST_SUITE_P(ReadOuts, RollingShutter,
                         testing::Values(ReadOut{"0", 2}, ReadOut{"10", 3.7}, ReadOut{"30", 10.5}),
                         [](const testing::TestParamInfo<ReadOut>& info) {
                           return std::string("rows_read_ms_") + info.param.rows_read_ms;
                         });

}  // namespace
}  // namespace chequer
