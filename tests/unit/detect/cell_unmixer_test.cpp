#include "detect/common/cell_unmixer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "detect/common/homography.h"
#include "simulate/inks.h"
#include "simulate/print_quality.h"
#include "simulate/processing.h"
#include "simulate/random.h"
#include "support/scenes.h"

namespace chequer {
namespace {

const std::array<float, 256> kLightOfCodes = ToneCurve::Srgb().LinearTable();

/// A board with cells of 4 px, noiseless.
test::KnownFrame SmallBoard(PixelFormat format, std::uint64_t seed) {
  test::KnownFrame frame = test::OneMarker(MarkerCode({6, 6}, Variant::kSecded), 777, 4, seed);
  frame.options.format = format;
  frame.options.sensor.kind = SensorKind::kPerfect;
  frame.options.sensor.full_well_electrons = 1e6;
  return frame;
}

CellMesh MeshOf(const test::KnownFrame& frame) {
  const SceneMarker& marker = frame.scene.markers[0];
  std::array<PointPair, 4> corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const int col = k % 2 == 0 ? 0 : 6, row = k / 2 == 0 ? 0 : 6;
    corners[k].from = {col + 1, row + 1};
    corners[k].to = frame.options.camera.Project(marker.camera_from_marker * marker.PointAt(col, row));
  }
  return {.image_from_cells = *FitHomography(corners), .rows = 8, .cols = 8, .blur_px = 0.67f};
}

TEST(CellUnmixer, FindsTheInksOfCellsThatShareTheirChroma) {
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kYuv444p, PixelFormat::kYuyv, PixelFormat::kUyvy,
                                   PixelFormat::kYuv422p, PixelFormat::kNv12, PixelFormat::kYuv420p}) {
    CellUnmixer unmixer;  // the same for all: nothing is left of the run before
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const test::KnownFrame frame = SmallBoard(format, seed);
      const SceneMarker& marker = frame.scene.markers[0];
      const Image image = frame.Draw();
      const LightReader reader(image.view(), kLightOfCodes);
      std::array<Eigen::Vector3f, 64> light;
      ASSERT_TRUE(unmixer.Solve(reader, MeshOf(frame), light));
      for (int row = 0; row < 6; ++row)
        for (int col = 0; col < 6; ++col) {
          const char ink = marker.board.cells[static_cast<std::size_t>(6 * row + col)];
          const Eigen::Vector3f& seen = light[static_cast<std::size_t>(8 * (row + 1) + col + 1)];
          char nearest = '?';
          float least = 1e9f;
          for (const char other : {'K', 'W', 'B', 'Y'}) {
            // Coded values: of dark inks, light tells little.
            const float distance =
                (reader.LightOf(reader.CodesOf(marker.inks.Of(other))).cwiseSqrt() - seen.cwiseMax(0).cwiseSqrt()).norm();
            if (distance < least) least = distance, nearest = other;
          }
          EXPECT_EQ(nearest, ink) << PixelFormatName(format) << ", seed " << seed << ", cell " << row << ", " << col;
        }
    }
  }
}

TEST(CellUnmixer, CellsOutsideTheImageAreNotSolved) {
  const test::KnownFrame frame = SmallBoard(PixelFormat::kNv12, 1);
  const Image image = frame.Draw();
  const LightReader reader(image.view(), kLightOfCodes);
  CellMesh mesh = MeshOf(frame);
  mesh.image_from_cells.row(0) -= 400 * mesh.image_from_cells.row(2);
  std::array<Eigen::Vector3f, 64> light;
  EXPECT_FALSE(CellUnmixer().Solve(reader, mesh, light));
}

/// Boards of 24 px side, turned, tilted and a little blurred, with the noise of a webcam.
test::KnownFrame ManySmallBoards(std::uint64_t seed) {
  test::KnownFrame frame;
  frame.seed = seed;
  frame.options.camera = test::PlainCamera(320, 240);
  frame.options.blur_sigma_px = 1;
  frame.options.sensor.full_well_electrons = 3000;
  frame.scene.background.kind = BackgroundKind::kNoise;
  frame.scene.background.seed = seed;
  const MarkerCode code({6, 6}, Variant::kSecded);
  Random random(seed);
  for (double y = 40; y < 220; y += 40)
    for (double x = 40; x < 300; x += 40) {
      const Eigen::Vector3d at(0.12 / 24 * (x - 160 + random.Uniform()), 0.12 / 24 * (y - 120 + random.Uniform()), 3);
      const auto id = static_cast<std::uint64_t>(random.Below(2048));
      frame.scene.markers.push_back(test::MarkerOf(code, id, FacingPose(at, random.Uniform(0, 6.28), 0.3, random.Uniform(0, 6.28))));
    }
  return frame;
}

/// Of boards in frames, how many were read. None wrongly.
struct Reads {
  int boards = 0, read = 0;

  void Add(const test::KnownFrame& frame, Detector& detector) {
    const std::vector<TrueMarker> truth = frame.Truth();
    boards += static_cast<int>(truth.size());
    const Image image = frame.Draw();
    for (const MarkerPose& marker : detector.Detect(image.view())) {
      if (!marker.id) continue;
      const auto is_there = [&](const TrueMarker& board) {
        return board.id == *marker.id && (board.center_px - marker.center_px).norm() < 2;
      };
      EXPECT_TRUE(std::any_of(truth.begin(), truth.end(), is_there))
          << PixelFormatName(frame.options.format) << ", seed " << frame.seed << ": id " << *marker.id << " at "
          << marker.center_px.transpose();
      ++read;
    }
  }
};

Detector DetectorOfSmallBoards() {
  DetectorOptions options;
  options.camera = test::PlainCamera(320, 240);
  options.families[0].side_m = 0.12;
  return Detector(options);
}

TEST(SmallCells, AreReadInSubsampledColourAndNoneWrongly) {
  struct Format {
    PixelFormat format;
    std::optional<int> jpeg_quality;
    double least_read;  ///< of all boards
  };
  for (const Format& format : {Format{PixelFormat::kYuyv, {}, 0.75}, Format{PixelFormat::kNv12, {}, 0.75},
                               Format{PixelFormat::kYuv422p, 60, 0.3}}) {
    Detector detector = DetectorOfSmallBoards();
    Reads reads;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      test::KnownFrame frame = ManySmallBoards(seed);
      frame.options.format = format.format;
      frame.options.jpeg_quality = format.jpeg_quality;
      reads.Add(frame, detector);
    }
    EXPECT_GE(reads.read, format.least_read * reads.boards) << PixelFormatName(format.format);
  }
}

/// Boards of 36 px side on worn prints, by a webcam that has little light.
test::KnownFrame DimBoards(std::uint64_t seed) {
  test::KnownFrame frame;
  frame.seed = seed;
  frame.options.camera = test::PlainCamera(320, 240);
  const CameraPreset webcam = FindCameraPreset("webcam-mjpeg").value();
  frame.options.format = webcam.format;
  frame.options.jpeg_quality = webcam.jpeg_quality;
  frame.options.processing = webcam.processing;
  frame.options.sensor.kind = SensorKind::kPerfect;
  frame.options.sensor.full_well_electrons = 1000;
  frame.options.sensor.exposure = 0.15;
  frame.scene.background.kind = BackgroundKind::kPlain;
  frame.scene.background.seed = seed;
  const MarkerCode code({6, 6}, Variant::kSecded);
  const PrintKind print = NamedPrint("inkjet-worn").value();
  Random random(seed);
  for (double y = 36; y < 220; y += 56)
    for (double x = 36; x < 300; x += 56) {
      const Eigen::Vector3d at(0.12 / 36 * (x - 160 + random.Uniform()), 0.12 / 36 * (y - 120 + random.Uniform()), 2);
      const auto id = static_cast<std::uint64_t>(random.Below(2048));
      const double axis = random.Uniform(0, 6.28), tilt = random.Uniform(0, 0.5), heading = random.Uniform(0, 6.28);
      SceneMarker marker = test::MarkerOf(code, id, FacingPose(at, heading, tilt, axis));
      marker.inks = NamedInks(print.ink).value();
      Print(print.quality, random.Bits(), marker);
      frame.scene.markers.push_back(std::move(marker));
    }
  return frame;
}

TEST(SmallCells, AreReadInLowLightAndNoneWrongly) {
  Detector detector = DetectorOfSmallBoards();
  Reads reads;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) reads.Add(DimBoards(seed), detector);
  EXPECT_GE(reads.read, 0.91 * reads.boards);
}

TEST(SmallCells, AreFoundAtSteepSlants) {
  // Cells of 6 × 2 to 3 px: windows in them hold their neighbours' colours, and black looks like blue.
  DetectorOptions options;
  options.camera = test::PlainCamera(160, 120);
  options.families[0].side_m = 0.12;
  Detector detector(options);
  for (const PixelFormat format : {PixelFormat::kBgr8, PixelFormat::kBayerRg8}) {
    int found = 0, boards = 0;
    for (std::uint64_t seed = 1; seed <= 80; ++seed, ++boards) {
      Random random(seed);
      test::KnownFrame frame;
      frame.seed = seed;
      frame.options.camera = *options.camera;
      frame.options.format = format;
      const Eigen::Vector3d at(0.01 * random.Uniform(), 0.01 * random.Uniform(), 0.12 / 36 * options.camera->fx);
      const auto id = static_cast<std::uint64_t>(random.Below(2048));
      const double axis = random.Uniform(0, 6.28), tilt = random.Uniform(1.1, 1.22), heading = random.Uniform(0, 6.28);
      SceneMarker marker = test::MarkerOf(MarkerCode({6, 6}, Variant::kSecded), id, FacingPose(at, heading, tilt, axis));
      marker.margin_cells = 1;
      frame.scene.markers.push_back(std::move(marker));
      const Image image = frame.Draw();
      for (const MarkerPose& seen : detector.Detect(image.view())) {
        EXPECT_EQ(seen.id.value_or(id), id)
            << PixelFormatName(format) << ", seed " << seed;
        ++found;
      }
    }
    EXPECT_GE(found, 0.9 * boards) << PixelFormatName(format);
  }
}

TEST(CellUnmixer, WindowsDoWhereWholeSamplesFit) {
  const Image full(PixelFormat::kBgr8, 16, 16), shared(PixelFormat::kNv12, 16, 16);
  EXPECT_TRUE(CellUnmixer::WindowsAreClear(LightReader(full.view(), kLightOfCodes), 3, 0.8));
  EXPECT_FALSE(CellUnmixer::WindowsAreClear(LightReader(shared.view(), kLightOfCodes), 4, 0.8));
  EXPECT_TRUE(CellUnmixer::WindowsAreClear(LightReader(shared.view(), kLightOfCodes), 11, 0.8));
}

}  // namespace
}  // namespace chequer
