#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "chequer/detector.h"
#include "detect/boards/boards.h"
#include "detect/common/light.h"
#include "detect/common/search_regions.h"
#include "detect/common/visibility.h"
#include "detect/common/work_meter.h"
#include "detect/deferred_places.h"
#include "detect/fit/fit.h"
#include "detect/identity/marker_description.h"
#include "detect/memory/common_motion.h"
#include "detect/memory/expected_boards.h"
#include "detect/memory/memory.h"
#include "detect/tracer.h"
#include "detect/work_plan.h"

namespace chequer {

/// Smaller images, and parts of them, have no room for a board (a guess).
inline constexpr int kLeastSide = 16;

/// What became of a board.
struct BoardOutcome {
  /// Defined elsewhere: vectors fill values whose constructor is implicit with zeros first, all 9 kB of them.
  BoardOutcome();

  bool accepted = false;
  ImageTraits image;
  MarkerPose marker;
  Eigen::Matrix3d plane_from_board = Eigen::Matrix3d::Identity();
  std::uint64_t kernel = 0;      ///< that the id was read from
  BlurShape motion, blur_shape;  ///< of FittedBoard
  LightLevels light_levels;
  Visibility visibility;  ///< of FittedBoard, and by the cells' colours
  double moved_square = std::numeric_limits<double>::infinity();
  SharedEdgeErrors along_edges;     ///< of FittedBoard
  std::optional<BoardPoses> poses;  ///< with a calibration
  bool plain_covariance = false;    ///< only the plain fit tells the poses' covariance, of a board that needs another
  /// Of a board that was expected.
  struct Expected {
    bool agrees = false;           ///< its identity is not decided; what shows is the remembered one's
    bool carried_or_none = false;  ///< so little of it shows that it counts only if its identity is carried
    bool carried = false;          ///< its identity is the remembered one's
    bool contradicted = false;     ///< another was read where it was expected
    bool lies_elsewhere = false;   ///< nothing shows where it was expected that a fit comes near
  } expected;
  bool deferred = false;    ///< it was not fitted, or not as it should be
  bool wants_more = false;  ///< only the plain fit was done, and another may explain it better
  LearntBoard learnt;       ///< with this frame; empty where nothing was, or is to be
  WorkMeter work;

  bool is_read() const { return accepted && marker.id.has_value(); }
};

/// What the memory of a stream makes of a frame.
struct StreamState {
  bool is_one = false;  ///< the frame is of a stream
  bool learns = false;  ///< DetectorOptions::learn_levels
  int frames_on = 1;    ///< since the last frame of the stream
  FrameTime last_captured{};
  double ahead_s = 0;                                  ///< of the last frame
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  ///< of all boards, from where they were expected
  float contrast_share = 1;  ///< of what the expected boards showed in the last frame, in the median
  /// If the median board shows less of its last contrast, all may lie elsewhere, or blurred: half a cell off, no
  /// contrast is left (a guess).
  static constexpr float kContrastOfExpected = 0.8f;
  bool IsSharp() const { return contrast_share >= kContrastOfExpected; }
  /// Whether they may lie elsewhere by a part of a cell: a third of one leaves 0.84; of boards that the camera did not
  /// displace, 19 frames in 20 show 1.00 (measured).
  bool MayBeShifted() const { return contrast_share < 0.95f; }
  /// Whether boards do not show where they were expected, or blurred.
  bool IsKnocked() const { return !shift_px.isZero() || !IsSharp(); }
  /// Of the expected boards, those that are searched for before they are fitted there, by all means: such a fit would
  /// take several times as much.
  std::vector<bool> postponed;
  std::size_t missing = 0;             ///< of the expected boards, those that no fit has found there yet
  std::vector<std::size_t> lost;       ///< of them, those that are searched around
  std::vector<MovedBoard> moved;       ///< boards that were fitted, as far as they tell how the camera moved
  std::optional<CommonMotion> motion;  ///< of the camera; once enough boards tell it
  // What single steps need.
  std::vector<float> shares;
  std::vector<RememberedBoard> read;
};

/// What is known of one image. The steps fill it in; each says what it reads and what it adds.
struct ImageState {
  WorkPlan plan{0};
  WorkMeter work;
  DetectStats stats;
  std::vector<AnchoredBoard> boards;
  std::vector<BoardOutcome> outcomes;     ///< by board, once it was fitted
  std::vector<RememberedBoard> expected;  ///< the first of the boards, one each
  StreamState stream;
  SearchRegions regions;
  SearchRegions given_up;  ///< searched after all fits
  KnownTiles known;
  std::vector<PixelBox> open;         ///< what is to be searched in the next frame in any case
  std::vector<PixelBox> cut;          ///< grids at the ends of regions, which may go on beyond them
  std::optional<ImageTraits> traits;  ///< once a board has told them
  /// Of an earlier image (MemoryState::TraitsAhead): where there are some, the first board tells nothing but the noise.
  std::optional<ImageTraits> known_traits;
  double dot_gain = 0;   ///< of an earlier image (MemoryState::dot_gain)
  EdgeTally edge_tally;  ///< of earlier images (MemoryState::edge_tally)

  bool IsExpected(std::size_t board) const { return board < expected.size(); }
  /// Whether that board was read as the one which was expected there.
  bool WasRead(std::size_t board) const { return Reads(outcomes[board], expected[board]); }
  /// Adds what the edges of this image's boards tell.
  void AddEdgesTo(EdgeTally& tally) const;
  /// Whether a board that was expected is read elsewhere in the image: its id, and not of a copy of the marker that was
  /// expected there.
  bool ReadElsewhere(std::size_t board) const;
  /// Most of what was expected is not there, and as much was found elsewhere.
  bool IsAnotherPicture() const {
    return 2 * stream.missing > expected.size() && 2 * (boards.size() - expected.size()) > expected.size();
  }
  /// Of the first `count` boards, that for which clear(index) and which lies topmost in the image; 0 if there is none.
  /// The same one tells the image's traits whether it was found or expected, so that both give all boards the same.
  template <class Clear>
  std::size_t Topmost(std::size_t count, const Clear& clear) const {
    std::size_t first = 0;
    float top = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < count; ++i) {
      const float at = boards[i].box.Center().y();
      if (at >= top || !clear(i)) continue;
      top = at;
      first = i;
    }
    return first;
  }

 private:
  static bool Reads(const BoardOutcome& outcome, const RememberedBoard& board) {
    return outcome.accepted && outcome.marker.id == board.id && outcome.marker.family == board.family;
  }
};

/// Nothing covers it, and all of its corners were found.
bool ShowsAllCorners(const AnchoredBoard& board);
/// Whether the middle of a board lies on another.
inline bool LiesOn(const AnchoredBoard& board, const AnchoredBoard& other) {
  return LiesOn(board.plane_from_board, other.plane_from_board, other.size);
}
/// Whether poses of both families are the same of the same board.
inline bool AreCellsAlike(const DetectorOptions& options, int family, int other) {
  return options.families[static_cast<std::size_t>(family)].CellM() ==
         options.families[static_cast<std::size_t>(other)].CellM();
}
/// The outline of a board in the image.
std::array<Eigen::Vector2d, 4> OutlineOf(MarkerSize size, const Eigen::Matrix3d& plane_from_board, const Lens& lens);
/// How far at most the outline of a board lies from there, plane units.
double FarthestOff(const AnchoredBoard& board, const Eigen::Matrix3d& plane_from_board);

/// What the budget of the last image did not last for; empty without a budget.
struct Undone {
  DeferredPlaces grids, boards;  ///< that were not searched, or not to their end; that were not fitted, or not fully
  std::uint64_t second_look_most = 0;  ///< units of the second look that was left undone; 0: none was
};

/// An image on its way through the steps.
struct ImageJob {
  const DetectorOptions& options;
  const ImageView& image;
  const std::array<float, 256>& table;  ///< light of its values
  const LightReader& reader;            ///< the image as it is: boards are searched in it
  LightReader& measured;                ///< what the camera has measured of it: boards are fitted to that
  const Lens& lens;
  Tracer& tracer;
  ImageState& frame;
  Undone& undone;
  ExpectedBoards& expected_boards;

  /// Says that the image is still worked on.
  void TellProgress() const {
    if (options.on_progress) options.on_progress();
  }
  /// What lies in the box is left for the next image. @param waited images on end in which it was left undone.
  void Defer(const PixelBox& box, int waited, DeferredPlaces& places) const;
};

}  // namespace chequer
