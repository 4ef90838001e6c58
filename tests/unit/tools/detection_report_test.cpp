#include "tools/detection_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace chequer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

MarkerPose SomeMarker() {
  MarkerPose marker;
  marker.id = 17;
  marker.size = {6, 6};
  marker.has_pose = true;
  marker.camera_from_marker.translation = {0.1, 1.0 / 3, 0.9};
  marker.camera_from_marker.rotation = Eigen::Quaterniond(-0.5, 0.5, -0.5, 0.5);
  for (std::size_t i = 0; i < marker.corners.size(); ++i)
    marker.corners[i] = {static_cast<float>(i) + 0.5f, static_cast<float>(i) * 2};
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col < 6; ++col) marker.covariance(row, col) = 10 * std::min(row, col) + std::max(row, col);
  marker.corners_used = 25;
  return marker;
}

nlohmann::json ParsedLine(const MarkerPose& marker) {
  const std::vector<MarkerPose> markers{marker};
  const std::string line = JsonLine({"dir/a.png", 640, 480, 0.41, 0, markers});
  EXPECT_EQ(line.find('\n'), std::string::npos);
  return nlohmann::json::parse(line);
}

TEST(JsonLine, SaysEverythingOfAMarkerWithItsPose) {
  const auto json = ParsedLine(SomeMarker());
  EXPECT_EQ(json["file"], "dir/a.png");
  EXPECT_EQ(json["width"], 640);
  EXPECT_EQ(json["height"], 480);
  EXPECT_EQ(json["detect_ms"], 0.41);
  ASSERT_EQ(json["markers"].size(), 1u);
  const auto& marker = json["markers"][0];
  EXPECT_EQ(marker["id"], 17);
  EXPECT_EQ(marker["variant"], "secded");
  EXPECT_EQ(marker["position"], nlohmann::json({0.1, 1.0 / 3, 0.9}));
  EXPECT_EQ(marker["corners"].size(), 25u);
  EXPECT_EQ(marker["corners"][2], nlohmann::json({2.5, 4.0}));
  EXPECT_EQ(marker["corners_used"], 25);
  EXPECT_EQ(marker["warnings"], nlohmann::json::array());
  for (const char* key :
       {"reprojection_rms_px", "ambiguity", "luminance_overlap", "saturation_overlap", "bits_corrected"})
    EXPECT_TRUE(marker[key].is_number()) << key;
}

TEST(JsonLine, KeepsTheOrderOfKeysAndEndsInTheMarkers) {
  const std::string line = JsonLine({"a.png", 640, 480, 0.5, 7, {}});
  EXPECT_EQ(line, R"({"file":"a.png","width":640,"height":480,"detect_ms":0.5,"work":7,"markers":[]})");
}

TEST(JsonLine, WritesQuaternionsWithPositiveW) {
  EXPECT_EQ(ParsedLine(SomeMarker())["markers"][0]["orientation"], nlohmann::json({0.5, -0.5, 0.5, -0.5}));
}

TEST(JsonLine, WritesTheCovarianceAsUpperTriangleByRows) {
  EXPECT_EQ(ParsedLine(SomeMarker())["markers"][0]["covariance"],
            nlohmann::json({0, 1, 2, 3, 4, 5, 11, 12, 13, 14, 15, 22, 23, 24, 25, 33, 34, 35, 44, 45, 55}));
}

TEST(JsonLine, LeavesThePoseOutWhereThereIsNone) {
  MarkerPose marker = SomeMarker();
  marker.has_pose = false;
  const auto json = ParsedLine(marker)["markers"][0];
  for (const char* key : {"position", "orientation", "covariance", "ambiguity"})
    EXPECT_FALSE(json.contains(key)) << key;
  EXPECT_TRUE(json.contains("reprojection_rms_px"));
}

TEST(JsonLine, WritesIdsOf64BitsAsIntegers) {
  MarkerPose marker = SomeMarker();
  marker.id = UINT64_MAX;
  const std::vector<MarkerPose> markers{marker};
  EXPECT_THAT(JsonLine({"a.png", 1, 1, 0, 0, markers}), HasSubstr(R"("id":18446744073709551615,)"));
}

TEST(JsonLine, WritesNullForUndecidedIdsWithTheWarnings) {
  MarkerPose marker = SomeMarker();
  marker.id.reset();
  marker.warnings =
      static_cast<std::uint32_t>(Warning::kIdUndecided) | static_cast<std::uint32_t>(Warning::kPartlyHidden);
  const auto json = ParsedLine(marker)["markers"][0];
  EXPECT_TRUE(json["id"].is_null());
  EXPECT_THAT(json["warnings"], ElementsAre("id_undecided", "partly_hidden"));
}

TEST(JsonLine, WritesNullForCornersNotSeenAndNeverNan) {
  MarkerPose marker = SomeMarker();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  marker.corners[3] = {nan, nan};
  marker.reprojection_rms_px = std::nan("");
  marker.luminance_overlap = std::numeric_limits<double>::infinity();
  const auto json = ParsedLine(marker)["markers"][0];
  EXPECT_TRUE(json["corners"][3].is_null());
  EXPECT_FALSE(json["corners"][4].is_null());
  EXPECT_TRUE(json["reprojection_rms_px"].is_null());
  EXPECT_TRUE(json["luminance_overlap"].is_null());
}

TEST(JsonLine, EscapesFileNames) {
  const std::string line = JsonLine({"a\"b\n\xff.png", 1, 1, 0, 0, {}});
  EXPECT_EQ(nlohmann::json::parse(line)["file"], "a\"b\n\xEF\xBF\xBD.png");
}

TEST(Table, NamesPositionIdAndWarnings) {
  MarkerPose marker = SomeMarker();
  marker.warnings = static_cast<std::uint32_t>(Warning::kPoorIllumination);
  const std::vector<MarkerPose> markers{marker};
  const std::string table = Table({"a.png", 640, 480, 0.414, 0, markers});
  EXPECT_THAT(table, HasSubstr("a.png: 640x480, 1 marker, 0.41 ms\n"));
  EXPECT_THAT(table, HasSubstr("(0.1000, 0.3333, 0.9000) m"));
  EXPECT_THAT(table, HasSubstr("25/25"));
  EXPECT_THAT(table, HasSubstr("poor_illumination"));
}

TEST(Table, FallsBackToPixelsAndDashes) {
  MarkerPose marker = SomeMarker();
  marker.has_pose = false;
  marker.id.reset();
  marker.center_px = {100.25, 50};
  const std::vector<MarkerPose> markers{marker};
  const std::string table = Table({"a.png", 640, 480, 0, 0, markers});
  EXPECT_THAT(table, HasSubstr("(100.25, 50.00) px"));
  EXPECT_THAT(table, HasSubstr("  -  secded"));
  EXPECT_THAT(Table({"a.png", 640, 480, 0, 0, {}}), Not(HasSubstr("variant")));
}

}  // namespace
}  // namespace chequer
