#include "publish/wire_view.h"

#include <algorithm>
#include <array>
#include <chequer/ask_t.hpp>
#include <chequer/calibration_t.hpp>
#include <chequer/camera_t.hpp>
#include <chequer/detail_t.hpp>
#include <chequer/preview_t.hpp>
#include <cmath>
#include <exception>
#include <limits>
#include <string_view>
#include <utility>

#include "chequer/check.h"
#include "chequer/image.h"
#include "publish/wire_header.h"
#include "publish/wire_values.h"

namespace chequer {
namespace {

namespace values = wire_values;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// A daemon has at most 64 families.
constexpr std::size_t kMostFamilies = 64;
/// Far more than a calibration has: parts of an image to a side, and references.
constexpr int kMostParts = 64;
constexpr std::size_t kMostReferences = 1000;

constexpr std::array<std::pair<CameraModel::Kind, std::string_view>, 3> kModelNames{
    {{CameraModel::Kind::kPinhole, "pinhole"},
     {CameraModel::Kind::kBrownConrady, "brown_conrady"},
     {CameraModel::Kind::kFisheye, "fisheye"}}};

bool IsSide(int pixels) { return pixels >= 1 && pixels <= kMaxImageSide; }

bool IsInRange(const PixelRegion& region) {
  const auto is_place = [](int pixel) { return pixel >= 0 && pixel <= kMaxImageSide; };
  return is_place(region.x) && is_place(region.y) && is_place(region.width) && is_place(region.height);
}

void WriteRegion(const PixelRegion& region, std::int32_t* wire) {
  const int numbers[] = {region.x, region.y, region.width, region.height};
  std::copy(std::begin(numbers), std::end(numbers), wire);
}
PixelRegion ReadRegion(const std::int32_t* wire) { return {wire[0], wire[1], wire[2], wire[3]}; }

bool IsFinite(const Eigen::Vector2d& point) { return std::isfinite(point.x()) && std::isfinite(point.y()); }

void WritePoint(const Eigen::Vector2d& point, float* wire) {
  for (int i = 0; i < 2; ++i) wire[i] = static_cast<float>(point(i));
}
Eigen::Vector2d ReadPoint(const float* wire) { return {static_cast<double>(wire[0]), static_cast<double>(wire[1])}; }

std::int8_t WriteJudgement(std::optional<bool> judged) {
  return static_cast<std::int8_t>(judged ? (*judged ? 1 : 0) : -1);
}
std::optional<bool> ReadJudgement(std::int8_t wire) { return wire < 0 ? std::nullopt : std::optional(wire != 0); }

void WriteSummary(const NormalSummary& summary, float* wire) {
  wire[0] = static_cast<float>(summary.mean);
  wire[1] = static_cast<float>(summary.deviation);
}
NormalSummary ReadSummary(const float* wire) { return {static_cast<double>(wire[0]), static_cast<double>(wire[1])}; }

ask_t Write(const AskMessage& message) {
  ask_t wire{};
  wire.asker = message.asker;
  if (message.wants_camera) wire.wants |= ask_t::WANT_CAMERA;
  if (message.preview) {
    wire.wants |= ask_t::WANT_PREVIEW;
    WriteRegion(message.preview->region, wire.region_px);
    wire.preview_width = message.preview->width;
  }
  if (message.detail) {
    wire.wants |= ask_t::WANT_DETAIL;
    wire.family = static_cast<std::int16_t>(message.detail->family);
    wire.id = values::Signed(message.detail->id.value_or(0));
    wire.id_valid = message.detail->id.has_value();
    WritePoint(message.detail->center_px, wire.center_px);
  }
  if (message.wants_calibration) wire.wants |= ask_t::WANT_CALIBRATION;
  return wire;
}

std::optional<ViewMessage> Read(const ask_t& wire) {
  AskMessage message{.asker = wire.asker,
                     .wants_camera = (wire.wants & ask_t::WANT_CAMERA) != 0,
                     .preview = {},
                     .detail = {},
                     .wants_calibration = (wire.wants & ask_t::WANT_CALIBRATION) != 0};
  if ((wire.wants & ask_t::WANT_PREVIEW) != 0) {
    message.preview = AskMessage::Preview{ReadRegion(wire.region_px), wire.preview_width};
    if (!IsInRange(message.preview->region) || wire.preview_width < kLeastPreviewWidth ||
        wire.preview_width > kMostPreviewWidth)
      return std::nullopt;
  }
  if ((wire.wants & ask_t::WANT_DETAIL) != 0) {
    message.detail.emplace();
    message.detail->family = wire.family;
    if (wire.id_valid != 0) message.detail->id = values::Unsigned(wire.id);
    message.detail->center_px = ReadPoint(wire.center_px);
    if (wire.family < 0 || !IsFinite(message.detail->center_px)) return std::nullopt;
  }
  return message;
}

preview_t Write(const PreviewMessage& message) {
  preview_t wire{};
  wire.capture_utc_us = values::Microseconds(message.captured_utc);
  wire.sequence = values::Signed(message.sequence);
  wire.camera = message.camera;
  wire.asker = message.asker;
  wire.image_width = message.image_width;
  wire.image_height = message.image_height;
  WriteRegion(message.region, wire.region_px);
  wire.preview_width = message.width;
  wire.preview_height = message.height;
  wire.jpeg_bytes = static_cast<std::int32_t>(message.jpeg.size());
  wire.jpeg = message.jpeg;
  return wire;
}

std::optional<ViewMessage> Read(const preview_t& wire) {
  PreviewMessage message;
  message.captured_utc = values::FromMicroseconds<UtcTime>(wire.capture_utc_us);
  message.sequence = values::Unsigned(wire.sequence);
  message.camera = wire.camera;
  message.asker = wire.asker;
  message.image_width = wire.image_width;
  message.image_height = wire.image_height;
  message.region = ReadRegion(wire.region_px);
  message.width = wire.preview_width;
  message.height = wire.preview_height;
  message.jpeg = wire.jpeg;
  if (!values::IsText(wire.camera) || !IsSide(message.image_width) || !IsSide(message.image_height) ||
      !IsInRange(message.region) || message.region.IsWhole() || !IsSide(message.width) || !IsSide(message.height))
    return std::nullopt;
  return message;
}

detail_cell_t Write(const DetailCell& cell) {
  detail_cell_t wire{};
  for (std::size_t i = 0; i < 4; ++i)
    for (int axis = 0; axis < 2; ++axis)
      wire.outline_px[2 * i + static_cast<std::size_t>(axis)] = cell.outline_px[i](axis);
  wire.luminance = cell.seen ? cell.luminance : kUnknown;
  wire.saturation = cell.seen ? cell.saturation : kUnknown;
  wire.saturated = WriteJudgement(cell.saturated);
  wire.expected = WriteJudgement(cell.expected);
  wire.seen = cell.seen;
  wire.log_likelihood = cell.log_likelihood;
  return wire;
}

DetailCell Read(const detail_cell_t& wire) {
  DetailCell cell;
  for (std::size_t i = 0; i < 4; ++i) cell.outline_px[i] = {wire.outline_px[2 * i], wire.outline_px[2 * i + 1]};
  cell.luminance = wire.luminance;
  cell.saturation = wire.saturation;
  cell.saturated = ReadJudgement(wire.saturated);
  cell.expected = ReadJudgement(wire.expected);
  cell.seen = wire.seen != 0;
  cell.log_likelihood = wire.log_likelihood;
  return cell;
}

detail_t Write(const DetailMessage& message) {
  detail_t wire{};
  wire.capture_utc_us = values::Microseconds(message.captured_utc);
  wire.sequence = values::Signed(message.sequence);
  wire.camera = message.camera;
  wire.asker = message.asker;
  wire.found = message.found;
  wire.message = message.message;
  wire.family = static_cast<std::int16_t>(message.family);
  wire.id = values::Signed(message.id.value_or(0));
  wire.id_valid = message.id.has_value();
  wire.variant = values::WireEnum(message.variant);
  wire.rows = static_cast<std::int8_t>(message.size.rows);
  wire.cols = static_cast<std::int8_t>(message.size.cols);
  WritePoint(message.center_px, wire.center_px);
  wire.bits_corrected = static_cast<std::int16_t>(message.bits_corrected);
  wire.reprojection_rms_px = static_cast<float>(message.reprojection_rms_px);
  wire.warnings = static_cast<std::int32_t>(message.warnings);
  for (const Eigen::Vector2f& corner : message.corners)
    wire.corners_px.insert(wire.corners_px.end(), {corner.x(), corner.y()});
  wire.corner_values = static_cast<std::int32_t>(wire.corners_px.size());
  for (const DetailCell& cell : message.cells) wire.cells.push_back(Write(cell));
  wire.cell_count = static_cast<std::int32_t>(wire.cells.size());
  WriteSummary(message.luminance_dark, wire.luminance_dark);
  WriteSummary(message.luminance_light, wire.luminance_light);
  WriteSummary(message.saturation_plain, wire.saturation_plain);
  WriteSummary(message.saturation_saturated, wire.saturation_saturated);
  wire.luminance_overlap = static_cast<float>(message.luminance_overlap);
  wire.saturation_overlap = static_cast<float>(message.saturation_overlap);
  return wire;
}

std::optional<ViewMessage> Read(const detail_t& wire) {
  DetailMessage message;
  message.captured_utc = values::FromMicroseconds<UtcTime>(wire.capture_utc_us);
  message.sequence = values::Unsigned(wire.sequence);
  message.camera = wire.camera;
  message.asker = wire.asker;
  message.found = wire.found != 0;
  message.message = wire.message;
  message.family = wire.family;
  if (wire.id_valid != 0) message.id = values::Unsigned(wire.id);
  message.variant = values::ReadEnum<Variant>(wire.variant);
  message.size = {wire.rows, wire.cols};
  message.center_px = ReadPoint(wire.center_px);
  message.bits_corrected = wire.bits_corrected;
  message.reprojection_rms_px = static_cast<double>(wire.reprojection_rms_px);
  message.warnings = static_cast<std::uint32_t>(wire.warnings);
  for (std::size_t i = 0; i + 1 < wire.corners_px.size(); i += 2)
    message.corners.emplace_back(wire.corners_px[i], wire.corners_px[i + 1]);
  for (const detail_cell_t& cell : wire.cells) message.cells.push_back(Read(cell));
  message.luminance_dark = ReadSummary(wire.luminance_dark);
  message.luminance_light = ReadSummary(wire.luminance_light);
  message.saturation_plain = ReadSummary(wire.saturation_plain);
  message.saturation_saturated = ReadSummary(wire.saturation_saturated);
  message.luminance_overlap = static_cast<double>(wire.luminance_overlap);
  message.saturation_overlap = static_cast<double>(wire.saturation_overlap);
  if (!values::IsText(wire.camera) || !values::IsText(wire.message) || wire.family < 0) return std::nullopt;
  if (!message.found) return message;
  const MarkerSize size = message.size;
  const bool fits = IsValid(size) && message.corners.size() == static_cast<std::size_t>(CornerCount(size)) &&
                    (message.cells.empty() || message.cells.size() == static_cast<std::size_t>(size.rows * size.cols));
  return fits ? std::optional<ViewMessage>(message) : std::nullopt;
}

camera_t Write(const CameraMessage& message) {
  camera_t wire{};
  wire.utc_us = values::Microseconds(message.utc);
  wire.camera = message.camera;
  wire.calibrated = message.model.has_value();
  const CameraModel model = message.model.value_or(CameraModel{});
  wire.width = model.width;
  wire.height = model.height;
  for (const auto& [kind, name] : kModelNames)
    if (kind == model.kind) wire.model = name;
  wire.fx = model.fx, wire.fy = model.fy, wire.cx = model.cx, wire.cy = model.cy;
  std::copy(model.distortion.begin(), model.distortion.end(), wire.distortion);
  wire.world_valid = message.world_from_camera.has_value();
  const RigidTransform pose = message.world_from_camera.value_or(RigidTransform{});
  values::WriteVector(pose.translation, wire.position);
  values::WriteRotation(pose.rotation, wire.orientation);
  for (const CameraMessage::Family& family : message.families) {
    camera_family_t each{};
    each.variant = values::WireEnum(family.variant);
    each.rows = static_cast<std::int8_t>(family.size.rows);
    each.cols = static_cast<std::int8_t>(family.size.cols);
    each.side = family.side_m;
    wire.families.push_back(each);
  }
  wire.family_count = static_cast<std::int32_t>(wire.families.size());
  return wire;
}

/// Nothing where the numbers describe no lens.
std::optional<CameraModel> ReadModel(const camera_t& wire) {
  CameraModel model;
  model.width = wire.width, model.height = wire.height;
  model.fx = wire.fx, model.fy = wire.fy, model.cx = wire.cx, model.cy = wire.cy;
  std::copy(std::begin(wire.distortion), std::end(wire.distortion), model.distortion.begin());
  const auto named =
      std::find_if(kModelNames.begin(), kModelNames.end(), [&](const auto& each) { return each.second == wire.model; });
  const bool numbers =
      std::all_of(model.distortion.begin(), model.distortion.end(), [](double k) { return std::isfinite(k); }) &&
      std::isfinite(model.cx) && std::isfinite(model.cy) && model.fx > 0 && model.fy > 0 && std::isfinite(model.fx) &&
      std::isfinite(model.fy);
  if (named == kModelNames.end() || !numbers || !IsSide(model.width) || !IsSide(model.height)) return std::nullopt;
  model.kind = named->first;
  return model;
}

std::optional<ViewMessage> Read(const camera_t& wire) {
  CameraMessage message;
  message.utc = values::FromMicroseconds<UtcTime>(wire.utc_us);
  message.camera = wire.camera;
  if (!values::IsText(wire.camera) || wire.families.size() > kMostFamilies) return std::nullopt;
  if (wire.calibrated != 0 && !(message.model = ReadModel(wire))) return std::nullopt;
  if (wire.world_valid != 0) {
    const RigidTransform pose{values::ReadRotation(wire.orientation), values::ReadVector(wire.position)};
    if (!pose.translation.allFinite() || std::abs(pose.rotation.norm() - 1) > 1e-6) return std::nullopt;
    message.world_from_camera = pose;
  }
  for (const camera_family_t& each : wire.families) {
    const MarkerSize size{each.rows, each.cols};
    if (!IsValid(size) || !(each.side >= 0 && each.side < 1000)) return std::nullopt;
    message.families.push_back({values::ReadEnum<Variant>(each.variant), size, each.side});
  }
  return message;
}

calibration_reference_t Write(const CalibrationMessage::Reference& reference) {
  calibration_reference_t wire{};
  wire.id = values::Signed(reference.id);
  wire.frames = reference.frames;
  const Eigen::Vector3f offset = reference.offset_m.value_or(Eigen::Vector3f::Zero());
  for (int axis = 0; axis < 2; ++axis) wire.center_px[axis] = reference.center_px(axis);
  for (int axis = 0; axis < 3; ++axis) wire.offset_m[axis] = offset(axis);
  wire.fitted = reference.offset_m.has_value();
  wire.limit_m = static_cast<float>(reference.limit_m);
  return wire;
}

calibration_t Write(const CalibrationMessage& message) {
  calibration_t wire{};
  wire.utc_us = values::Microseconds(message.utc);
  wire.camera = message.camera;
  wire.kind = values::WireEnum(message.kind);
  wire.state = values::WireEnum(message.state);
  wire.advice = message.advice;
  wire.width = message.width;
  wire.height = message.height;
  wire.frames = message.frames;
  wire.views = message.views;
  wire.tilted = message.tilted;
  wire.edge_px = static_cast<float>(message.edge_px);
  wire.rows = static_cast<std::int16_t>(message.rows);
  wire.cols = static_cast<std::int16_t>(message.cols);
  for (const int views : message.parts) wire.parts.push_back(static_cast<std::int16_t>(std::min(views, INT16_MAX)));
  wire.part_count = static_cast<std::int32_t>(wire.parts.size());
  wire.rms = message.rms;
  for (const CalibrationMessage::Residual& each : message.residuals)
    wire.residuals.insert(wire.residuals.end(), {each.pixel.x(), each.pixel.y(), each.error_px.x(), each.error_px.y()});
  wire.residual_values = static_cast<std::int32_t>(wire.residuals.size());
  for (const CalibrationMessage::Reference& each : message.references) wire.references.push_back(Write(each));
  wire.reference_count = static_cast<std::int32_t>(wire.references.size());
  return wire;
}

bool IsSound(const calibration_t& wire) {
  const auto is_number = [](float value) { return std::isfinite(value); };
  const auto is_share = [](std::int16_t parts) { return parts >= 0 && parts <= kMostParts; };
  const auto is_length = [](int pixels) { return pixels >= 0 && pixels <= kMaxImageSide; };
  return values::IsText(wire.camera) && values::IsText(wire.advice) && is_length(wire.width) &&
         is_length(wire.height) && std::min({wire.frames, wire.views, wire.tilted}) >= 0 && is_share(wire.rows) &&
         is_share(wire.cols) && wire.parts.size() == static_cast<std::size_t>(wire.rows * wire.cols) &&
         std::all_of(wire.parts.begin(), wire.parts.end(), [](std::int16_t views) { return views >= 0; }) &&
         std::isfinite(wire.rms) && wire.rms >= 0 && is_number(wire.edge_px) && wire.residuals.size() % 4 == 0 &&
         wire.residuals.size() <= 4 * kMostCalibrationResiduals &&
         std::all_of(wire.residuals.begin(), wire.residuals.end(), is_number) &&
         wire.references.size() <= kMostReferences;
}

std::optional<CalibrationMessage::Reference> Read(const calibration_reference_t& wire) {
  CalibrationMessage::Reference reference;
  reference.id = values::Unsigned(wire.id);
  reference.frames = wire.frames;
  reference.center_px = {wire.center_px[0], wire.center_px[1]};
  const Eigen::Vector3f offset{wire.offset_m[0], wire.offset_m[1], wire.offset_m[2]};
  if (wire.fitted != 0) reference.offset_m = offset;
  reference.limit_m = static_cast<double>(wire.limit_m);
  const bool sound = wire.frames >= 0 && reference.center_px.allFinite() && offset.allFinite() &&
                     std::isfinite(wire.limit_m) && wire.limit_m >= 0;
  return sound ? std::optional(reference) : std::nullopt;
}

std::optional<ViewMessage> Read(const calibration_t& wire) {
  if (!IsSound(wire)) return std::nullopt;
  CalibrationMessage message;
  message.utc = values::FromMicroseconds<UtcTime>(wire.utc_us);
  message.camera = wire.camera;
  message.kind = values::ReadEnum<CalibrationMessage::Kind>(wire.kind);
  message.state = values::ReadEnum<CalibrationMessage::State>(wire.state);
  message.advice = wire.advice;
  message.width = wire.width;
  message.height = wire.height;
  message.frames = wire.frames;
  message.views = wire.views;
  message.tilted = wire.tilted;
  message.edge_px = static_cast<double>(wire.edge_px);
  message.rows = wire.rows;
  message.cols = wire.cols;
  message.parts.assign(wire.parts.begin(), wire.parts.end());
  message.rms = wire.rms;
  for (std::size_t i = 0; i < wire.residuals.size(); i += 4) {
    const float* at = wire.residuals.data() + i;
    message.residuals.push_back({{at[0], at[1]}, {at[2], at[3]}});
  }
  for (const calibration_reference_t& each : wire.references) {
    const auto reference = Read(each);
    if (!reference) return std::nullopt;
    message.references.push_back(*reference);
  }
  return message;
}

template <typename Wire>
std::vector<std::uint8_t> EncodeWire(const Wire& wire) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(wire.getEncodedSize()));
  const int written = wire.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  CHEQUER_CHECK(written == static_cast<int>(bytes.size()), "an LCM type was not encoded into the size it asked for");
  return bytes;
}

template <typename Wire>
std::optional<ViewMessage> DecodeViewAs(std::span<const std::uint8_t> bytes) {
  Wire wire{};
  if (wire.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) return std::nullopt;
  return Read(wire);
}

std::int64_t FingerprintOf(std::span<const std::uint8_t> bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value = value << 8 | bytes[i];
  return static_cast<std::int64_t>(value);
}

}  // namespace

std::vector<std::uint8_t> EncodeView(const AskMessage& message) { return EncodeWire(Write(message)); }
std::vector<std::uint8_t> EncodeView(const PreviewMessage& message) { return EncodeWire(Write(message)); }
std::vector<std::uint8_t> EncodeView(const DetailMessage& message) { return EncodeWire(Write(message)); }
std::vector<std::uint8_t> EncodeView(const CameraMessage& message) { return EncodeWire(Write(message)); }
std::vector<std::uint8_t> EncodeView(const CalibrationMessage& message) { return EncodeWire(Write(message)); }

bool IsViewMessage(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 8) return false;
  const std::int64_t fingerprint = FingerprintOf(bytes);
  return fingerprint == ask_t::getHash() || fingerprint == preview_t::getHash() || fingerprint == detail_t::getHash() ||
         fingerprint == camera_t::getHash() || fingerprint == calibration_t::getHash();
}

std::optional<ViewMessage> DecodeViewMessage(std::span<const std::uint8_t> bytes) {
  if (!IsViewMessage(bytes) || bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    return std::nullopt;
  const std::int64_t fingerprint = FingerprintOf(bytes);
  try {
    if (fingerprint == ask_t::getHash()) return DecodeViewAs<ask_t>(bytes);
    if (fingerprint == preview_t::getHash()) return DecodeViewAs<preview_t>(bytes);
    if (fingerprint == detail_t::getHash()) return DecodeViewAs<detail_t>(bytes);
    if (fingerprint == camera_t::getHash()) return DecodeViewAs<camera_t>(bytes);
    return DecodeViewAs<calibration_t>(bytes);
  } catch (const std::exception&) {
    return std::nullopt;  // more elements than memory holds
  }
}

}  // namespace chequer
