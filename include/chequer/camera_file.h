#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "chequer/camera_model.h"

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// A camera file: a TOML table [camera] with width, height, fx, fy, cx, cy, model ("pinhole", "brown_conrady" or
/// "fisheye") and distortion (brown_conrady: k1 k2 p1 p2 and, if wanted, k3; fisheye: k1 k2 k3 k4; pinhole: none).
/// Throws std::runtime_error naming file, line, key, value and what would be right.
CameraModel LoadCamera(const std::filesystem::path& path);

/// The same from a text. @param name stands for the file in messages.
CameraModel ParseCamera(std::string_view text, const std::string& name);

/// The text of a camera file; ParseCamera gives exactly the same numbers back.
std::string FormatCamera(const CameraModel& camera);

/// Writes a camera file whole or not at all. Throws std::runtime_error naming the file and the cause.
void WriteCamera(const std::filesystem::path& path, const CameraModel& camera);

}  // namespace chequer

#pragma GCC visibility pop
