#pragma once

#include <chrono>
#include <functional>
#include <vector>

#include "chequer/camera_model.h"
#include "simulate/scene.h"
#include "tools/render_request.h"

namespace chequer {

/// The markers before the camera at a time since the first frame.
using MarkersAt = std::function<std::vector<SceneMarker>(std::chrono::duration<double>)>;

/// The first page that `chequer print` makes of the markers of a request, held before the camera: another place of the
/// image, tilt and distance in each frame, as for `chequer calibrate lens`. What stands over the frame's rim is drawn
/// in part. Throws CLI::ValidationError where no ids are named, std::runtime_error where no marker fits on a page.
MarkersAt PlanSheetViews(const RenderRequest& request, const CameraModel& camera);

/// A room seen from above: markers that lie at the places of request.room, and robots that drive in circles between
/// them. The camera hangs where the world file says, else request.distance_m over the middle of the references, tilted
/// a little. Robots are those of the roster; without one, each id of the markers that is no reference is a robot, whose
/// marker is kRoomRobotHeightM over the floor. Throws CLI::ValidationError, or std::runtime_error where a file is
/// wrong.
MarkersAt PlanRoom(const RenderRequest& request, const CameraModel& camera);

inline constexpr double kRoomRobotHeightM = 0.1;

}  // namespace chequer
