#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/geometry.h"
#include "chequer/hidden.h"
#include "chequer/marker.h"

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// What kept a group of corners from being read as a marker, in the order in which the stages ask: the later, the
/// farther it came.
enum class Refusal : std::uint8_t {
  kNone,
  // A group of linked corners
  kFewLinked,       ///< fewer corners hang together than determine where a board lies
  kUneven,          ///< they hang together, but the steps between them change too much for a plane
  kNotOneLattice,   ///< larger than any board, or of corners that belong to another
  kFewCorners,      ///< no place of a board of any size sought holds enough of its corners
  kNoYellow,        ///< the light border cells that should be yellow return as much blue as the white ones
  kCellsDoNotShow,  ///< too few cells are lighter or darker than their neighbours, as they should be
  kBorderUnseen,    ///< too little of the border can be judged
  kInksAlike,       ///< the border's saturated and unsaturated cells do not stand apart
  kBorderDiffers,   ///< the border shows other saturations than a marker's
  kRivalled,        ///< another place or turn explains the border nearly as well
  kGoesOn,          ///< the pattern goes on beyond the border: tiles, a chessboard
  kNotPlane,        ///< its corners lie on no plane
  // A board that its border has told
  kNoFit,         ///< the model of cells, edges and blur finds no place in the image's pixels
  kNoise,         ///< the cells stand out too little from what the model does not explain
  kCornersOff,    ///< corners lie elsewhere than a plane puts them
  kCellsHidden,   ///< more than half of the cells do not stand out as they should
  kNoPose,        ///< seen from no side with that lens
  kSeenTwice,     ///< it is a marker that other corners have shown better
  kNoBorderInks,  ///< white or the saturations of the border cannot be told; the board is reported without an id
  kNoWord,        ///< the kernel is near no word of the code; reported without an id
  kTwoWords,      ///< another id is nearly as likely; reported without an id
};
inline constexpr int kRefusals = static_cast<int>(Refusal::kTwoWords) + 1;
/// "few_linked", …; "none".
std::string_view RefusalName(Refusal refusal);

/// A cell as it was sampled and judged.
struct TraceCell {
  Cell at;                          ///< of the board, as it was thought to be turned
  Eigen::Vector2d center_px{0, 0};  ///< in the image
  /// Corners, round the cell from its top left; all one point where HasPlace is false.
  std::array<Eigen::Vector2f, 4> outline_px = Zeros<Eigen::Vector2f, 4>();
  bool seen = false;              ///< it stands out from its neighbours as its class should
  Hidden hidden = Hidden::kNot;   ///< of a cell that is not seen and was placed by a board: why not
  float luminance = 0;            ///< 0..100
  float saturation = 0;           ///< as CellColour: grows with the ink
  std::optional<bool> saturated;  ///< what it was judged to be; nothing where it was not judged
  std::optional<bool> expected;   ///< of border cells: what it should be
  /// Of kernel cells: log P(saturated) − log P(unsaturated).
  float log_likelihood = 0;

  bool dark() const { return IsDark(at.row, at.col); }
  /// Whether it is known where it lies: no corners near it may have been found.
  bool HasPlace() const { return outline_px[0] != outline_px[2]; }
};

/// A group of corners that came so far.
struct TraceCandidate {
  Refusal refusal = Refusal::kNone;
  double measured = 0;       ///< what the refusal is about …
  double required = 0;       ///< … and what it takes; see Explain()
  std::vector<int> corners;  ///< linked corners of a group, indices into DetectTrace::corners
  int place = -1;            ///< index into DetectTrace::places, where a second look found it
  MarkerSize size;           ///< of the board that was tried, where there are cells
  /// Row by row; empty where it did not come so far.
  std::vector<TraceCell> cells;
  /// By inner corner, row by row, as the fit used them for the pose; empty where there was none.
  std::vector<Hidden> inner_corners;
  Eigen::Vector2d center_px{0, 0};
  int marker = -1;  ///< index into the markers found, where it is one

  /// Whether it came as far as to be sampled as a board.
  bool CameFar() const { return !cells.empty(); }
};

/// One sentence that says what refused a candidate, with the figures; for people.
std::string Explain(const TraceCandidate& candidate);

/// What became of a place that is full of strong contrasts although the first look found no board there.
enum class PlaceFate : std::uint8_t {
  kViewed,     ///< stretched, squeezed or sharpened, and searched again
  kTooMany,    ///< would have been viewed, had other places of the image not been before it
  kSparse,     ///< slanted, but a board with cells so large leaves more contrasts
  kLine,       ///< they lie along a line: no view of them would show cells
  kFrontal,    ///< they spread as those of a board in plain view do, which the first look should have found: viewed
               ///< only if they are many
  kTooLarge,   ///< they spread farther than over a board
  kFewPoints,  ///< too few contrasts hang together for a board
};

/// A place that was considered for a second look, for boards seen at a steep slant or smeared by motion.
struct TracePlace {
  PlaceFate fate = PlaceFate::kViewed;
  Eigen::Vector2d center_px{0, 0};
  /// Of what was viewed; elsewhere, about of a board that has its corners there. Corners, round it.
  std::array<Eigen::Vector2f, 4> outline_px = Zeros<Eigen::Vector2f, 4>();
  int points = 0;      ///< strong contrasts
  double cell_px = 0;  ///< the shorter side of the cells, if these were a board's corners
  double slant = 1;    ///< how many times longer than wide they spread
  /// The spread is that of what changes from pixel to pixel around the points, which tell too little.
  bool by_change = false;

  // Where it was viewed:
  bool sharpened =
      false;      ///< it shows stripes, as of a board that moved or is very narrow: the view has them made even
  int views = 0;  ///< each placed by what the one before showed; what follows is of the last
  /// Grey levels, row by row, `side` × `side`: what was searched. Cells of a board are about square in it.
  std::vector<std::uint8_t> view;
  int side = 0;
  Eigen::Matrix<float, 2, 3> image_from_view = Eigen::Matrix<float, 2, 3>::Zero();  ///< of its pixels
  int corners = 0;
  int most_linked = 0;  ///< corners of the largest group
  int boards = 0;       ///< anchored, that were not known
};

/// One sentence that says why a place was viewed or not and what it showed, with the figures; for people.
std::string Explain(const TracePlace& place);

/// What became of a board that a memory expected in the image.
enum class ExpectedFate : std::uint8_t {
  kRead,      ///< its identity was read there
  kCarried,   ///< too much of it is occluded to read its identity: it goes on with the one it had
  kNoId,      ///< a board lies there whose identity is not decided, and it does not carry the one it had
  kOther,     ///< the board that lies there reads otherwise: the memory was dropped, and its place searched
  kLost,      ///< no board fits there: its place was searched
  kDeferred,  ///< the budget did not last for it
};

/// A board that a memory expected.
struct TraceExpected {
  ExpectedFate fate = ExpectedFate::kLost;
  std::uint64_t id = 0;
  /// Where it was expected, the shift of all boards included: its corners in the image, round it.
  std::array<Eigen::Vector2f, 4> outline_px = Zeros<Eigen::Vector2f, 4>();
  Eigen::Vector2d center_px{0, 0};  ///< there
  /// From where its centre was expected to where the fit has it; zero where there is no fit.
  Eigen::Vector2d off_px{0, 0};
  double ago_s = 0;  ///< since its identity was last read
};

/// One sentence that says what became of it, with the figures; for people.
std::string Explain(const TraceExpected& expected);

/// What every stage of a detection saw. Filled by Detector::Detect where one is given; costs time and memory then.
struct DetectTrace {
  struct Corner {
    Eigen::Vector2f position_px{0, 0};
    float contrast = 0;  ///< grey levels
    float scale = 1;     ///< image pixels per pixel of the level it was found in
    int place = -1;      ///< whose view showed it; -1: the first look
  };
  struct Link {
    int from = 0, to = 0;    ///< corners
    bool in_square = false;  ///< a side of a closed square of four: only such links make groups
  };
  /// Peaks of the ring response that are no corners: around them light and dark do not change four times.
  std::vector<Eigen::Vector2f> refused_peaks_px;
  std::vector<Corner> corners;
  std::vector<Link> links;
  /// First what was anchored by a border, in the order of the boards, then what was not.
  std::vector<TraceCandidate> candidates;
  /// In the order in which they were considered.
  std::vector<TracePlace> places;
  /// Of a frame with a memory.
  std::vector<TraceExpected> expected;
  /// By which all boards lay elsewhere than expected, as the camera was moved.
  Eigen::Vector2d shift_px{0, 0};
};

}  // namespace chequer

#pragma GCC visibility pop
