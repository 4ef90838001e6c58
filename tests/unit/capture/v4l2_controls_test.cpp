#include "capture/v4l2_controls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "support/error_of.h"

namespace chequer {
namespace {

using ::testing::HasSubstr;

V4l2Control Integer(const std::string& name) {
  V4l2Control control;
  control.name = name;
  control.kind = V4l2ControlKind::kInteger;
  control.min = -10;
  control.max = 100;
  return control;
}

V4l2Control Menu(const std::string& name) {
  V4l2Control control;
  control.name = name;
  control.kind = V4l2ControlKind::kMenu;
  control.max = 3;
  control.menu = {{0, "Disabled"}, {1, "50 Hz"}, {3, "Auto"}};
  return control;
}

CameraSetting Setting(const std::string& name, CameraSetting::Value value) {
  return {name, std::move(value), "swarm.toml:7: capture.controls." + name};
}

std::string Refusal(const V4l2Control& control, CameraSetting::Value value) {
  return test::ErrorOf([&] { ResolveControl(control, Setting(control.name, std::move(value))); });
}

std::int64_t Number(const V4l2Control& control, CameraSetting::Value value) {
  return std::get<std::int64_t>(ResolveControl(control, Setting(control.name, std::move(value))));
}

TEST(ControlName, IsTheOneOfTheCommandLineTool) {
  EXPECT_EQ(ControlName("White Balance Temperature, Auto"), "white_balance_temperature_auto");
  EXPECT_EQ(ControlName("Exposure (Absolute)"), "exposure_absolute");
  EXPECT_EQ(ControlName("Gain"), "gain");
  EXPECT_EQ(ControlName(""), "");
}

TEST(ResolveControl, TakesNumbersInTheRange) {
  EXPECT_EQ(Number(Integer("gain"), std::int64_t{-10}), -10);
  EXPECT_EQ(Number(Integer("gain"), std::int64_t{100}), 100);
  EXPECT_EQ(Refusal(Integer("gain"), std::int64_t{101}),
            "swarm.toml:7: capture.controls.gain: must be from -10 to 100");
  EXPECT_THAT(Refusal(Integer("gain"), 1.5), HasSubstr("must be from -10 to 100"));
  EXPECT_THAT(Refusal(Integer("gain"), std::string("high")), HasSubstr("must be from -10 to 100"));
  EXPECT_THAT(Refusal(Integer("gain"), true), HasSubstr("must be from -10 to 100"));
}

TEST(ResolveControl, TakesLinesOfAMenuByNumberAndByText) {
  EXPECT_EQ(Number(Menu("power_line_frequency"), std::int64_t{1}), 1);
  EXPECT_EQ(Number(Menu("power_line_frequency"), std::string("50 hz")), 1);
  EXPECT_EQ(Number(Menu("power_line_frequency"), std::string("Auto")), 3);
  EXPECT_THAT(Refusal(Menu("power_line_frequency"), std::int64_t{2}),
              HasSubstr("must be 0 (Disabled), 1 (50 Hz) or 3 (Auto)"));
  EXPECT_THAT(Refusal(Menu("power_line_frequency"), std::string("60 Hz")), HasSubstr("must be 0 (Disabled)"));
}

TEST(ResolveControl, TakesTruthValues) {
  V4l2Control control = Integer("auto");
  control.kind = V4l2ControlKind::kBoolean;
  EXPECT_EQ(Number(control, true), 1);
  EXPECT_EQ(Number(control, std::int64_t{0}), 0);
  EXPECT_THAT(Refusal(control, std::int64_t{2}), HasSubstr("must be true or false"));
}

TEST(ResolveControl, TakesTextsOfTheRightLength) {
  V4l2Control control = Integer("owner");
  control.kind = V4l2ControlKind::kString;
  control.min = 1;
  control.max = 5;
  EXPECT_EQ(std::get<std::string>(ResolveControl(control, Setting("owner", std::string("me")))), "me");
  EXPECT_THAT(Refusal(control, std::string("nobody")), HasSubstr("a text of 1 to 5 characters"));
  EXPECT_THAT(Refusal(control, std::int64_t{3}), HasSubstr("a text of 1 to 5 characters"));
}

TEST(ResolveControl, RefusesWhatCannotBeSet) {
  V4l2Control control = Integer("temperature");
  control.is_read_only = true;
  EXPECT_THAT(Refusal(control, std::int64_t{3}), HasSubstr("can only be read"));
  control.is_read_only = false;
  control.kind = V4l2ControlKind::kOther;
  EXPECT_THAT(Refusal(control, std::int64_t{3}), HasSubstr("cannot be set"));
}

TEST(FindControl, NamesThoseThatExist) {
  const std::vector<V4l2Control> controls{Integer("gain"), Menu("power_line_frequency")};
  EXPECT_EQ(&FindControl(controls, Setting("gain", true)), &controls.front());
  EXPECT_THAT(test::ErrorOf([&] { FindControl(controls, Setting("gian", true)); }),
              HasSubstr("capture.controls.gian: the camera has no such control; it has gain, power_line_frequency"));
}

TEST(InOrderOfSetting, PutsAutomaticsBeforeWhatTheyGovern) {
  const std::vector<V4l2Control> controls{Integer("exposure_absolute"), Menu("exposure_auto"), Integer("gain")};
  const auto ordered =
      InOrderOfSetting(controls, {Setting("gain", std::int64_t{1}), Setting("exposure_absolute", std::int64_t{9}),
                                  Setting("exposure_auto", std::int64_t{1})});
  ASSERT_EQ(ordered.size(), 3u);
  EXPECT_EQ(ordered[0].name, "exposure_auto");
  EXPECT_EQ(ordered[1].name, "gain");
}

TEST(ControlValueText, SaysWhatANumberMeans) {
  EXPECT_EQ(ControlValueText(Menu("m"), std::int64_t{3}), "3 (Auto)");
  EXPECT_EQ(ControlValueText(Integer("i"), std::int64_t{3}), "3");
  EXPECT_EQ(ControlValueText(Integer("i"), std::string("x")), "x");
}

}  // namespace
}  // namespace chequer
