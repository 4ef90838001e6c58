#include "detect/expected_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "core/median.h"
#include "detect/memory/common_shift.h"
#include "detect/memory/edge_follow.h"

namespace chequer {
namespace {

/// Cost of the search for a common shift for one board, in units of WorkStep::kPlace (measured, of 10 px cells).
constexpr std::uint64_t kPlacesOfShift = 10;
/// The same of the search for the shift of one board by itself.
constexpr std::uint64_t kPlacesOfOwnShift = 2;
/// Boards that show less of their contrast are followed: they lie a quarter of a cell or more from where they are
/// expected (measured), and a fit from there would take two to five steps more.
constexpr double kContrastAtPlace = 0.9;
/// A board of cells with room for edges was found if it shows this share of its contrast there (a guess). A shift by
/// one cell along both axes matches 25 of 36 cells, and shows less. Smaller cells are not asked: sampled between
/// pixels, they show less where they were found, too.
constexpr double kContrastFollowed = 0.85;
/// Share of the remaining budget that the search for a common shift may take (a guess; a search of the image takes
/// less).
constexpr double kMostOfBudgetForShift = 0.25;
/// Boards that lie so near to the median shift share it, if most do; and it is one from there on, px (guesses).
constexpr double kSharedPx = 1, kLeastSharedPx = 0.5;
/// Boards that went as far since the frame before may have turned off since the last one, px: others lie where they are
/// expected (a guess).
constexpr double kMayTurnOffPx = 0.5;

/// Most: two thirds (a guess).
bool IsMost(std::size_t count, std::size_t all) { return 3 * count > 2 * all; }

Eigen::Vector2d CenterPx(const Eigen::Matrix3d& place, const Lens& lens) {
  return lens.ToImage(place.col(2).hnormalized());
}

/// Places an expected board there; false, and leaves it, where that is outside the image.
bool Place(const ImageJob& job, std::size_t board, const Eigen::Matrix3d& place, FoundNear found_near) {
  AnchoredBoard moved;
  if (!job.expected_boards.Expect(job.frame.expected[board], place, job.reader, job.lens, moved)) return false;
  moved.found_near = found_near;
  job.frame.boards[board] = moved;
  return true;
}

/// Where its motion takes a board.
Eigen::Matrix3d AheadOf(const ImageState& frame, std::size_t board) {
  return frame.expected[board].Ahead(frame.stream.ahead_s);
}

/// Boards that are asked for the common shift, by what is left of the budget; 0: too few.
std::size_t AskedForShift(const ImageState& frame) {
  const double left = kMostOfBudgetForShift * static_cast<double>(frame.plan.Left(frame.work.units())),
               of_a_board =
                   kPlacesOfShift * WorkMeter::Instructions(WorkStep::kPlace) / WorkMeter::kInstructionsPerUnit;
  const std::size_t asked =
      static_cast<std::size_t>(std::min(left / of_a_board, static_cast<double>(kMostAskedForShift)));
  return asked < kFewestAskedForShift ? 0 : asked;
}

/// Takes a board to where it lies, by the contrast of its cells: some pixels from where it is expected. False where it
/// does not show there.
bool FollowCells(const ImageJob& job, std::size_t board) {
  ImageState& frame = job.frame;
  const AnchoredBoard before = frame.boards[board];
  frame.work.Add(WorkStep::kPlace, kPlacesOfOwnShift);
  const Eigen::Vector2d shift_px = FindOwnShift(before, job.reader, job.lens, frame.stream.shares);
  if (shift_px.isZero() ||
      !Place(job, board, Shifted(before.plane_from_board, shift_px, job.lens), FoundNear::kByCells))
    return false;
  if (!HasEdgesToFollow(before, job.lens) || ShowsShare(frame, board, kContrastFollowed)) return true;
  frame.boards[board] = before;
  return false;
}

/// The same by the edges between its cells, for one that lies nearer.
void FollowItsEdges(const ImageJob& job, std::size_t board) {
  ImageState& frame = job.frame;
  const AnchoredBoard& anchored = frame.boards[board];
  frame.work.Add(WorkStep::kCellSample, anchored.light.size());
  const std::optional<Eigen::Matrix3d> place = FollowEdges(anchored, job.reader, job.lens);
  const bool by_cells = anchored.found_near == FoundNear::kByCells;
  if (place) Place(job, board, *place, by_cells ? FoundNear::kByCellsAndEdges : FoundNear::kNot);
}

/// The shift that most of some boards share, px; zero where there is none.
Eigen::Vector2d SharedShift(std::span<const Eigen::Vector2d> shifts_px, std::vector<float>& values) {
  Eigen::Vector2d shared;
  for (const int axis : {0, 1}) {
    values.clear();
    for (const Eigen::Vector2d& shift : shifts_px) values.push_back(static_cast<float>(shift[axis]));
    shared[axis] = double{MedianInPlace(values)};
  }
  const auto share = std::count_if(shifts_px.begin(), shifts_px.end(),
                                   [&](const Eigen::Vector2d& shift) { return (shift - shared).norm() < kSharedPx; });
  const bool is_shared = IsMost(static_cast<std::size_t>(share), shifts_px.size()) && shared.norm() >= kLeastSharedPx;
  return is_shared ? shared : Eigen::Vector2d::Zero();
}

/// Asks some boards, each by itself, which takes a fifth of what the search for a common shift does. Where most show
/// near to where they are expected: the shift that they share, or none. Nothing where they do not.
std::optional<Eigen::Vector2d> SharedShiftOfNear(const ImageJob& job, std::size_t asked) {
  ImageState& frame = job.frame;
  const std::size_t count = frame.boards.size(), step = std::max<std::size_t>(1, (count + asked - 1) / asked);
  std::array<Eigen::Vector2d, kMostAskedForShift> shifts_px;
  std::size_t near = 0, all = 0;
  for (std::size_t i = 0; i < count; i += step, ++all) {
    if (!ShowsShare(frame, i, kContrastAtPlace) && !FollowCells(job, i)) continue;
    shifts_px[near++] = CenterPx(frame.boards[i].plane_from_board, job.lens) - CenterPx(AheadOf(frame, i), job.lens);
  }
  if (!IsMost(near, all)) return std::nullopt;
  return SharedShift(std::span(shifts_px).first(near), frame.stream.shares);
}

/// How much of their contrast the boards show, in the median.
void TellContrastShare(ImageState& frame) {
  std::vector<float>& shares = frame.stream.shares;
  shares.clear();
  for (std::size_t i = 0; i < frame.expected.size(); ++i)
    shares.push_back(static_cast<float>(SampledContrast(frame.boards[i]) / frame.expected[i].contrast));
  if (!shares.empty()) frame.stream.contrast_share = MedianInPlace(shares);
}

/// Where most of the boards do not show where they are expected, moves all by the shift that they share. False where
/// most do not show near there either, which motion blur hides.
bool FollowShift(const ImageJob& job) {
  ImageState& frame = job.frame;
  // What has moved by itself since it was found does not tell how a camera moved.
  if (frame.expected.empty() || !frame.stream.MayBeShifted() || !MostAreFollowed(frame)) return true;
  const std::size_t asked = AskedForShift(frame);
  if (asked == 0) return true;
  const std::optional<Eigen::Vector2d> of_near = SharedShiftOfNear(job, asked);
  if (of_near) {
    frame.stream.shift_px = *of_near;
  } else {
    for (std::size_t i = 0; i < frame.expected.size(); ++i)
      if (frame.boards[i].found_near != FoundNear::kNot) Place(job, i, AheadOf(frame, i), FoundNear::kNot);
    frame.stream.shift_px = FindCommonShift(frame.boards, asked, job.reader, job.lens, frame.stream.shares);
    frame.work.Add(WorkStep::kPlace, kPlacesOfShift * std::min(frame.boards.size(), asked));
  }
  if (frame.stream.shift_px.isZero()) return of_near.has_value();
  for (std::size_t i = 0; i < frame.expected.size();) {
    if (Place(job, i, Shifted(AheadOf(frame, i), frame.stream.shift_px, job.lens), FoundNear::kNot)) {
      ++i;
      continue;
    }
    const std::ptrdiff_t out = static_cast<std::ptrdiff_t>(i);
    frame.boards.erase(frame.boards.begin() + out);
    frame.expected.erase(frame.expected.begin() + out);
  }
  return of_near.has_value();
}

/// Whether a board may have turned off since the last frame: it does not lie where it did, nor as expected.
bool MayHaveTurnedOff(const ImageJob& job, std::size_t board) {
  const RememberedBoard& expected = job.frame.expected[board];
  if (!expected.is_followed() || expected.lay_near() || job.frame.stream.IsKnocked()) return false;
  return (CenterPx(job.frame.boards[board].plane_from_board, job.lens) - CenterPx(expected.plane_from_board, job.lens))
             .norm() >= kMayTurnOffPx;
}

/// Moves boards that are near to where they are expected, but not there. @param all also those whose cells are large
/// enough for edges, which a fit mostly finds by itself
void FollowOwnWays(const ImageJob& job, bool all) {
  ImageState& frame = job.frame;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) {
    const bool has_edges = HasEdgesToFollow(frame.boards[i], job.lens);
    if ((all || !has_edges) && !ShowsShare(frame, i, kContrastAtPlace)) FollowCells(job, i);
    const bool is_near = frame.boards[i].found_near == FoundNear::kByCells || MayHaveTurnedOff(job, i);
    if (is_near && has_edges) FollowItsEdges(job, i);
  }
}

}  // namespace

bool ShowsShare(const ImageState& frame, std::size_t board, double share) {
  return SampledContrast(frame.boards[board]) >= share * frame.expected[board].contrast;
}

bool MostAreFollowed(const ImageState& frame) {
  const auto followed = std::count_if(frame.expected.begin(), frame.expected.end(),
                                      [](const RememberedBoard& board) { return board.is_followed(); });
  return 2 * static_cast<std::size_t>(followed) > frame.expected.size();
}

void FollowPlaces(const ImageJob& job) {
  ImageState& frame = job.frame;
  TellContrastShare(frame);
  const bool lie_near = FollowShift(job);
  FollowOwnWays(job, lie_near);
  // Boards that went each its own way are as sharp as they were.
  if (frame.stream.shift_px.isZero()) TellContrastShare(frame);
}

}  // namespace chequer
