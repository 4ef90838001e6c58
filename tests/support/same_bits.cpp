#include "support/same_bits.h"

#include <cstring>
#include <sstream>
#include <type_traits>

namespace chequer::test {
namespace {

/// Collects the first difference.
class Comparison {
 public:
  explicit Comparison(std::string of) : of_(std::move(of)) {}

  template <class T>
  void Numbers(const char* field, const T* expected, const T* actual, std::size_t count) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    for (std::size_t i = 0; i < count && difference_.empty(); ++i) {
      if (std::memcmp(expected + i, actual + i, sizeof(T)) == 0) continue;
      std::ostringstream text;
      text.precision(17);
      text << of_ << field;
      if (count > 1) text << "[" << i << "]";
      text << " is " << +Number(actual[i]) << ", should be " << +Number(expected[i]);
      difference_ = text.str();
    }
  }
  template <class T>
  void Number(const char* field, const T& expected, const T& actual) {
    Numbers(field, &expected, &actual, 1);
  }
  template <class Matrix>
  void Matrices(const char* field, const Matrix& expected, const Matrix& actual) {
    Numbers(field, expected.data(), actual.data(), static_cast<std::size_t>(expected.size()));
  }

  const std::string& difference() const { return difference_; }

 private:
  template <class T>
  static auto Number(const T& value) {
    if constexpr (std::is_enum_v<T>)
      return static_cast<std::underlying_type_t<T>>(value);
    else
      return value;
  }

  std::string of_, difference_;
};

std::string DifferenceOf(std::size_t index, const MarkerPose& expected, const MarkerPose& actual) {
  Comparison compare("marker " + std::to_string(index) + ": ");
  // All fields there are: where one more is declared, this does not compile.
  const auto& [id, family, variant, size, has_pose, camera_from_marker, covariance, print_covariance, misfit, ambiguity,
               measurement, corners, corners_used, rms_px, center_px, luminance_overlap, saturation_overlap,
               bits_corrected, warnings] = expected;
  const auto& [rotation, translation] = camera_from_marker;
  const auto& [plane_from_board, information, focal_px, cell_m, cell_height_m, by_print, by_camera] = measurement;
  compare.Number("has an id", id.has_value(), actual.id.has_value());
  compare.Number("id", id.value_or(0), actual.id.value_or(0));
  compare.Number("family", family, actual.family);
  compare.Number("variant", variant, actual.variant);
  compare.Number("rows", size.rows, actual.size.rows);
  compare.Number("cols", size.cols, actual.size.cols);
  compare.Number("has_pose", has_pose, actual.has_pose);
  compare.Matrices("rotation", rotation.coeffs(), actual.camera_from_marker.rotation.coeffs());
  compare.Matrices("translation", translation, actual.camera_from_marker.translation);
  compare.Matrices("covariance", covariance, actual.covariance);
  compare.Matrices("print_covariance", print_covariance, actual.print_covariance);
  compare.Number("misfit", misfit, actual.misfit);
  compare.Number("ambiguity", ambiguity, actual.ambiguity);
  compare.Matrices("plane_from_board", plane_from_board, actual.measurement.plane_from_board);
  compare.Matrices("information", information, actual.measurement.information);
  compare.Number("focal_px", focal_px, actual.measurement.focal_px);
  compare.Number("cell_m", cell_m, actual.measurement.cell_m);
  compare.Number("cell_height_m", cell_height_m, actual.measurement.cell_height_m);
  compare.Matrices("by_print", by_print, actual.measurement.by_print);
  compare.Matrices("by_camera", by_camera, actual.measurement.by_camera);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::string corner = "corner " + std::to_string(i);
    compare.Matrices(corner.c_str(), corners[i], actual.corners[i]);
  }
  compare.Number("corners_used", corners_used, actual.corners_used);
  compare.Number("reprojection_rms_px", rms_px, actual.reprojection_rms_px);
  compare.Matrices("center_px", center_px, actual.center_px);
  compare.Number("luminance_overlap", luminance_overlap, actual.luminance_overlap);
  compare.Number("saturation_overlap", saturation_overlap, actual.saturation_overlap);
  compare.Number("bits_corrected", bits_corrected, actual.bits_corrected);
  compare.Number("warnings", warnings, actual.warnings);
  return compare.difference();
}

}  // namespace

std::string DifferenceOf(const Detected& expected, const Detected& actual) {
  if (expected.markers.size() != actual.markers.size())
    return std::to_string(actual.markers.size()) + " markers, should be " + std::to_string(expected.markers.size());
  for (std::size_t i = 0; i < expected.markers.size(); ++i)
    if (std::string difference = DifferenceOf(i, expected.markers[i], actual.markers[i]); !difference.empty())
      return difference;
  // Whatever it counts: nothing in it but numbers of which every bit counts.
  static_assert(std::has_unique_object_representations_v<DetectStats>);
  constexpr std::size_t kCounts = sizeof(DetectStats) / sizeof(int);
  std::array<int, kCounts> expected_counts, actual_counts;
  static_assert(sizeof expected_counts == sizeof(DetectStats));
  std::memcpy(expected_counts.data(), &expected.stats, sizeof expected_counts);
  std::memcpy(actual_counts.data(), &actual.stats, sizeof actual_counts);
  Comparison compare("stats: ");
  compare.Numbers("count ", expected_counts.data(), actual_counts.data(), kCounts);
  return compare.difference();
}

}  // namespace chequer::test
