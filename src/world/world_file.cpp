#include "world/world_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/date_text.h"
#include "core/file.h"
#include "core/number_text.h"
#include "core/toml_reader.h"
#include "marker/variants.h"

namespace chequer {
namespace {

// A room is smaller; arithmetic on such numbers stays finite.
constexpr NumberRange kPlace{-1e5, 1e5};
constexpr NumberRange kSide{0.001, 99.0};
constexpr IntegerRange kId{0, std::numeric_limits<std::int64_t>::max()};

/// @param required whether the key must be there; 0 0 0 where it is not.
Eigen::Vector3d ReadVector(TomlTable& table, std::string_view key, bool required) {
  std::vector<double> numbers;
  if (!table.ReadLengths(key, numbers, LengthRange{3, 3}, kPlace)) {
    if (required) table.FailMissing(key);
    return Eigen::Vector3d::Zero();
  }
  return {numbers[0], numbers[1], numbers[2]};
}

RigidTransform ReadPose(TomlTable& table) {
  RigidTransform pose;
  pose.translation = ReadVector(table, "position", true);
  std::vector<double> wxyz;
  table.Require("orientation", wxyz, LengthRange{4, 4}, NumberRange{-1.001, 1.001});
  pose.rotation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  // Numbers written with a few digits are as good; a quaternion that is none would bend the room.
  if (std::abs(pose.rotation.norm() - 1) > 1e-3)
    table.Fail("orientation", "must be a unit quaternion w, x, y, z: its squares must add up to 1");
  pose.rotation = Canonical(pose.rotation.normalized());
  return pose;
}

Matrix6d ReadCovariance(TomlTable& table) {
  Matrix6d covariance = Matrix6d::Zero();
  std::vector<double> numbers;
  if (!table.Read("covariance", numbers, LengthRange{21, 21}, NumberRange{-1e6, 1e6})) return covariance;
  std::size_t next = 0;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) covariance(row, col) = covariance(col, row) = numbers[next++];
  if (covariance.diagonal().minCoeff() < 0) table.Fail("covariance", "must have no negative variances");
  return covariance;
}

MarkerSize ReadSize(TomlTable& table) {
  std::string text;
  table.Require("size", text);
  const auto size = ParseMarkerSize(text);
  if (!size)
    table.Fail("size", "must be ROWSxCOLS such as \"6x6\", at least 3x3, with at most 64 cells inside the border");
  return *size;
}

WorldReference ReadReference(TomlTable& table) {
  WorldReference reference;
  table.Require("id", reference.id, kId);
  reference.size = ReadSize(table);
  table.Require("variant", reference.variant, kVariants);
  if (!table.ReadLength("side", reference.side_m, kSide)) table.FailMissing("side");
  reference.world_from_marker = ReadPose(table);
  reference.residual_m = ReadVector(table, "residual", false);
  return reference;
}

WorldCalibration ReadWorld(TomlFile file) {
  WorldCalibration world;
  TomlTable root = file.root();
  if (!root.Has("world")) root.Fail("world", "is missing: a world file has a table [world]");
  TomlTable table = root.Table("world");
  world.world_from_camera = ReadPose(table);
  world.covariance = ReadCovariance(table);
  double rms = 0;
  if (table.ReadLength("rms", rms, NumberRange{0, 1e5})) world.rms_m = rms;
  table.Read("date", world.date, LengthRange{1, 64});
  if (!IsDateText(world.date)) table.Fail("date", "must be a date, such as \"2024-05-01T12:00:00Z\"");
  for (TomlTable& reference : table.Tables("reference", kMaxReferences))
    world.references.push_back(ReadReference(reference));
  file.CheckAllKeysRead();
  return world;
}

template <typename Numbers>
std::string List(const Numbers& numbers) {
  std::string text = "[";
  for (const double number : numbers) text += (text.size() == 1 ? "" : ", ") + ExactText(number);
  return text + "]";
}

std::string List(const Eigen::Vector3d& v) { return List(std::array{v.x(), v.y(), v.z()}); }

std::string PoseLines(const RigidTransform& pose) {
  const Eigen::Quaterniond q = Canonical(pose.rotation);
  return "position = " + List(pose.translation) + "\norientation = " + List(std::array{q.w(), q.x(), q.y(), q.z()}) +
         "\n";
}

std::string CovarianceLine(const Matrix6d& covariance) {
  std::vector<double> numbers;
  for (int row = 0; row < 6; ++row)
    for (int col = row; col < 6; ++col) numbers.push_back(covariance(row, col));
  return "covariance = " + List(numbers) + "\n";
}

std::string ReferenceText(const WorldReference& reference) {
  std::string text = "\n[[world.reference]]\nid = " + std::to_string(reference.id) + "\n";
  text += "size = \"" + ToString(reference.size) + "\"\n";
  text.append("variant = \"").append(VariantName(reference.variant)).append("\"\n");
  text += "side = " + ExactText(reference.side_m) + "\n";
  text += PoseLines(reference.world_from_marker);
  return text + "residual = " + List(reference.residual_m) + "\n";
}

}  // namespace

WorldCalibration LoadWorld(const std::filesystem::path& path) { return ReadWorld(TomlFile::Load(path)); }

WorldCalibration ParseWorld(std::string_view text, const std::string& name) {
  return ReadWorld(TomlFile::Parse(text, name));
}

std::string FormatWorld(const WorldCalibration& world) {
  std::string text = "# Where the camera stands: world_from_camera. Metres; quaternions w, x, y, z.\n[world]\n";
  text += PoseLines(world.world_from_camera);
  if (!world.covariance.isZero(0)) text += CovarianceLine(world.covariance);
  if (world.rms_m) text += "rms = " + ExactText(*world.rms_m) + "\n";
  if (!world.date.empty()) text += "date = \"" + world.date + "\"\n";
  for (const WorldReference& reference : world.references) text += ReferenceText(reference);
  return text;
}

void WriteWorld(const std::filesystem::path& path, const WorldCalibration& world) {
  WriteFileAtomically(path, FormatWorld(world));
}

}  // namespace chequer
