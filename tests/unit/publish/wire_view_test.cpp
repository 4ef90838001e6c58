#include "publish/wire_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "publish/wire.h"

namespace chequer {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

AskMessage SampleAsk() {
  AskMessage ask{.asker = -7,
                 .wants_camera = true,
                 .preview = AskMessage::Preview{{10, 20, 300, 200}, 320},
                 .detail = MarkerChoice{},
                 .wants_calibration = true};
  ask.detail->family = 2;
  ask.detail->id = ~std::uint64_t{0};
  ask.detail->center_px = {100.5, 50.25};
  return ask;
}

DetailMessage SampleDetail() {
  DetailMessage detail;
  detail.sequence = 9;
  detail.camera = "north";
  detail.asker = 5;
  detail.found = true;
  detail.id = 17;
  detail.size = {4, 3};
  detail.corners.assign(6, Eigen::Vector2f(1, 2));
  detail.corners[3].fill(kNone);
  detail.cells.resize(12);
  detail.cells[1] = {.outline_px = Zeros<Eigen::Vector2f, 4>(),
                     .luminance = 80,
                     .saturation = 30,
                     .saturated = true,
                     .expected = false,
                     .seen = true,
                     .log_likelihood = 4};
  detail.luminance_light = {70, 3};
  detail.saturation_overlap = 0.25;
  return detail;
}

CameraMessage SampleCamera() {
  CameraMessage camera{.utc = {},
                       .camera = "north",
                       .model = CameraModel{},
                       .world_from_camera = RigidTransform{},
                       .families = {{Variant::kGolay, {8, 8}, 0.2}}};
  camera.model->width = 640, camera.model->height = 480;
  camera.model->kind = CameraModel::Kind::kFisheye;
  camera.model->distortion = {0.1, 0.2, 0.3, 0.4, 0};
  camera.world_from_camera->translation = {1, 2, 3};
  return camera;
}

CalibrationMessage SampleCalibration() {
  CalibrationMessage calibration;
  calibration.camera = "north";
  calibration.state = CalibrationMessage::State::kSolving;
  calibration.advice = "hold it into the top left";
  calibration.width = 640, calibration.height = 480;
  calibration.frames = 9, calibration.views = 4, calibration.tilted = 2;
  calibration.edge_px = 1.5;
  calibration.rows = 2, calibration.cols = 3;
  calibration.parts = {0, 1, 2, 3, 4, 5};
  calibration.rms = 0.125;
  calibration.residuals = {{{10, 20}, {0.5, -0.25}}, {{30, 40}, {0, 1}}};
  calibration.references = {
      {.id = ~std::uint64_t{0}, .frames = 7, .center_px = {5, 6}, .offset_m = Eigen::Vector3f(1, 2, 3), .limit_m = 0.5},
      {.id = 3, .center_px = {0, 0}, .offset_m = {}}};
  return calibration;
}

template <typename Message>
Message RoundTrip(const Message& message) {
  const auto received = DecodeViewMessage(EncodeView(message));
  EXPECT_TRUE(received.has_value());
  return std::get<Message>(received.value());
}

TEST(WireView, CarriesARequest) {
  const AskMessage sent = SampleAsk(), got = RoundTrip(sent);
  EXPECT_EQ(got.asker, sent.asker);
  EXPECT_TRUE(got.wants_camera);
  EXPECT_TRUE(got.wants_calibration);
  EXPECT_EQ(got.preview->region, sent.preview->region);
  EXPECT_EQ(got.preview->width, 320);
  EXPECT_EQ(got.detail->family, 2);
  EXPECT_EQ(got.detail->id, sent.detail->id);
  EXPECT_EQ(got.detail->center_px, sent.detail->center_px);
  const AskMessage nothing = RoundTrip(AskMessage{});
  EXPECT_FALSE(nothing.wants_camera || nothing.preview || nothing.detail || nothing.wants_calibration);
}

TEST(WireView, CarriesAPicture) {
  const PreviewMessage sent{.captured_utc = UtcTime(std::chrono::microseconds(5)),
                            .sequence = 3,
                            .camera = "north",
                            .asker = 8,
                            .image_width = 100,
                            .image_height = 80,
                            .region = {2, 4, 50, 40},
                            .width = 25,
                            .height = 20,
                            .jpeg = {1, 2, 3}};
  const PreviewMessage got = RoundTrip(sent);
  EXPECT_EQ(got.captured_utc, sent.captured_utc);
  EXPECT_EQ(got.sequence, 3u);
  EXPECT_EQ(got.asker, 8);
  EXPECT_EQ(got.region, sent.region);
  EXPECT_EQ(got.image_width, 100);
  EXPECT_EQ(got.width, 25);
  EXPECT_EQ(got.jpeg, sent.jpeg);
}

TEST(WireView, CarriesADetail) {
  const DetailMessage got = RoundTrip(SampleDetail());
  EXPECT_EQ(got.id, 17u);
  EXPECT_EQ(got.size, (MarkerSize{4, 3}));
  ASSERT_EQ(got.corners.size(), 6u);
  EXPECT_TRUE(std::isnan(got.corners[3].x()));
  EXPECT_EQ(got.corners[4], Eigen::Vector2f(1, 2));
  EXPECT_EQ(got.cells[1].saturated, true);
  EXPECT_EQ(got.cells[1].expected, false);
  EXPECT_EQ(got.cells[0].saturated, std::nullopt);
  EXPECT_EQ(got.cells[1].luminance, 80);
  EXPECT_TRUE(std::isnan(got.cells[0].luminance)) << "not seen";
  EXPECT_EQ(got.luminance_light.mean, 70);
  EXPECT_EQ(got.saturation_overlap, 0.25);
}

TEST(WireView, CarriesACamera) {
  const CameraMessage got = RoundTrip(SampleCamera());
  EXPECT_EQ(got.model->kind, CameraModel::Kind::kFisheye);
  EXPECT_EQ(got.model->distortion, SampleCamera().model->distortion);
  EXPECT_EQ(got.world_from_camera->translation, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(got.families.size(), 1u);
  EXPECT_EQ(got.families[0].size, (MarkerSize{8, 8}));
  EXPECT_EQ(got.families[0].side_m, 0.2);
  CameraMessage bare = SampleCamera();
  bare.model.reset();
  bare.world_from_camera.reset();
  EXPECT_FALSE(RoundTrip(bare).model || RoundTrip(bare).world_from_camera);
}

TEST(WireView, CarriesACalibration) {
  const CalibrationMessage sent = SampleCalibration(), got = RoundTrip(sent);
  EXPECT_EQ(got.kind, CalibrationMessage::Kind::kLens);
  EXPECT_EQ(got.state, CalibrationMessage::State::kSolving);
  EXPECT_EQ(got.advice, sent.advice);
  EXPECT_EQ(got.parts, sent.parts);
  EXPECT_EQ(got.rms, 0.125);
  ASSERT_EQ(got.residuals.size(), 2u);
  EXPECT_EQ(got.residuals[0].pixel, Eigen::Vector2f(10, 20));
  EXPECT_EQ(got.residuals[1].error_px, Eigen::Vector2f(0, 1));
  ASSERT_EQ(got.references.size(), 2u);
  EXPECT_EQ(got.references[0].id, ~std::uint64_t{0});
  EXPECT_EQ(got.references[0].offset_m, Eigen::Vector3f(1, 2, 3));
  EXPECT_FALSE(got.references[1].offset_m);
}

TEST(WireView, RefusesACalibrationThatCannotBe) {
  const auto is_taken = [](auto change) {
    CalibrationMessage calibration = SampleCalibration();
    change(calibration);
    return DecodeViewMessage(EncodeView(calibration)).has_value();
  };
  EXPECT_TRUE(is_taken([](CalibrationMessage&) {}));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.parts.pop_back(); }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.parts[2] = -1; }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.rows = 1000, c.cols = 1, c.parts.assign(1000, 0); }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.rms = std::nan(""); }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.width = -1; }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.residuals[0].pixel.x() = kNone; }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.residuals.resize(kMostCalibrationResiduals + 1); }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.references[0].offset_m->x() = kNone; }));
  EXPECT_FALSE(is_taken([](CalibrationMessage& c) { c.references.resize(2000); }));
}

TEST(WireView, RefusesWhatCannotBe) {
  AskMessage ask = SampleAsk();
  ask.preview->width = 100'000;
  EXPECT_FALSE(DecodeViewMessage(EncodeView(ask)));
  ask = SampleAsk();
  ask.preview->region.x = -1;
  EXPECT_FALSE(DecodeViewMessage(EncodeView(ask)));
  ask = SampleAsk();
  ask.detail->center_px.x() = std::nan("");
  EXPECT_FALSE(DecodeViewMessage(EncodeView(ask)));
  DetailMessage detail = SampleDetail();
  detail.corners.pop_back();
  EXPECT_FALSE(DecodeViewMessage(EncodeView(detail))) << "fewer corners than a board of that size has";
  CameraMessage camera = SampleCamera();
  camera.model->fx = 0;
  EXPECT_FALSE(DecodeViewMessage(EncodeView(camera)));
  PreviewMessage whole;
  whole.image_width = whole.image_height = 4;
  whole.width = whole.height = 2;
  EXPECT_FALSE(DecodeViewMessage(EncodeView(whole))) << "a picture of no region";
}

TEST(WireView, RefusesWhatIsCutOffAndOtherTypes) {
  for (const auto& bytes : {EncodeView(SampleAsk()), EncodeView(SampleDetail()), EncodeView(SampleCamera()),
                            EncodeView(SampleCalibration())})
    for (std::size_t length = 0; length < bytes.size(); ++length)
      EXPECT_FALSE(DecodeViewMessage(std::span(bytes).first(length))) << length;
  WireEncoder encoder;
  const auto poses = encoder.Encode(PosesMessage{});
  EXPECT_FALSE(IsViewMessage(poses));
  EXPECT_FALSE(DecodeViewMessage(poses));
  EXPECT_TRUE(IsViewMessage(EncodeView(SampleCamera())));
  EXPECT_FALSE(DecodeMessage(EncodeView(SampleCamera()))) << "programs that know poses pass it over";
}

}  // namespace
}  // namespace chequer
