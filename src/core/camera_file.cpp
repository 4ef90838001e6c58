#include "chequer/camera_file.h"

#include <algorithm>
#include <array>
#include <vector>

#include "chequer/image.h"
#include "core/date_text.h"
#include "core/file.h"
#include "core/number_text.h"
#include "core/small_cholesky.h"
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
constexpr NumberRange kGamma{0.2, 5};
constexpr NumberRange kBend{-0.9, 0.9};
constexpr NumberRange kCovariance{-1e12, 1e12};
constexpr NumberRange kRowsReadMs{0, 1000};

constexpr int kLensNumbers = LensCovariance::RowsAtCompileTime;
/// What rounding may leave of the least eigenvalue of correlations; of those that files hold, 1e-15.
constexpr double kRounding = 1e-6;

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

/// The curve, where the file has one.
void ReadToneCurve(TomlTable& table, CameraModel& camera) {
  double gamma = 0;
  std::vector<double> numbers;
  if (table.Read("gamma", gamma, kGamma)) camera.tone_curve = ToneCurve::Gamma(gamma);
  constexpr std::size_t kCount = std::tuple_size_v<ToneCurve::Bends>;
  if (!table.Read("gamma_bends", numbers, LengthRange{kCount, kCount}, kBend)) return;
  ToneCurve::Bends bends{};
  std::transform(numbers.begin(), numbers.end(), bends.begin(), [](double bend) { return static_cast<float>(bend); });
  camera.tone_curve = camera.tone_curve.value_or(ToneCurve::Srgb()).WithBends(bends);
  if (!camera.tone_curve)
    table.Fail("gamma_bends", "must leave the values 1/8 to 7/8, with a bend added to each, rising between 0 and 1");
}

/// Numbers that `distortion` has in a file.
std::size_t CoefficientCount(CameraModel::Kind kind) {
  switch (kind) {
    case Kind::kPinhole: return 0;
    case Kind::kFisheye: return 4;
    case Kind::kBrownConrady: return 5;
  }
  return 0;
}

/// Whether a matrix can be a covariance. Correlations are looked at: the numbers of a lens differ by powers of ten.
bool IsCovariance(const LensCovariance& matrix) {
  if (!(matrix.diagonal().minCoeff() >= 0)) return false;
  const Eigen::Matrix<double, kLensNumbers, 1> deviations =
      (matrix.diagonal().array() > 0).select(matrix.diagonal(), 1).cwiseSqrt();
  const LensCovariance correlations =
      deviations.cwiseInverse().asDiagonal() * matrix * deviations.cwiseInverse().asDiagonal();
  return SmallCholesky<kLensNumbers>(correlations + kRounding * LensCovariance::Identity()).positive();
}

/// The covariance, where the file has one.
void ReadCovariance(TomlTable& table, CameraModel& camera) {
  std::vector<double> numbers;
  if (!table.Read("covariance", numbers, LengthRange{0, kLensNumbers * (kLensNumbers + 1) / 2}, kCovariance)) return;
  const std::size_t size = 4 + CoefficientCount(camera.kind), count = size * (size + 1) / 2;
  if (numbers.size() != count)
    table.Fail("covariance", "must have " + std::to_string(count) +
                                 " values with this model: the lower triangle, row by row, of fx, fy, cx, cy and the "
                                 "distortion coefficients");
  const auto rows = static_cast<Eigen::Index>(size);
  for (Eigen::Index row = 0, i = 0; row < rows; ++row)
    for (Eigen::Index col = 0; col <= row; ++col, ++i)
      camera.covariance(row, col) = camera.covariance(col, row) = numbers[static_cast<std::size_t>(i)];
  if (!IsCovariance(camera.covariance)) table.Fail("covariance", "must be positive semidefinite");
}

/// What a camera file holds.
struct Calibration {
  CameraModel camera;
  std::optional<CalibrationRecord> record;
};

std::optional<CalibrationRecord> ReadRecord(TomlTable& table, const CameraModel& camera) {
  CalibrationRecord record;
  std::vector<double> uncertainty;
  const bool dated = table.Read("date", record.date, LengthRange{1, 64});
  if (!IsDateText(record.date)) table.Fail("date", "must be a date, such as \"2024-05-01T12:00:00Z\"");
  const bool measured = table.Read("rms", record.rms_px, NumberRange{0, 1e6});
  const bool counted = table.Read("views", record.views, IntegerRange{1, 1'000'000});
  const bool estimated = table.Read("uncertainty", uncertainty, LengthRange{0, 9}, NumberRange{0, 1e6});
  const std::size_t count = 4 + CoefficientCount(camera.kind);
  if (estimated && uncertainty.size() != count)
    table.Fail("uncertainty", "must have " + std::to_string(count) +
                                  " values with this model: of fx, fy, cx, cy and of each distortion coefficient");
  std::copy(uncertainty.begin(), uncertainty.end(), record.uncertainty.begin());
  if (!dated && !measured && !counted && !estimated) return std::nullopt;
  return record;
}

Calibration ReadCalibration(TomlFile file) {
  Calibration calibration;
  CameraModel& camera = calibration.camera;
  TomlTable table = file.root().Table("camera");
  table.Require("width", camera.width, IntegerRange{1, kMaxImageSide});
  table.Require("height", camera.height, IntegerRange{1, kMaxImageSide});
  table.Require("fx", camera.fx, kFocalLength);
  table.Require("fy", camera.fy, kFocalLength);
  table.Require("cx", camera.cx, kPrincipalPoint);
  table.Require("cy", camera.cy, kPrincipalPoint);
  table.Require("model", camera.kind, kKinds);
  ReadDistortion(table, camera);
  ReadToneCurve(table, camera);
  ReadCovariance(table, camera);
  table.Read("rows_read_ms", camera.rows_read_ms, kRowsReadMs);
  calibration.record = ReadRecord(table, camera);
  file.CheckAllKeysRead();
  return calibration;
}

std::string List(const double* numbers, std::size_t count) {
  std::string text = "[";
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + ExactText(numbers[i]);
  return text + "]";
}

std::string FormatToneCurve(const ToneCurve& curve) {
  std::string text;
  if (!curve.is_srgb()) text += "gamma = " + ExactText(curve.gamma()) + " # value = light^(1/gamma)\n";
  if (!curve.is_bent() && !curve.is_srgb()) return text;
  std::array<double, std::tuple_size_v<ToneCurve::Bends>> bends{};
  std::copy(curve.bends().begin(), curve.bends().end(), bends.begin());
  return text + "gamma_bends = " + List(bends.data(), bends.size()) + " # added to the values 1/8 to 7/8 before\n";
}

std::string FormatCovariance(const LensCovariance& covariance, std::size_t coefficients) {
  std::vector<double> numbers;
  for (Eigen::Index row = 0; row < 4 + static_cast<Eigen::Index>(coefficients); ++row)
    for (Eigen::Index col = 0; col <= row; ++col) numbers.push_back(covariance(row, col));
  return "covariance = " + List(numbers.data(), numbers.size()) +
         " # of fx fy cx cy and of the distortion, lower triangle\n";
}

std::string FormatRecord(const CalibrationRecord& record, std::size_t coefficients) {
  std::string text = "date = \"" + record.date + "\"\n";
  text += "rms = " + ExactText(record.rms_px) + " # pixels\n";
  text += "views = " + std::to_string(record.views) + "\n";
  return text + "uncertainty = " + List(record.uncertainty.data(), 4 + coefficients) +
         " # standard deviations of fx fy cx cy and of the distortion\n";
}

}  // namespace

CameraModel LoadCamera(const std::filesystem::path& path) { return ReadCalibration(TomlFile::Load(path)).camera; }

std::optional<CalibrationRecord> LoadCalibrationRecord(const std::filesystem::path& path) {
  return ReadCalibration(TomlFile::Load(path)).record;
}

CameraModel ParseCamera(std::string_view text, const std::string& name) {
  return ReadCalibration(TomlFile::Parse(text, name)).camera;
}

std::string FormatCamera(const CameraModel& camera, const CalibrationRecord* record) {
  const auto kind =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& entry) { return entry.second == camera.kind; });
  std::string text = "[camera]\n";
  text += "width = " + std::to_string(camera.width) + "\n";
  text += "height = " + std::to_string(camera.height) + "\n";
  text += "fx = " + ExactText(camera.fx) + "\n";
  text += "fy = " + ExactText(camera.fy) + "\n";
  text += "cx = " + ExactText(camera.cx) + "\n";
  text += "cy = " + ExactText(camera.cy) + "\n";
  text.append("model = \"").append(kind->first).append("\"\n");
  const std::size_t count = CoefficientCount(camera.kind);
  if (count > 0)
    text += "distortion = " + List(camera.distortion.data(), count) +
            (count == 5 ? " # k1 k2 p1 p2 k3\n" : " # k1 k2 k3 k4\n");
  if (camera.tone_curve) text += FormatToneCurve(*camera.tone_curve);
  if (!camera.covariance.isZero(0)) text += FormatCovariance(camera.covariance, count);
  if (camera.rows_read_ms != 0)
    text += "rows_read_ms = " + ExactText(camera.rows_read_ms) + " # by which the last row is later than the first\n";
  if (record != nullptr) text += FormatRecord(*record, count);
  return text;
}

void WriteCamera(const std::filesystem::path& path, const CameraModel& camera, const CalibrationRecord* record) {
  WriteFileAtomically(path, FormatCamera(camera, record));
}

}  // namespace chequer
