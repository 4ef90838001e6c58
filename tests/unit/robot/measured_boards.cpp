#include "unit/robot/measured_boards.h"

#include <numbers>

#include "chequer/check.h"
#include "detect/pose/plane_pose.h"
#include "support/board_places.h"
#include "support/dense.h"

namespace chequer::test {

RigidTransform WorldFromCamera() {
  // Half a turn about x makes z look down.
  return {RotationFromVector({0.1, -0.15, 0.3}) * RotationFromVector({std::numbers::pi, 0, 0}), {0.4, -0.3, 2.5}};
}

BoardMeasurement Measure(const RigidTransform& camera_from_marker, std::mt19937_64* random) {
  const RigidTransform camera_from_board =
      camera_from_marker * RigidTransform{Eigen::Quaterniond(0, 1, 0, 0), {0, 0, 0}};
  BoardGeometry geometry = PlaceOf(camera_from_board, {kCellM, kCellM}, kFocalPx);
  const BoardGeometry::Information information = InformationOfCorners(geometry, kCornerPx);
  if (random != nullptr) {
    std::normal_distribution<double> normal;
    BoardGeometry::Parameters white;
    for (double& value : white) value = normal(*random);
    geometry.Add(WithInformation(information, white));
  }
  return {geometry.plane_from_board(), information, kFocalPx, kCellM, kCellM};
}

MarkerPose Detect(std::uint64_t id, const RigidTransform& camera_from_marker, std::mt19937_64* random) {
  MarkerPose marker;
  marker.id = id;
  marker.measurement = Measure(camera_from_marker, random);
  const auto poses = PlanePoses({BoardGeometry(marker.measurement.plane_from_board), marker.measurement.information},
                                {kCellM, kCellM}, kFocalPx);
  CHEQUER_CHECK(poses.has_value(), "the test's marker is degenerate");
  marker.has_pose = true;
  marker.camera_from_marker = CameraFromMarker((*poses)[0].camera_from_board);
  marker.covariance = (*poses)[0].covariance;
  return marker;
}

RigidTransform OnFloor(double x, double y, double heading_rad, double height_m) {
  return {RotationFromVector({0, 0, heading_rad}), {x, y, height_m}};
}

}  // namespace chequer::test
