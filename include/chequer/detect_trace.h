#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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
  kNoBorderInks,  ///< white or the saturations of the border cannot be told; the board is reported without an id
  kNoWord,        ///< the kernel is near no word of the code; reported without an id
  kTwoWords,      ///< another id is nearly as likely; reported without an id
};
inline constexpr int kRefusals = static_cast<int>(Refusal::kTwoWords) + 1;
/// "few_linked", …; "none".
std::string_view RefusalName(Refusal refusal);

/// A cell as it was sampled and judged.
struct TraceCell {
  Cell at;                                      ///< of the board, as it was thought to be turned
  Eigen::Vector2d center_px{0, 0};              ///< in the image
  std::array<Eigen::Vector2f, 4> outline_px{};  ///< corners, round the cell from its top left
  bool seen = false;                            ///< it stands out from its neighbours as its class should
  float luminance = 0;                          ///< 0..100
  float saturation = 0;                         ///< as CellColour: grows with the ink
  std::optional<bool> saturated;                ///< what it was judged to be; nothing where it was not judged
  std::optional<bool> expected;                 ///< of border cells: what it should be
  /// Of kernel cells: log P(saturated) − log P(unsaturated).
  float log_likelihood = 0;

  bool dark() const { return IsDark(at.row, at.col); }
};

/// A group of corners that came so far.
struct TraceCandidate {
  Refusal refusal = Refusal::kNone;
  double measured = 0;       ///< what the refusal is about …
  double required = 0;       ///< … and what it takes; see Explain()
  std::vector<int> corners;  ///< linked corners of a group, indices into DetectTrace::corners
  MarkerSize size;           ///< of the board that was tried, where there are cells
  /// Row by row; empty where it did not come so far.
  std::vector<TraceCell> cells;
  Eigen::Vector2d center_px{0, 0};
  int marker = -1;  ///< index into the markers found, where it is one
};

/// One sentence that says what refused a candidate, with the figures; for people.
std::string Explain(const TraceCandidate& candidate);

/// What every stage of a detection saw. Filled by Detector::Detect where one is given; costs time and memory then.
struct DetectTrace {
  struct Corner {
    Eigen::Vector2f position_px{0, 0};
    float contrast = 0;  ///< grey levels
    float scale = 1;     ///< image pixels per pixel of the level it was found in
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
};

}  // namespace chequer

#pragma GCC visibility pop
