#include "detect/identity/marker_description.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "detect/common/widened.h"
#include "detect/pose/plane_pose.h"

namespace chequer {
namespace {

/// Warn of an ambiguous pose above this probability (a choice).
constexpr double kAmbiguous = 0.001;
/// Below this probability, the other pose adds nothing to the covariance (a choice).
constexpr double kNeverTheOther = 1e-6;
/// A homography has eight parameters, a pose six.
constexpr double kLeftOver = 2;
/// Noise leaves so many times its variance unexplained in one pose of a thousand: χ² of two degrees of freedom, over
/// them.
constexpr double kNoiseMisfit = 6.9;
/// The same for one print in ten that keeps its tolerance. That tells only what prints usually are: others are farther
/// off than a normal distribution has it, and lie beyond. Of prints with an axis 1 % too long, four times the deviation
/// of office prints, squared errors were 2.7 times the covariance with the limit for noise.
constexpr double kPrintMisfit = 2.3;

}  // namespace

void Set(MarkerPose& marker, Warning warning) { marker.warnings |= static_cast<std::uint32_t>(warning); }

void Describe(const FittedBoard& fitted, const Identity& identity, const DetectorOptions& options, const Lens& lens,
              MarkerPose& marker) {
  marker = MarkerPose{};
  const MarkerFamily& family = options.families[static_cast<std::size_t>(identity.family)];
  marker.family = identity.family;
  marker.variant = family.code.variant();
  marker.size = family.code.size();
  marker.luminance_overlap = identity.luminance_overlap;
  marker.saturation_overlap = identity.saturation_overlap;
  if (identity.luminance_overlap > options.max_luminance_overlap) Set(marker, Warning::kPoorIllumination);
  if (identity.saturation_overlap > options.max_saturation_overlap) Set(marker, Warning::kPoorWhiteBalance);
  if (identity.id_decided) {
    marker.id = identity.decoded->id;
    marker.bits_corrected = identity.decoded->bits_corrected;
  } else {
    Set(marker, Warning::kIdUndecided);
  }
  marker.corners_used = fitted.corners_used();
  marker.reprojection_rms_px = fitted.reprojection_rms_px;
  if (identity.cells_hidden > 0 || !fitted.visibility.ShowsAllCorners()) Set(marker, Warning::kPartlyHidden);
  marker.corners.fill(Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  for (int i = 0; i < CornerCount(marker.size); ++i)
    if (fitted.visibility.ShowsCorner(i))
      marker.corners[static_cast<std::size_t>(i)] =
          lens.ToImage(fitted.geometry.ToPlane(
                           CornerOnBoard(marker.size, i / (marker.size.cols - 1), i % (marker.size.cols - 1))))
              .cast<float>();
  marker.center_px = lens.ToImage(fitted.geometry.ToPlane({0, 0}));
}

void CarryIdentity(int family, std::uint64_t id, const DetectorOptions& options, MarkerPose& marker) {
  marker.family = family;
  marker.variant = options.families[static_cast<std::size_t>(family)].code.variant();
  marker.id = id;
  marker.bits_corrected = 0;
  marker.warnings &= ~static_cast<std::uint32_t>(Warning::kIdUndecided);
  Set(marker, Warning::kIdCarried);
}

BoardMeasurement MeasurementOf(const FittedBoard& fitted, MarkerSize size, const Eigen::Vector2d& cell_m,
                               const PrintTolerance& tolerance, const Lens& lens) {
  BoardMeasurement measured;
  measured.plane_from_board = fitted.geometry.plane_from_board();
  measured.information = fitted.information;
  measured.focal_px = lens.focal();
  measured.cell_m = cell_m.x();
  measured.cell_height_m = cell_m.y();
  if (tolerance.any()) {
    measured.by_print = HomographyByPrint(fitted.geometry, tolerance.scale, fitted.by_register);
    measured.information = Widened(measured.information, measured.by_print);
  }
  if (lens.uncertain()) {
    measured.by_camera = HomographyByCamera(fitted.geometry, size, lens);
    measured.information = Widened(measured.information, measured.by_camera);
  }
  return measured;
}

std::optional<BoardPoses> PosesOf(const BoardMeasurement& measured) {
  const auto poses = PlanePoses({BoardGeometry(measured.plane_from_board), measured.information},
                                {measured.cell_m, measured.cell_height_m}, measured.focal_px);
  if (!poses) return std::nullopt;
  return BoardPoses{measured, *poses};
}

void DescribePose(const BoardPoses& board, MarkerPose& marker) {
  const BoardMeasurement& measured = board.measured;
  const auto& [pose, other] = board.poses;
  marker.measurement = measured;
  marker.misfit = pose.chi_square / kLeftOver;
  marker.has_pose = true;
  marker.camera_from_marker = CameraFromMarker(pose.camera_from_board);
  marker.camera_from_marker.rotation = Canonical(marker.camera_from_marker.rotation);
  marker.covariance = pose.covariance;
  if (!measured.by_print.isZero() || !measured.by_camera.isZero())
    marker.print_covariance = ConstantCovariance(pose, measured);
  const bool print_known = measured.by_print.isZero();
  const double wider = marker.misfit > (print_known ? kNoiseMisfit : kPrintMisfit) ? marker.misfit : 1;
  if (marker.misfit > kNoiseMisfit) Set(marker, Warning::kPoorFit);
  marker.covariance *= wider;
  marker.measurement.information /= wider;
  // What a print is off by stays from frame to frame: tracks must not average it away.
  if (!print_known) {
    marker.print_covariance *= wider;
    marker.measurement.by_print *= wider;
  }
  // Both poses are as likely before the image is seen.
  marker.ambiguity = 1 / (1 + std::exp(std::min((other.chi_square - pose.chi_square) / (2 * wider), 100.0)));
  // Where both minima are one, nothing is ambiguous: the covariance tells the whole story.
  const double apart = (pose.camera_from_board.rotation.inverse() * other.camera_from_board.rotation)
                           .angularDistance(Eigen::Quaterniond::Identity());
  if (apart < 3 * std::sqrt(std::max(pose.covariance(3, 3), pose.covariance(4, 4)))) marker.ambiguity = 0;
  if (marker.ambiguity > kAmbiguous) Set(marker, Warning::kAmbiguous);
  if (marker.ambiguity < kNeverTheOther) return;
  // That it may be the other pose is a part of the error.
  Eigen::Matrix<double, 6, 1> to_other;
  to_other << other.camera_from_board.translation - pose.camera_from_board.translation,
      VectorFromRotation((other.camera_from_board.rotation * pose.camera_from_board.rotation.conjugate()).normalized());
  marker.covariance += marker.ambiguity * to_other * to_other.transpose();
}

}  // namespace chequer
