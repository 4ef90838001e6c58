#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/geometry.h"
#include "simulate/background.h"
#include "simulate/board.h"
#include "simulate/inks.h"

namespace chequer {

/// Something that lies on a marker. Given in fractions of the board from its top left: (0, 0) … (1, 1) hides it all; it
/// may stand over the board's rim.
struct Occluder {
  Eigen::Vector2d from{0, 0};  ///< right, down
  Eigen::Vector2d to{1, 1};
  Eigen::Vector3f colour{0.25f, 0.2f, 0.15f};  ///< linear RGB
  /// Patches of random colour along the longer side; 0: plain.
  int patches = 0;
  std::uint64_t seed = 0;  ///< of the patches
};

/// What is wrong with one print. The truth has the marker that was meant.
struct PrintErrors {
  Eigen::Vector2d scale{1, 1};  ///< printed over nominal length: of the board's width, of its height; 0.8..1.2
  // Where the blue and the yellow ink lie against the black one, which lies where it should: right, down, metres.
  Eigen::Vector2d blue_shift_m{0, 0};
  Eigen::Vector2d yellow_shift_m{0, 0};

  bool in_register() const { return blue_shift_m.isZero() && yellow_shift_m.isZero(); }
};

/// The mirror image of a lamp on a glossy print: a Gaussian spot.
struct Highlight {
  double strength = 0;           ///< what it adds at its middle, over what the print's white reflects; 0..5
  Eigen::Vector2d at{0.5, 0.5};  ///< fractions of the board from its top left: right, down
  double sigma = 0.25;           ///< over the board's longer side, above 0
};

/// Largest SceneMarker::ink_spread_cells.
inline constexpr double kMostInkSpreadCells = 0.4;

/// Where a place of flat paper lies once the paper bends, and how: the paper's x and y there, z out of its face, in the
/// frame of its middle. A print with its middle at that place, and the same bend, lies on the same cylinder.
/// @param bend_per_m, bend_angle_rad as SceneMarker has them.
RigidTransform OnBentPaper(const Eigen::Vector2d& flat_m, double bend_per_m, double bend_angle_rad);

/// A marker that stands in the scene.
struct SceneMarker {
  RigidTransform camera_from_marker;  ///< origin at the board's centre, x right, y up, z out of the face
  Board board;
  double side_m = 0;  ///< of the longer counted side
  InkSet inks;
  double margin_cells = 0;  ///< plain border round the board
  char margin_colour = 'W';
  double ink_spread_cells = 0;  ///< by which dark cells grow on each side, 0..0.4; of checkerboards alone
  PrintErrors print;
  bool mirrored = false;  ///< seen in a mirror: left and right of the board exchanged
  /// Light falls from 1 at one rim of the board to 1 − gradient at the other; 0..1.
  double gradient = 0;
  double gradient_angle_rad = 0;  ///< where it falls to, in the image: 0 right, π/2 down
  Highlight highlight;
  std::vector<Occluder> occluders;
  /// Paper that lies on a cylinder: 1 over its radius, 1/m, positive where its middle is nearest to the viewer, which
  /// is where the marker's frame stays; and the direction in which it bends, from the marker's x axis towards its y
  /// axis.
  double bend_per_m = 0, bend_angle_rad = 0;

  double CellSize() const { return board.CellSize(side_m); }
  /// The place of the paper, were it flat, of what is that many cells right and down of the board's top left.
  Eigen::Vector2d FlatPointAt(double col, double row) const;
  /// The point of the marker frame where what is that many cells right and down of the board's top left was printed.
  Eigen::Vector3d PointAt(double col, double row) const;
};

/// What a camera sees. Later markers lie over earlier ones.
struct Scene {
  std::vector<SceneMarker> markers;
  Background background;

  /// Empty, or what is wrong and what would be right, naming the marker.
  std::string Check() const;
};

/// Whether a marker can be drawn: all of it is seen from its printed side, lies in front of the camera and where the
/// lens model is valid. It may lie outside the frame.
bool IsDrawable(const SceneMarker& marker, const CameraModel& camera);

/// Pixel of the board's centre. @pre IsDrawable.
Eigen::Vector2d CenterPx(const SceneMarker& marker, const CameraModel& camera);

/// The smallest distance between neighbouring cell corners, pixels: what decides whether the marker can be read.
/// @pre IsDrawable.
double SmallestCellPx(const SceneMarker& marker, const CameraModel& camera);

/// camera_from_marker of a marker that looks straight at the camera, then turned by `heading_rad` (clockwise in the
/// image), then tilted by `tilt_rad` about the image axis at `tilt_axis_rad` (0: the x axis).
RigidTransform FacingPose(const Eigen::Vector3d& position, double heading_rad, double tilt_rad = 0,
                          double tilt_axis_rad = 0);

}  // namespace chequer
