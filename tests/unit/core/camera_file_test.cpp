#include "chequer/camera_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "core/lens_parameters.h"
#include "support/error_of.h"
#include "support/temporary_directory.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kGood = R"([camera]
width = 640
height = 480
fx = 540.5
fy = 541
cx = 322.3
cy = 237.1
model = "brown_conrady"
distortion = [-0.25, 0.08, 0, 0, 0]
)";

/// kGood with one line changed.
std::string With(const std::string& line, const std::string& replacement) {
  std::string text = kGood;
  const std::size_t start = text.find(line + " =");
  return text.replace(start, text.find('\n', start) - start, replacement);
}

std::string ErrorOfCamera(const std::string& text) {
  return test::ErrorOf([&] { ParseCamera(text, "cam.toml"); });
}

TEST(CameraFile, ReadsEveryKey) {
  const CameraModel camera = ParseCamera(kGood, "cam.toml");
  EXPECT_EQ(camera.width, 640);
  EXPECT_EQ(camera.height, 480);
  EXPECT_EQ(camera.fx, 540.5);
  EXPECT_EQ(camera.fy, 541);
  EXPECT_EQ(camera.cx, 322.3);
  EXPECT_EQ(camera.cy, 237.1);
  EXPECT_EQ(camera.kind, CameraModel::Kind::kBrownConrady);
  EXPECT_THAT(camera.distortion, ::testing::ElementsAre(-0.25, 0.08, 0, 0, 0));
}

TEST(CameraFile, ReadsFisheyeAndPinhole) {
  const std::string fisheye = With("model", "model = \"fisheye\"")
                                  .replace(With("model", "model = \"fisheye\"").find("distortion"), std::string::npos,
                                           "distortion = [1, 2, 3, 4]");
  const CameraModel camera = ParseCamera(fisheye, "cam.toml");
  EXPECT_EQ(camera.kind, CameraModel::Kind::kFisheye);
  EXPECT_THAT(camera.distortion, ::testing::ElementsAre(1, 2, 3, 4, 0));

  std::string pinhole = With("model", "model = \"pinhole\"");
  pinhole.erase(pinhole.find("distortion"));
  EXPECT_EQ(ParseCamera(pinhole, "cam.toml").kind, CameraModel::Kind::kPinhole);
}

TEST(CameraFile, ReadsAndWritesAToneCurve) {
  EXPECT_FALSE(ParseCamera(kGood, "cam.toml").tone_curve);
  const std::string gamma = std::string(kGood) + "gamma = 1.4\n";
  EXPECT_EQ(ParseCamera(gamma, "cam.toml").tone_curve, ToneCurve::Gamma(1.4));
  const std::string bends = "gamma_bends = [0.01, 0.02, 0.03, 0.02, 0.01, 0, -0.01]\n";
  for (const std::string& text : {gamma, gamma + bends, kGood + bends}) {
    const CameraModel camera = ParseCamera(text, "cam.toml");
    ASSERT_TRUE(camera.tone_curve);
    EXPECT_EQ(camera.tone_curve->is_bent(), text.find("bends") != std::string::npos);
    EXPECT_EQ(ParseCamera(FormatCamera(camera), "again.toml").tone_curve, camera.tone_curve);
  }
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "gamma = 7\n"), HasSubstr("camera.gamma = 7: must be from 0.2 to 5"));
  EXPECT_THAT(ErrorOfCamera(kGood + std::string("gamma_bends = [0, 0]\n")), HasSubstr("camera.gamma_bends"));
  EXPECT_THAT(ErrorOfCamera(kGood + std::string("gamma_bends = [0, 0, 0.2, 0, 0, 0, 0]\n")), HasSubstr("rising"));
}

TEST(CameraFile, ReadsAndWritesHowLongRowsTakeToBeRead) {
  EXPECT_EQ(ParseCamera(kGood, "cam.toml").rows_read_ms, 0);
  EXPECT_THAT(FormatCamera(ParseCamera(kGood, "cam.toml")), Not(HasSubstr("rows_read_ms")));
  const CameraModel camera = ParseCamera(std::string(kGood) + "rows_read_ms = 28.3\n", "cam.toml");
  EXPECT_EQ(camera.rows_read_ms, 28.3);
  EXPECT_EQ(ParseCamera(FormatCamera(camera), "again.toml").rows_read_ms, 28.3);
  for (const std::string number : {"-1", "1001", "nan"})
    EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "rows_read_ms = " + number + "\n"),
                HasSubstr("cam.toml:10: camera.rows_read_ms = " + number + ": must be from 0 to 1000"));
}

TEST(CameraFile, RefusesWhatNoCameraCanHave) {
  EXPECT_EQ(ErrorOfCamera(With("fx", "fx = -1")), "cam.toml:4: camera.fx = -1: must be from 0.1 to 1000000");
  EXPECT_EQ(ErrorOfCamera(With("width", "width = 0")), "cam.toml:2: camera.width = 0: must be from 1 to 16384");
  EXPECT_THAT(ErrorOfCamera(With("height", "height = 480.5")),
              HasSubstr("cam.toml:3: camera.height = 480.5: must be a whole"));
  EXPECT_THAT(ErrorOfCamera(With("cx", "cx = nan")), HasSubstr("cam.toml:6: camera.cx = nan: must be from"));
  EXPECT_THAT(ErrorOfCamera(With("cy", "cy = inf")), HasSubstr("cam.toml:7: camera.cy = inf: must be from"));
  EXPECT_EQ(ErrorOfCamera(With("model", "model = \"zoom\"")),
            "cam.toml:8: camera.model = 'zoom': must be \"brown_conrady\", \"fisheye\" or \"pinhole\"");
  EXPECT_THAT(ErrorOfCamera(With("distortion", "distortion = [1, 2, 3]")), HasSubstr("the 5 values k1 k2 p1 p2 k3"));
  EXPECT_THAT(ErrorOfCamera(With("distortion", "distortion = [1, 2, nan, 0]")),
              HasSubstr("value 3 (nan) must be from"));
  EXPECT_THAT(ErrorOfCamera(With("model", "model = \"fisheye\"")), HasSubstr("the 4 values k1 k2 k3 k4"));
  EXPECT_THAT(ErrorOfCamera(With("model", "model = \"pinhole\"")), HasSubstr("must be left out or 0"));
  EXPECT_THAT(ErrorOfCamera(With("distortion", "")), HasSubstr("camera.distortion: is missing"));
  EXPECT_THAT(ErrorOfCamera(With("fx", "")), HasSubstr("cam.toml:1: camera.fx: is missing"));
  EXPECT_THAT(ErrorOfCamera(""), HasSubstr("cam.toml: camera.width: is missing"));
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "focal = 3\n"), HasSubstr("cam.toml:10: camera.focal: unknown key"));
}

TEST(CameraFile, WhatIsWrittenReadsBackExactly) {
  const test::TemporaryDirectory folder;
  CameraModel camera = ParseCamera(kGood, "cam.toml");
  camera.fx = 540.1 / 3;
  for (const auto kind : {CameraModel::Kind::kBrownConrady, CameraModel::Kind::kFisheye, CameraModel::Kind::kPinhole}) {
    camera.kind = kind;
    camera.distortion = {1.0 / 3, 1e-17, -2, 4, 0};
    if (kind == CameraModel::Kind::kBrownConrady) camera.distortion[4] = 1.0 / 7;
    if (kind == CameraModel::Kind::kPinhole) camera.distortion = {};
    WriteCamera(folder / "camera.toml", camera);
    const CameraModel read = LoadCamera(folder / "camera.toml");
    EXPECT_EQ(read.kind, kind);
    EXPECT_EQ(read.width, 640);
    EXPECT_EQ(read.height, 480);
    EXPECT_EQ(read.fx, camera.fx);
    EXPECT_EQ(read.fy, camera.fy);
    EXPECT_EQ(read.cx, camera.cx);
    EXPECT_EQ(read.cy, camera.cy);
    EXPECT_EQ(read.distortion, camera.distortion);
  }
}

TEST(CameraFile, ANegativeZeroReadsBackAsWritten) {
  CameraModel camera = ParseCamera(kGood, "cam.toml");
  camera.kind = CameraModel::Kind::kBrownConrady;
  camera.distortion = {-0.0, 0.08, 0, 0, 0};
  const std::string once = FormatCamera(camera);
  EXPECT_EQ(FormatCamera(ParseCamera(once, "cam.toml")), once);
}

TEST(CameraFile, NamesAFileThatIsNotThere) {
  try {
    LoadCamera("/nowhere/camera.toml");
    FAIL() << "no error";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "/nowhere/camera.toml: cannot be opened: No such file or directory");
  }
}

TEST(CameraFile, SaysHowTheCalibrationCameAbout) {
  const test::TemporaryDirectory directory;
  const std::filesystem::path path = directory.path() / "camera.toml";
  CameraModel camera = ParseCamera(kGood, "cam.toml");
  WriteCamera(path, camera);
  EXPECT_FALSE(LoadCalibrationRecord(path).has_value());
  CalibrationRecord record{.date = "2024-05-01T12:00:00Z", .rms_px = 0.123, .views = 17};
  record.uncertainty = {0.1, 0.2, 0.3, 0.4, 0.001, 0.002, 0.003, 0.004, 0.005};
  WriteCamera(path, camera, &record);
  const auto back = LoadCalibrationRecord(path);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->date, record.date);
  EXPECT_EQ(back->rms_px, record.rms_px);
  EXPECT_EQ(back->views, record.views);
  EXPECT_EQ(back->uncertainty, record.uncertainty);
  EXPECT_EQ(LoadCamera(path).distortion, camera.distortion);
}

TEST(CameraFile, KeepsHowFarTheCalibrationMayBeOff) {
  for (const CameraModel::Kind kind :
       {CameraModel::Kind::kPinhole, CameraModel::Kind::kBrownConrady, CameraModel::Kind::kFisheye}) {
    CameraModel camera{.width = 640, .height = 480, .fx = 540, .fy = 540, .cx = 320, .cy = 240, .kind = kind};
    EXPECT_TRUE(ParseCamera(FormatCamera(camera), "cam.toml").covariance.isZero(0)) << "nothing is said of it";
    const int count = LensParameterCount(kind);
    const Eigen::MatrixXd root = Eigen::MatrixXd::Random(count, count);
    camera.covariance.topLeftCorner(count, count) = root * root.transpose();
    const CameraModel back = ParseCamera(FormatCamera(camera), "cam.toml");
    EXPECT_TRUE((back.covariance - camera.covariance).isZero(1e-15));
  }
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "covariance = [1, 2]\n"),
              ::testing::AllOf(HasSubstr("cam.toml:10"), HasSubstr("camera.covariance"), HasSubstr("45 values")));
  std::string negative = "covariance = [-1";
  for (int i = 1; i < 45; ++i) negative += ", 0";
  EXPECT_THAT(ErrorOfCamera(kGood + negative + "]\n"), HasSubstr("positive semidefinite"));
}

TEST(CameraFile, ChecksWhatIsSaidOfTheCalibration) {
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "uncertainty = [1, 2]\n"),
              ::testing::AllOf(HasSubstr("cam.toml:10"), HasSubstr("camera.uncertainty"), HasSubstr("9 values")));
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "rms = -1\n"), HasSubstr("camera.rms = -1"));
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "views = 0\n"), HasSubstr("camera.views = 0"));
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "date = 2024\n"), HasSubstr("camera.date"));
  EXPECT_THAT(ErrorOfCamera(std::string(kGood) + "date = 'a \"date\"'\n"), HasSubstr("must be a date"));
  EXPECT_EQ(ErrorOfCamera(std::string(kGood) + "date = \"yesterday\"\nrms = 0.1\n"), "no error");
}

}  // namespace
}  // namespace chequer
