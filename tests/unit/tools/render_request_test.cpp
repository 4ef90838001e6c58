#include "tools/render_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <numbers>
#include <set>

#include "chequer/camera_file.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

/// What `chequer render` plans for these arguments.
RenderJob Plan(std::vector<std::string> arguments) {
  CLI::App app;
  RenderRequest request;
  AddRenderOptions(app, request);
  arguments.insert(arguments.begin(), {"--out", "unused"});
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return PlanRender(request);
}

std::string Refusal(const std::vector<std::string>& arguments) {
  try {
    Plan(arguments);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

TEST(PlanRender, OneMarkerStandsWhereAsked) {
  const RenderJob job = Plan({"--marker", "6x6:secded:0.04", "--ids", "17", "--position", "0.1,-0.2,1.5", "--heading",
                              "90", "--size", "640x480", "--focal", "500"});
  const auto markers = job.markers_at(std::chrono::seconds(0));
  ASSERT_EQ(markers.size(), 1u);
  EXPECT_EQ(markers[0].board.id, 17u);
  EXPECT_EQ(markers[0].side_m, 0.04);
  EXPECT_EQ(markers[0].camera_from_marker.translation, Eigen::Vector3d(0.1, -0.2, 1.5));
  // Clockwise by a quarter: the marker's x axis points down.
  const Eigen::Vector3d x = markers[0].camera_from_marker.rotation * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(x.y(), 1, 1e-12);
  EXPECT_EQ(job.options.camera.fx, 500);
  EXPECT_EQ(job.options.camera.cx, 319.5);
}

TEST(PlanRender, LensAndPixelPitchGiveTheFocalLength) {
  const RenderJob job = Plan({"--side", "0.1", "--lens", "6", "--pixel-pitch", "3"});
  EXPECT_DOUBLE_EQ(job.options.camera.fx, 2000);
}

TEST(PlanRender, CameraFileIsUsedWhole) {
  const test::TemporaryDirectory folder;
  CameraModel camera{.width = 320, .height = 240, .fx = 300, .fy = 301, .cx = 160, .cy = 121};
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.2, 0.05, 0, 0, 0};
  WriteCamera(folder / "camera.toml", camera);
  const RenderJob job = Plan({"--side", "0.1", "--camera-file", (folder / "camera.toml").string()});
  EXPECT_EQ(job.options.camera.distortion, camera.distortion);
  EXPECT_EQ(job.options.camera.height, 240);
  EXPECT_THAT(Refusal({"--side", "0.1", "--camera-file", (folder / "camera.toml").string(), "--focal", "3"}),
              HasSubstr("--camera-file"));
}

TEST(PlanRender, SwarmTakesFamiliesInTurnAndIdsOnce) {
  const RenderJob job = Plan({"--marker", "6x6:secded:0.1", "--marker", "8x8:golay:0.15", "--swarm", "10"});
  const auto markers = job.markers_at(std::chrono::seconds(1));
  ASSERT_EQ(markers.size(), 10u);
  std::set<std::pair<std::string, std::uint64_t>> different;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    EXPECT_EQ(markers[i].board.rows, i % 2 == 0 ? 6 : 8);
    EXPECT_EQ(markers[i].side_m, i % 2 == 0 ? 0.1 : 0.15);
    different.emplace(markers[i].board.variant, markers[i].board.id);
  }
  EXPECT_EQ(different.size(), 10u);
}

TEST(PlanRender, SwarmMovesWithTheFrames) {
  const RenderJob job = Plan({"--side", "0.1", "--swarm", "5", "--fps", "10", "--frames", "3"});
  EXPECT_DOUBLE_EQ(job.TimeOf(2).count(), 0.2);
  const auto first = job.markers_at(job.TimeOf(0)), last = job.markers_at(job.TimeOf(2));
  EXPECT_GT((first[0].camera_from_marker.translation - last[0].camera_from_marker.translation).norm(), 0.01);
}

TEST(PlanRender, OptionsReachTheCamera) {
  const RenderJob job =
      Plan({"--side",  "0.1", "--motion",       "3",        "--motion-angle", "90",    "--white-balance", "0.8,1,1.2",
            "--gamma", "1",   "--pixel-format", "BayerGB8", "--ink",          "faded", "--background",    "wood",
            "--haze",  "0.1", "--full-well",    "500"});
  EXPECT_EQ(job.options.motion_px, 3);
  EXPECT_NEAR(job.options.motion_angle_rad, std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(job.options.sensor.white_balance, (std::array<double, 3>{0.8, 1, 1.2}));
  EXPECT_EQ(job.options.tone_curve, ToneCurve::Linear());
  EXPECT_EQ(job.options.format, PixelFormat::kBayerGb8);
  EXPECT_EQ(job.options.lighting.haze, 0.1);
  EXPECT_EQ(job.options.sensor.full_well_electrons, 500);
  EXPECT_EQ(job.background.kind, BackgroundKind::kWood);
  EXPECT_EQ(job.markers_at({})[0].inks, *NamedInks("faded"));
}

TEST(PlanRender, FilesHoldTheFormat) {
  EXPECT_EQ(Plan({"--side", "0.1"}).files.kind, FrameFileKind::kPng);
  EXPECT_EQ(Plan({"--side", "0.1", "--pixel-format", "BayerRG8"}).files.kind, FrameFileKind::kPng);
  EXPECT_EQ(Plan({"--side", "0.1", "--pixel-format", "NV12"}).files.kind, FrameFileKind::kRaw);
  const RenderJob jpeg = Plan({"--side", "0.1", "--pixel-format", "YUV422P", "--jpeg", "70"});
  EXPECT_EQ(jpeg.files.kind, FrameFileKind::kJpeg);
  EXPECT_EQ(jpeg.files.jpeg.quality, 70);
  // Once is enough: the files are the camera's JPEG.
  EXPECT_FALSE(jpeg.options.jpeg_quality.has_value());
}

TEST(PlanRender, PresetsOfCamerasGiveWayToOptions) {
  const RenderJob webcam = Plan({"--side", "0.1", "--camera", "webcam-mjpeg"});
  EXPECT_EQ(webcam.options.format, PixelFormat::kYuv422p);
  EXPECT_EQ(webcam.files.kind, FrameFileKind::kJpeg);
  EXPECT_GT(webcam.options.processing.sharpening, 0);
  const RenderJob other =
      Plan({"--side", "0.1", "--camera", "webcam-mjpeg", "--pixel-format", "NV12", "--sharpening", "0"});
  EXPECT_EQ(other.options.format, PixelFormat::kNv12);
  EXPECT_EQ(other.files.kind, FrameFileKind::kRaw);
  EXPECT_EQ(other.options.processing.sharpening, 0);
  EXPECT_EQ(other.options.processing.saturation, webcam.options.processing.saturation);
  EXPECT_THAT(Refusal({"--side", "0.1", "--camera", "webcam"}), AllOf(HasSubstr("--camera"), HasSubstr("webcam-yuyv")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--camera-curve", "knee:7"}), HasSubstr("--camera-curve"));
}

TEST(PlanRender, RefusalsNameTheOptionAndWhatWouldBeRight) {
  EXPECT_THAT(Refusal({}), AllOf(HasSubstr("--side"), HasSubstr("0.12")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--size", "640"}), AllOf(HasSubstr("--size"), HasSubstr("1920x1080")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--lens", "6"}), HasSubstr("--pixel-pitch"));
  EXPECT_THAT(Refusal({"--side", "0.1", "--lens", "6", "--pixel-pitch", "3", "--focal", "9"}), HasSubstr("--focal"));
  EXPECT_THAT(Refusal({"--side", "0.1", "--ink", "crayon"}), AllOf(HasSubstr("--ink"), HasSubstr("laser")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--background", "lava"}), AllOf(HasSubstr("lava"), HasSubstr("wood")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--position", "0,0,-1"}), HasSubstr("--position"));
  EXPECT_THAT(Refusal({"--side", "0.1", "--ids", "1-3", "--swarm", "4"}),
              AllOf(HasSubstr("--ids"), HasSubstr("--swarm 4")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--frames", "0"}), HasSubstr("--frames"));
  EXPECT_THAT(Refusal({"--side", "0.1", "--pixel-format", "RAW"}), AllOf(HasSubstr("RAW"), HasSubstr("BayerRG8")));
  EXPECT_THAT(Refusal({"--side", "0.1", "--jpeg", "90", "--pixel-format", "BayerRG8"}), HasSubstr("--jpeg"));
  EXPECT_THAT(Refusal({"--side", "0.1", "--haze", "2"}), HasSubstr("haze"));
  EXPECT_THAT(Refusal({"--side", "1", "--swarm", "100"}), HasSubstr("do not fit"));
  EXPECT_THAT(Refusal({"--peer", "qr", "--side", "0.1"}), AllOf(HasSubstr("--peer"), HasSubstr("tag36h11")));
}

TEST(PlanRender, SheetShowsAllMarkersOfThePageAnotherWayInEachFrame) {
  const RenderJob job = Plan({"--marker", "6x6:secded:30mm", "--ids", "0-19", "--sheet", "--frames", "3", "--fps", "5",
                              "--size", "1280x960", "--focal", "1100"});
  const auto first = job.markers_at(job.TimeOf(0)), second = job.markers_at(job.TimeOf(1));
  ASSERT_EQ(first.size(), 20u);
  // One flat sheet: the way from marker to marker is the same in all frames, and that of the print: 30 mm, a margin of
  // a cell at each side, 4 mm between.
  const auto apart = [](const std::vector<SceneMarker>& markers) {
    return (markers[0].camera_from_marker.translation - markers[1].camera_from_marker.translation).norm();
  };
  EXPECT_NEAR(apart(first), 0.044, 1e-9);
  EXPECT_NEAR(apart(second), 0.044, 1e-9);
  EXPECT_GT((first[0].camera_from_marker.translation - second[0].camera_from_marker.translation).norm(), 0.01);
  EXPECT_THAT(Refusal({"--side", "30mm", "--sheet"}), HasSubstr("--ids"));
  EXPECT_THAT(Refusal({"--side", "30mm", "--ids", "0-3", "--sheet", "--swarm", "3"}), HasSubstr("choose one"));
}

TEST(PlanRender, SheetIsOnePrintWithAllOfItOffAlike) {
  const std::vector<std::string> plain{"--marker", "6x6:secded:30mm", "--ids",   "0-19", "--sheet",
                                       "--size",   "1280x960",        "--focal", "1100"};
  std::vector<std::string> off = plain;
  off.insert(off.end(),
             {"--print-scale", "1.01,0.98", "--register", "0.1mm", "--ink-spread", "0.03", "--ink", "inkjet"});
  const auto meant = Plan(plain).markers_at(std::chrono::seconds(0));
  const auto printed = Plan(off).markers_at(std::chrono::seconds(0));
  ASSERT_EQ(meant.size(), printed.size());
  EXPECT_EQ(meant[0].print.scale, Eigen::Vector2d(1, 1));
  EXPECT_TRUE(meant[0].print.in_register());
  for (const SceneMarker& marker : printed) {
    EXPECT_NEAR((marker.print.scale - Eigen::Vector2d(1.01, 0.98)).norm(), 0, 1e-12);
    EXPECT_FALSE(marker.print.in_register());
    EXPECT_EQ(marker.print.blue_shift_m, printed[0].print.blue_shift_m);
    EXPECT_EQ(marker.ink_spread_cells, 0.03);
    EXPECT_EQ(marker.inks.blue, NamedInks("inkjet")->blue);
  }
  const auto apart = [](const std::vector<SceneMarker>& markers) {
    return (markers[0].camera_from_marker.translation - markers[1].camera_from_marker.translation).norm();
  };
  EXPECT_NEAR(apart(printed) / apart(meant), 1.01, 1e-9);  // two of a row
}

TEST(PlanRender, PaperBendsAsAsked) {
  const auto one = Plan({"--side", "0.1", "--bend", "-50cm", "--bend-angle", "90"}).markers_at({});
  EXPECT_DOUBLE_EQ(one[0].bend_per_m, -2);
  EXPECT_NEAR(one[0].bend_angle_rad, std::numbers::pi / 2, 1e-12);
  const auto swarm = Plan({"--side", "0.1", "--swarm", "4", "--print", "inkjet-worn"}).markers_at({});
  EXPECT_LT(swarm[0].bend_per_m, 0);
  EXPECT_NE(swarm[0].bend_angle_rad, swarm[1].bend_angle_rad) << "each its own way";
  EXPECT_EQ(Plan({"--side", "0.1", "--print", "inkjet-worn", "--bend", "0"}).markers_at({})[0].bend_per_m, 0);
  const auto refused = [](const std::vector<std::string>& last) {
    std::vector<std::string> arguments{"--side", "0.1"};
    arguments.insert(arguments.end(), last.begin(), last.end());
    return Refusal(arguments);
  };
  EXPECT_THAT(refused({"--bend", "much"}),
              AllOf(HasSubstr("--bend"), HasSubstr("'much'"), HasSubstr("0.01 to 1000 m")));
  EXPECT_THAT(refused({"--bend", "2000"}), AllOf(HasSubstr("--bend"), HasSubstr("0.01 to 1000 m")));
  EXPECT_THAT(refused({"--bend", "9cm"}), AllOf(HasSubstr("--bend"), HasSubstr("at least 0.1 m")));
  EXPECT_THAT(refused({"--bend-angle", "90"}), AllOf(HasSubstr("--bend-angle"), HasSubstr("--bend RADIUS")));
  EXPECT_THAT(refused({"--bend", "1m", "--bend-angle", "400"}), AllOf(HasSubstr("--bend-angle"), HasSubstr("360")));
}

TEST(PlanRender, PrintsShineAsAsked) {
  EXPECT_EQ(Plan({"--side", "0.1", "--gloss", "2"}).markers_at({})[0].highlight.strength, 2);
  EXPECT_EQ(Plan({"--side", "0.1"}).markers_at({})[0].highlight.strength, 0);
  EXPECT_THAT(Refusal({"--side", "0.1", "--gloss", "9"}), AllOf(HasSubstr("--gloss"), HasSubstr("5")));
}

TEST(PlanRender, SheetBendsAsAWhole) {
  const std::vector<std::string> sheet{"--marker", "6x6:secded:30mm", "--ids", "0-19",   "--sheet",  "--bend",
                                       "0.5m",     "--bend-angle",    "0",     "--size", "1280x960", "--focal",
                                       "1100"};
  const auto markers = Plan(sheet).markers_at({});
  ASSERT_EQ(markers.size(), 20u);
  // Neighbours of a row are 44 mm of paper apart, hence turned by that over the radius; those of a column not.
  const auto turned = [&](std::size_t i) {
    return markers[0].camera_from_marker.rotation.angularDistance(markers[i].camera_from_marker.rotation);
  };
  EXPECT_NEAR(turned(1), 0.044 / 0.5, 1e-9);
  EXPECT_NEAR(turned(4), 0, 1e-9);
  EXPECT_NEAR((markers[0].camera_from_marker.translation - markers[1].camera_from_marker.translation).norm(),
              2 * 0.5 * std::sin(0.044 / 0.5 / 2), 1e-9);
  EXPECT_THAT(Refusal({"--marker", "6x6:secded:30mm", "--ids", "0-19", "--sheet", "--bend", "0.2m"}),
              AllOf(HasSubstr("--bend"), HasSubstr("0.297 m")));
}

TEST(PlanRender, RoomHasItsReferencesOnTheFloorAndRobotsThatDrive) {
  const test::TemporaryDirectory folder;
  const std::string room = folder / "room.toml";
  std::ofstream(room) << "[[reference]]\nid = 8\nposition = [0, 0]\n[[reference]]\nid = 9\nposition = [1.2, 0]\n"
                         "[[reference]]\nid = 10\nposition = [0, 1]\n";
  const RenderJob job = Plan({"--marker", "6x6:secded:60mm", "--ids", "0-10", "--room", room, "--distance", "2",
                              "--size", "1280x960", "--focal", "1100", "--speed", "0.1"});
  const auto now = job.markers_at(std::chrono::seconds(0)), later = job.markers_at(std::chrono::seconds(1));
  ASSERT_EQ(now.size(), 11u);
  EXPECT_EQ(now[1].board.id, 9u);
  // The floor stands still; robots go 0.1 m a second, on circles.
  EXPECT_EQ(now[1].camera_from_marker.translation, later[1].camera_from_marker.translation);
  EXPECT_NEAR((now[1].camera_from_marker.translation - now[0].camera_from_marker.translation).norm(), 1.2, 1e-9);
  EXPECT_NEAR((now[5].camera_from_marker.translation - later[5].camera_from_marker.translation).norm(), 0.0935, 0.001);
  const auto off = Plan({"--marker", "6x6:secded:60mm", "--ids", "0-10", "--room", room, "--distance", "2", "--size",
                         "1280x960", "--focal", "1100", "--print", "office"});
  const auto first = off.markers_at(std::chrono::seconds(0)), then = off.markers_at(std::chrono::seconds(1));
  // Each is a print of its own, and stays it.
  EXPECT_NE(first[0].print.scale, first[1].print.scale);
  EXPECT_EQ(first[1].print.scale, then[1].print.scale);
  EXPECT_THAT(Refusal({"--side", "6cm", "--ids", "0-3", "--room", "/nowhere.toml"}), HasSubstr("/nowhere.toml"));
}

}  // namespace
}  // namespace chequer
