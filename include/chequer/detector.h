#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/camera_model.h"
#include "chequer/detector_memory.h"
#include "chequer/geometry.h"
#include "chequer/image.h"
#include "chequer/marker.h"

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// What a detection is to be taken with care for; bits of MarkerPose::warnings.
enum class Warning : std::uint32_t {
  kIdUndecided = 1u << 0,       ///< the board is certain, the code does not decide its identity
  kPoorIllumination = 1u << 1,  ///< dark and light luminances overlap more than configured
  kPoorWhiteBalance = 1u << 2,  ///< saturated and unsaturated saturations overlap more than configured
  kPartlyHidden = 1u << 3,      ///< cells or corners of the board were not seen
  kAmbiguous = 1u << 4,         ///< the mirrored pose explains the image nearly as well
  /// Too much of the board is occluded to read its identity: it is that of the board that has been followed there from
  /// frame to frame.
  kIdCarried = 1u << 5,
  kPoorFit = 1u << 6,  ///< the image says much that the pose does not explain; the covariance is widened
  /// No fault: the pose rests on what earlier frames have shown of its cells' levels (DetectorOptions::learn_levels).
  kLevelsLearnt = 1u << 7,
};
/// "id_undecided", "poor_illumination", "poor_white_balance", "partly_hidden", "ambiguous_pose", "id_carried",
/// "poor_fit", "levels_learnt".
std::string_view WarningName(Warning warning);
inline constexpr std::array kAllWarnings{Warning::kIdUndecided,  Warning::kPoorIllumination, Warning::kPoorWhiteBalance,
                                         Warning::kPartlyHidden, Warning::kAmbiguous,        Warning::kIdCarried,
                                         Warning::kPoorFit,      Warning::kLevelsLearnt};

/// How saturation and luminance are told from colour (the publication, section II-A).
enum class ColorSpace : std::uint8_t {
  kLab,  ///< CIE L*a*b*: luminance L*, saturation |b*|
  kHsv,  ///< luminance V, saturation S
};

/// One kind of marker that is sought.
struct MarkerFamily {
  MarkerCode code{MarkerSize{}, Variant::kSecded};
  double side_m = 0;  ///< of the longer side of the board, cells included; used only with a calibration
  /// Ids in use; empty: all.
  std::vector<std::uint64_t> roster;
  /// Width and height of the whole board as measured on the print, where the printer stretched one of them; zeros:
  /// cells are square, of side_m.
  Eigen::Vector2d printed_m = Eigen::Vector2d::Zero();
  /// The same of single markers, by id, where their prints are not as the others.
  std::map<std::uint64_t, Eigen::Vector2d> printed_by_id_m{};

  /// Width and height of a cell of that marker.
  Eigen::Vector2d CellM(std::uint64_t id) const {
    const auto print = printed_by_id_m.find(id);
    return print == printed_by_id_m.end() ? CellM() : CellOf(print->second);
  }
  /// Width and height of a cell, of markers that are not in printed_by_id_m.
  Eigen::Vector2d CellM() const {
    const MarkerSize size = code.size();
    if (printed_m.isZero()) return Eigen::Vector2d::Constant(side_m / std::max(size.rows, size.cols));
    return CellOf(printed_m);
  }
  /// Whether a board of that width and height has cells that are square to a fifth: no printer does worse, and width
  /// and height are likely swapped, or not a board's.
  bool IsPrint(const Eigen::Vector2d& width_and_height_m) const {
    const Eigen::Vector2d cell = CellOf(width_and_height_m);
    return cell.minCoeff() > 0 && cell.maxCoeff() <= 1.2 * cell.minCoeff();
  }
  /// Sets printed_m, and side_m to that of square cells of the same area. False, and nothing is set, where it is no
  /// print.
  bool SetPrinted(const Eigen::Vector2d& width_and_height_m) {
    if (!IsPrint(width_and_height_m)) return false;
    const MarkerSize size = code.size();
    printed_m = width_and_height_m;
    side_m = std::max(size.rows, size.cols) * std::sqrt(CellOf(printed_m).prod());
    return true;
  }
  /// Width and height of a cell of a board of that width and height.
  Eigen::Vector2d CellOf(const Eigen::Vector2d& width_and_height_m) const {
    return {width_and_height_m.x() / code.size().cols, width_and_height_m.y() / code.size().rows};
  }
};

/// How far prints may be off what side_m or printed_m says: standard deviations. What is off is the same in every
/// frame.
struct PrintTolerance {
  double scale = 0;       ///< of a board's width, and of its height, as a share of it; 0..0.05
  double register_m = 0;  ///< of one ink against another, along either axis; 0..0.005

  bool any() const { return scale > 0 || register_m > 0; }
  bool operator==(const PrintTolerance&) const = default;
};
/// With a print tolerance, the standard deviation of the focal lengths, as a share of them and common to both, of a
/// camera that states no covariance (CameraModel::covariance). Derived: lateral chromatic aberration in webcams
/// magnifies red 4e-4 to 1e-3 more than green, and blue as much less (0.3 to 0.7 px in the corners of 1280 x 720);
/// luminance weighs red by 0.14 more than blue, so its magnification is off by 6e-5 to 1.4e-4. The range is a guess.
inline constexpr double kUsualFocalError = 1e-4;
/// What office printers keep: 0.25 % of scale and 0.03 mm between inks.
inline constexpr PrintTolerance kOfficePrints{.scale = 0.0025, .register_m = 3e-5};

/// Units without which not even the corners of a small image are found.
inline constexpr std::uint64_t kLeastBudget = 1000;

struct DetectorOptions {
  std::vector<MarkerFamily> families{MarkerFamily{}};
  /// Without it, poses are left out.
  std::optional<CameraModel> camera;
  ColorSpace color_space = ColorSpace::kLab;
  /// Warn poor_illumination above this overlap of the luminances (publication, section II-B), 0..0.5.
  double max_luminance_overlap = 0.02;
  /// Warn poor_white_balance above this overlap of the saturations, 0..0.5.
  double max_saturation_overlap = 0.02;
  /// Goes into the poses' covariances, and keeps poses from resting on what is not certain.
  PrintTolerance print_tolerance;
  /// Threads for one image, 1..64.
  int threads = 1;
  /// Called first on each thread that the detector starts, 1 … threads − 1: to name it, or to make it as urgent as the
  /// caller of Detect, who waits for it. Must not throw.
  std::function<void(int thread)> on_thread_start;
  /// Called about once a board while an image is worked on, on any of the threads: it shows that a slow image makes
  /// progress. Must return quickly and not throw.
  std::function<void()> on_progress;
  /// How much work an image may take, units (DetectStats::work); 0: as much as it takes. Where it does not last, the
  /// least worthwhile is left undone, counted in DetectStats::deferred, and goes first in the next image: then what an
  /// image shows depends on those before it. At least kLeastBudget, or 0.
  std::uint64_t budget = 0;
  /// With a memory: every place of a stream's frames is searched for new boards in one frame out of so many at least,
  /// 1..64; places where a board was lost in every one.
  int search_every = 4;
  /// With a memory: for so long after its identity was read, a board that is followed keeps it while too much of it is
  /// occluded to read it, seconds, 0..60; 0: never.
  double carry_s = 1;
  /// With a memory: a board's pose rests on what the last frames have shown of the levels of its cells, too, as far as
  /// they are seen to stay from frame to frame; how the board is lit may change. Covariance and errors fall: by 3 % with
  /// cells of 10 px, by 6 % with 5.6 px, by 15 % with 4 px (measured). Only boards in plain view, moved by no more than
  /// half a cell, not overexposed, without shadow or dot gain, are fitted so; their poses have the warning
  /// levels_learnt. Which boards are found, and as which, stays the same. It costs as much again as 40 % of a steady
  /// frame. Errors of successive frames are no longer independent.
  bool learn_levels = false;

  /// Empty, or what is wrong and what would be right.
  std::string Check() const;
};

/// How a board's homography moves with what its print may be off, each by one standard deviation: width, height, the
/// blue ink right, and down. The same print errs alike in all frames: nobody may average it away.
using PrintColumns = Eigen::Matrix<double, 8, 4>;

/// How a board's homography moves with what the camera's calibration may be off (CameraModel::covariance): columns of
/// one standard deviation each. They are the same for all boards of a camera, so they add up over the boards of a body.
using CameraColumns = Eigen::Matrix<double, 8, 9>;

/// What an image says of a board's place, before it is taken for a rigid body in front of a camera: whoever knows more
/// (that the marker lies on the floor, or shares a body with another) estimates from it anew and loses nothing.
struct BoardMeasurement {
  /// From cells (from the board's centre, x along its columns, y down its rows) to focal_px times the plane z = 1; its
  /// last entry is 1.
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  /// Inverse covariance of its first eight entries, row by row; what print and calibration may be off included.
  Eigen::Matrix<double, 8, 8> information = Eigen::Matrix<double, 8, 8>::Zero();
  double focal_px = 0;
  double cell_m = 0;         ///< width of a cell
  double cell_height_m = 0;  ///< mostly the same
  /// The part of the covariance that the print is: its columns times themselves transposed.
  PrintColumns by_print = PrintColumns::Zero();
  /// The part that the camera's calibration is, likewise.
  CameraColumns by_camera = CameraColumns::Zero();
};

/// Corners of a marker none of which was seen.
inline std::array<Eigen::Vector2f, kMaxCorners> NoCorners() {
  std::array<Eigen::Vector2f, kMaxCorners> corners;
  corners.fill(Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  return corners;
}

/// One marker found in an image.
struct MarkerPose {
  std::optional<std::uint64_t> id;  ///< empty where undecided; `warnings` says why
  int family = 0;                   ///< index into DetectorOptions::families
  Variant variant = Variant::kSecded;
  MarkerSize size;

  /// camera_from_marker (marker frame: origin at the board's centre, x right, y up, z out of the printed face).
  /// Valid only with has_pose (a calibration was given).
  bool has_pose = false;
  RigidTransform camera_from_marker;
  /// Of (x, y, z, θx, θy, θz): position in the camera frame, m², and a rotation θ about the camera's axes, rad², with
  /// R_true = Exp(θ) · R_estimated. An ambiguous pose's holds that it may be the other one: the way there, squared,
  /// times the ambiguity.
  Matrix6d covariance = Matrix6d::Zero();
  /// The part of it that the print may be off, by DetectorOptions::print_tolerance, and the camera's calibration, by
  /// CameraModel::covariance: it stays from frame to frame.
  Matrix6d print_covariance = Matrix6d::Zero();
  /// How many times more than noise does the image differs from what the pose explains, per degree of freedom; 0
  /// without a pose. Beyond what noise can do (6.9), the covariance is widened by it; with a print tolerance beyond what
  /// one print in ten within it has (2.3). Does not travel over LCM.
  double misfit = 0;
  /// Probability that the pose's mirror image (the second minimum) is the true one, 0..0.5.
  double ambiguity = 0;
  /// What the pose was made of; valid with has_pose. Does not travel over LCM.
  BoardMeasurement measurement;

  /// Inner corners row by row from the marker's top left, as fitted, in pixels of the (distorted) image; NaN where the
  /// corner was not seen. The first CornerCount(size) are used.
  std::array<Eigen::Vector2f, kMaxCorners> corners = NoCorners();
  int corners_used = 0;
  /// Root mean square of the distances between corners as seen one by one and as fitted, pixels.
  double reprojection_rms_px = 0;
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();  ///< of the board, in the image

  double luminance_overlap = 0;   ///< of the Gaussians of dark and light luminance, 0..0.5
  double saturation_overlap = 0;  ///< of the Gaussians of unsaturated and saturated saturation, 0..0.5
  int bits_corrected = 0;
  std::uint32_t warnings = 0;  ///< bits of Warning

  bool Has(Warning warning) const { return (warnings & static_cast<std::uint32_t>(warning)) != 0; }
};

/// What happened on the way, for status and for finding out why a marker was not read. Counts of one image.
struct DetectStats {
  int corner_candidates = 0;  ///< peaks of the ring response
  int corners = 0;            ///< of them, those that look like a saddle of four cells
  int grids = 0;              ///< groups of linked corners
  int boards = 0;             ///< groups anchored by a border
  int refused_border = 0;     ///< groups whose border fits no family, at any placement and turn
  int refused_fit = 0;        ///< boards that the photometric model does not explain, or that others have shown better
  int undecided = 0;          ///< boards whose identity is not decided
  int expected = 0;           ///< boards that a memory expected in the image
  int expected_read = 0;      ///< of them, those that were read there
  /// Boards, and places that may be boards, on which something was left undone because the budget did not last.
  int deferred = 0;
  std::int64_t searched_px = 0;  ///< pixels that were searched for corners
  /// Units of work, of about 1000 instructions of an x86-64 processor with AVX2 each. Counted as it is done, never by
  /// a clock: the same images in the same order give the same.
  std::uint64_t work = 0;
};

struct DetectTrace;

/// Finds markers. Holds scratch memory, so that nothing is allocated in the steady state: one Detector a thread.
class Detector {
 public:
  /// Throws std::runtime_error with DetectorOptions::Check's message if the options are not valid.
  explicit Detector(DetectorOptions options);
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// The markers of an image, in no particular order. Never throws on any image. Without a calibration of the image's
  /// size (options.camera of another width or height) poses are left out.
  std::vector<MarkerPose> Detect(const ImageView& image);
  /// The same into a vector whose memory is used again.
  /// @param trace if given, gets what every stage saw (chequer/detect_trace.h): for finding out why a marker is not
  ///   read. The markers are the same.
  void Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace = nullptr);

  /// The markers of the next frame of a stream: boards that the last frames taught are expected where their motion
  /// takes them and fitted there; the rest of the frame is searched in turns (DetectorOptions::search_every). A pose
  /// is that of its frame alone, as Detect(image) gives it: nothing is filtered. How far off it may be, the last frames
  /// tell, too, where a board's edges follow the pixels: what a camera's sharpening or JPEG does to them all, one board
  /// does not show. Depends on the image, the memory and the options alone.
  /// @param captured when the frame was taken, on any clock that runs on evenly.
  /// @param memory of the frames before; becomes that for the next. After a gap of more than 0.25 s, or in another
  ///   image size, it begins anew.
  void Detect(const ImageView& image, std::chrono::nanoseconds captured, DetectorMemory& memory,
              std::vector<MarkerPose>& markers, DetectTrace* trace = nullptr);

  /// Another DetectorOptions::budget, from the next image on. @pre 0 or at least kLeastBudget.
  void set_budget(std::uint64_t units);

  /// Of the last image.
  const DetectStats& stats() const;
  const DetectorOptions& options() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chequer

#pragma GCC visibility pop
