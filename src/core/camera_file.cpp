#include "chequer/camera_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <vector>

#include "chequer/image.h"
#include "core/file.h"
#include "core/toml_reader.h"

namespace chequer {
namespace {

using Kind = CameraModel::Kind;

constexpr std::array<std::pair<std::string_view, Kind>, 3> kKinds{
    {{"brown_conrady", Kind::kBrownConrady}, {"fisheye", Kind::kFisheye}, {"pinhole", Kind::kPinhole}}};

// Wide enough for any lens, narrow enough that arithmetic on them stays finite.
constexpr NumberRange kFocalLength{0.1, 1e6};
constexpr NumberRange kPrincipalPoint{-1e6, 1e6};
constexpr NumberRange kCoefficient{-1e6, 1e6};

void ReadDistortion(TomlTable& table, CameraModel& camera) {
  std::vector<double> coefficients;
  const bool given = table.Read("distortion", coefficients, LengthRange{0, 14}, kCoefficient);
  const std::size_t count = coefficients.size();
  if (camera.kind == Kind::kPinhole) {
    const bool none = std::all_of(coefficients.begin(), coefficients.end(), [](double k) { return k == 0; });
    if (!none) table.Fail("distortion", "must be left out or 0 with model \"pinhole\"");
    return;
  }
  if (!given) table.FailMissing("distortion");
  if (camera.kind == Kind::kFisheye && count != 4)
    table.Fail("distortion", "must have the 4 values k1 k2 k3 k4 with model \"fisheye\"");
  if (camera.kind == Kind::kBrownConrady && count != 4 && count != 5)
    table.Fail("distortion", "must have the 5 values k1 k2 p1 p2 k3, or the first 4, with model \"brown_conrady\"");
  std::copy(coefficients.begin(), coefficients.end(), camera.distortion.begin());
}

CameraModel ReadCamera(TomlFile file) {
  CameraModel camera;
  TomlTable table = file.root().Table("camera");
  table.Require("width", camera.width, IntegerRange{1, kMaxImageSide});
  table.Require("height", camera.height, IntegerRange{1, kMaxImageSide});
  table.Require("fx", camera.fx, kFocalLength);
  table.Require("fy", camera.fy, kFocalLength);
  table.Require("cx", camera.cx, kPrincipalPoint);
  table.Require("cy", camera.cy, kPrincipalPoint);
  table.Require("model", camera.kind, kKinds);
  ReadDistortion(table, camera);
  file.CheckAllKeysRead();
  return camera;
}

/// The shortest text that reads back as the same number.
std::string Exact(double number) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

}  // namespace

CameraModel LoadCamera(const std::filesystem::path& path) { return ReadCamera(TomlFile::Load(path)); }

CameraModel ParseCamera(std::string_view text, const std::string& name) {
  return ReadCamera(TomlFile::Parse(text, name));
}

std::string FormatCamera(const CameraModel& camera) {
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& entry) { return entry.second == camera.kind; });
  std::string text = "[camera]\n";
  text += "width = " + std::to_string(camera.width) + "\n";
  text += "height = " + std::to_string(camera.height) + "\n";
  text += "fx = " + Exact(camera.fx) + "\n";
  text += "fy = " + Exact(camera.fy) + "\n";
  text += "cx = " + Exact(camera.cx) + "\n";
  text += "cy = " + Exact(camera.cy) + "\n";
  text.append("model = \"").append(kind->first).append("\"\n");
  if (camera.kind == Kind::kPinhole) return text;
  const std::size_t count = camera.kind == Kind::kFisheye ? 4 : 5;
  text += "distortion = [";
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + Exact(camera.distortion[i]);
  return text + (count == 5 ? "] # k1 k2 p1 p2 k3\n" : "] # k1 k2 k3 k4\n");
}

void WriteCamera(const std::filesystem::path& path, const CameraModel& camera) {
  WriteFileAtomically(path, FormatCamera(camera));
}

}  // namespace chequer
