#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "chequer/camera_model.h"

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// How a calibration came about.
struct CalibrationRecord {
  std::string date;   ///< UTC, ISO 8601
  double rms_px = 0;  ///< root mean square of the distances between corners as seen and as the model has them
  int views = 0;      ///< images it was made from
  /// Standard deviations of fx, fy, cx, cy (pixels) and, in their order, of the distortion coefficients.
  std::array<double, 9> uncertainty{};
};

/// A camera file: a TOML table [camera] with width, height, fx, fy, cx, cy, model ("pinhole", "brown_conrady" or
/// "fisheye") and distortion (brown_conrady: k1 k2 p1 p2 and, if wanted, k3; fisheye: k1 k2 k3 k4; pinhole: none).
/// It may have the curve of the camera's values, where that was measured: gamma (0.2 to 5; left out: sRGB) and
/// gamma_bends (ToneCurve::Bends, seven numbers). It may have the covariance of fx fy cx cy and the coefficients: its
/// lower triangle, row by row; and rows_read_ms (0 to 1000; CameraModel::rows_read_ms). It may also say how the
/// calibration came about: date, rms (pixels), views, and uncertainty (standard deviations of fx fy cx cy and of the
/// coefficients), which are checked and change nothing. Throws std::runtime_error naming file, line, key, value and
/// what would be right.
CameraModel LoadCamera(const std::filesystem::path& path);

/// The same from a text. @param name stands for the file in messages.
CameraModel ParseCamera(std::string_view text, const std::string& name);

/// What a camera file says of how its calibration came about; nothing where it does not say. Throws as LoadCamera.
std::optional<CalibrationRecord> LoadCalibrationRecord(const std::filesystem::path& path);

/// The text of a camera file; ParseCamera gives exactly the same numbers back.
std::string FormatCamera(const CameraModel& camera, const CalibrationRecord* record = nullptr);

/// Writes a camera file whole or not at all. Throws std::runtime_error naming the file and the cause.
void WriteCamera(const std::filesystem::path& path, const CameraModel& camera,
                 const CalibrationRecord* record = nullptr);

}  // namespace chequer

#pragma GCC visibility pop
