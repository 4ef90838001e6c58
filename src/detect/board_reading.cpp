#include "detect/board_reading.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "detect/camera_motion.h"
#include "detect/identity/marker_description.h"
#include "detect/pose/rolling_shutter.h"

namespace chequer {
namespace {

/// Least contrast of a board over the noise of a pixel (a guess).
constexpr double kLeastSignal = 2.5;

/// Largest corner error of a board, px. Even with 8 px of motion blur, corners lie on their plane to 0.15 px; half a
/// pixel off, it is no board.
constexpr double kMostDeviationPx = 0.5;

/// A followed board lies this near to where it was expected. A fit that was pulled along the pattern lies a whole cell
/// off (a guess below that).
constexpr double kMostOffCells = 0.4;

/// Blur of a board before it is fitted, pixels of the level where its corners were found (a guess).
constexpr double kBlurOfLevel = 0.8;

/// Of a board's cells as printed, height over width.
double CellRatioOf(MarkerSize size, const DetectorOptions& options) {
  for (const MarkerFamily& family : options.families)
    if (family.code.size() == size) return family.CellM().y() / family.CellM().x();
  return 1;
}

/// How far inks of boards of that size may lie out of register, along the board's axes, cells.
Eigen::Vector2d RegisterOf(MarkerSize size, const DetectorOptions& options) {
  Eigen::Vector2d cells = Eigen::Vector2d::Zero();
  for (const MarkerFamily& family : options.families)
    if (family.code.size() == size)
      cells = cells.cwiseMax(options.print_tolerance.register_m * family.CellM().cwiseInverse());
  return cells;
}

/// Whether a fit gives the board up, and it is searched for, if it does not show where it was expected. Of boards that
/// a knocked camera blurs, the first is fitted by all means: it tells how the others moved.
bool MayBeGivenUp(const ImageState& frame, const FitOrder& order) {
  const bool first_of_knocked = frame.stream.IsKnocked() && order.image == nullptr;
  return frame.IsExpected(order.board) && !frame.stream.postponed[order.board] && !first_of_knocked;
}

/// Whether a board is thought to lie next to where it is expected, or was found near there: one in plain view by its
/// edges, which motion blur would show elsewhere.
bool LiesNear(const ImageState& frame, std::size_t board) {
  if (!frame.IsExpected(board)) return false;
  const AnchoredBoard& anchored = frame.boards[board];
  if (anchored.found_near == FoundNear::kByCellsAndEdges && ShowsAllCorners(anchored) && !ShowsMotion(frame))
    return true;
  return !frame.stream.IsKnocked() && frame.expected[board].lay_near();
}

/// Whether boards that move are sheared, and memories may tell how: a rolling shutter's frames of a stream.
bool ShearsBoards(const ImageJob& job) { return job.lens.row_s() > 0 && job.frame.stream.is_one; }

/// Whether a board turns so much while a rolling shutter reads its rows that its edges are bent: at its rim by so many
/// pixels or more, which is what bends of paper begin to count from (a guess). One that is new in a stream may.
bool TurnsOverRows(const ImageJob& job, std::size_t board) {
  constexpr double kBentPx = 0.01;
  if (!ShearsBoards(job)) return false;
  if (!job.frame.IsExpected(board) || !job.frame.expected[board].is_followed()) return true;
  const RememberedBoard& last = job.frame.expected[board];
  const double spin = TurnBetween(last.motion.before, last.plane_from_board) / last.motion.before_s;
  const AnchoredBoard& anchored = job.frame.boards[board];
  const double rim_px =
      0.5 * std::max(anchored.size.rows, anchored.size.cols) *
      std::sqrt(std::abs(BoardPoint(BoardGeometry(anchored.plane_from_board), job.lens).pixel_by_board.determinant()));
  return std::abs(spin) * job.lens.row_s() * rim_px * rim_px > kBentPx;
}

PhotometricFit::Start StartOf(const ImageJob& job, const FitOrder& order) {
  using TraitsFrom = BoardFit::Start::TraitsFrom;
  const AnchoredBoard& board = job.frame.boards[order.board];
  const RememberedBoard* last = job.frame.IsExpected(order.board) ? &job.frame.expected[order.board] : nullptr;
  PhotometricFit::Start start{
      .board = {.size = board.size,
                .cell_ratio = CellRatioOf(board.size, job.options),
                .geometry = BoardGeometry(board.plane_from_board),
                .blur_px = kBlurOfLevel * board.scale,
                .light = board.light,
                .saturated = board.saturated,
                .visibility = board.visibility,
                .found = board.found,
                .predicted = last != nullptr,
                .near = LiesNear(job.frame, order.board),
                .register_cells = RegisterOf(board.size, job.options),
                .turns_over_rows = TurnsOverRows(job, order.board),
                .blur_shape = last ? last->blur_shape : BlurShape{},
                .own_blur_px = last ? last->blur_px : 0,
                .light_levels = last ? last->light_levels : LightLevels{},
                .image = order.image,
                .image_from = job.frame.traits ? TraitsFrom::kOtherBoard : TraitsFrom::kEarlierImage,
                .dot_gain = order.image ? order.image->dot_gain : job.frame.dot_gain,
                .edge_tally = job.frame.edge_tally},
      .motion_blurred = board.motion_blurred,
      .most_units = order.most_units,
      .plain_only = order.plain_only,
      .may_lie_elsewhere = MayBeGivenUp(job.frame, order)};
  if (board.motion_blurred && order.image) start.motion.way_px = order.image->motion_px;
  FollowCamera(job, order.board, start);
  return start;
}

/// Of the cells that show, where some are overexposed.
LightLevels LightLevelsOf(const FittedBoard& fitted, const AnchoredBoard& board) {
  LightLevels mean;
  std::array<float, 2> count{};
  float lightest = 0;
  ForCells(board.size, [&](std::size_t cell, int row, int col) {
    if (IsDark(row, col) || !fitted.visibility.Shows(cell)) return;
    const std::size_t ink = board.saturated[cell] != 0;
    mean.of_ink[ink] += fitted.levels[cell];
    ++count[ink];
    lightest = std::max(lightest, fitted.levels[cell].maxCoeff());
  });
  if (lightest < LightLevels::kOverexposed) return {};
  for (std::size_t ink = 0; ink < 2; ++ink) mean.of_ink[ink] /= std::max(count[ink], 1.0f);
  return mean;
}

/// Whether what shows of a board that was expected, and whose identity is not decided, lies where it was expected and
/// is the remembered one's.
bool AgreesWithExpected(const ImageJob& job, std::size_t board, const FittedBoard& fitted, const Identity& identity,
                        const Identifier& identifier) {
  if (!job.frame.IsExpected(board) || !identity.saturation_told) return false;
  const AnchoredBoard& expected = job.frame.boards[board];
  const double cell = BoardGeometry(expected.plane_from_board).CellSide();
  return FarthestOff(expected, fitted.geometry.plane_from_board()) < kMostOffCells * cell &&
         AgreesWith(job.expected_boards.EvidenceOf(job.frame.expected[board], identifier));
}

/// Width and height of a board's cells: of the marker that it is, or that was followed there.
/// @param agrees whether it is as the board that was expected.
Eigen::Vector2d CellOf(const ImageJob& job, const Identity& identity, std::size_t board, bool agrees) {
  const MarkerFamily& family = job.options.families[static_cast<std::size_t>(identity.family)];
  if (identity.id_decided) return family.CellM(identity.decoded->id);
  if (!agrees || !AreCellsAlike(job.options, identity.family, job.frame.expected[board].family)) return family.CellM();
  // It may be given the identity of the board that was expected there.
  const RememberedBoard& expected = job.frame.expected[board];
  return job.options.families[static_cast<std::size_t>(expected.family)].CellM(expected.id);
}

/// What the memory has of a board: of the one that was expected there, or of its marker, where no copies of that were
/// expected and it went no farther than a copy could come. Null: nothing.
const RememberedBoard* LastOf(const ImageState& frame, std::size_t board, const Identity& identity,
                              const BoardGeometry& now) {
  if (frame.IsExpected(board)) return &frame.expected[board];
  const RememberedBoard* last = nullptr;
  for (const RememberedBoard& expected : frame.expected) {
    if (!identity.id_decided || expected.id != identity.decoded->id || expected.family != identity.family) continue;
    if (last) return nullptr;
    last = &expected;
  }
  const double side = now.CellSide() * std::min(frame.boards[board].size.rows, frame.boards[board].size.cols);
  return last && (BoardGeometry(last->plane_from_board).ToPlane({0, 0}) - now.ToPlane({0, 0})).norm() < side ? last
                                                                                                             : nullptr;
}

/// Where the last frames showed a board. @param last what the memory has of it; null: nothing.
RecentPlaces PlacesOf(const RememberedBoard* last, double ahead_s, const Eigen::Matrix3d& now) {
  if (!last) return {};
  BoardMotion motion;
  motion.Learn(last->motion, last->plane_from_board, ahead_s, now);
  return {.last = last->plane_from_board,
          .last_s = ahead_s,
          .before = last->motion.before,
          .before_s = last->motion.before_s,
          .off = std::sqrt(BoardMotion::MeanOf(motion.off[BoardMotion::kChanging])),
          .turned_off = std::sqrt(BoardMotion::MeanOf(motion.turned_off[BoardMotion::kTurnChanges]))};
}

/// Undoes what a rolling shutter does to a board of a stream.
void UndoRollingShutter(const ImageJob& job, std::size_t board, const Identity& identity, BoardMeasurement& measured) {
  if (!ShearsBoards(job)) return;
  const RememberedBoard* last = LastOf(job.frame, board, identity, BoardGeometry(measured.plane_from_board));
  UndoRollingShutter(PlacesOf(last, job.frame.stream.ahead_s, measured.plane_from_board), job.frame.boards[board].size,
                     job.lens, measured);
}

/// What was measured of a board that was fitted.
BoardMeasurement Measure(const ImageJob& job, std::size_t board, const FittedBoard& fitted, const Identity& identity,
                         bool agrees) {
  const Eigen::Vector2d cell_m = CellOf(job, identity, board, agrees);
  BoardMeasurement measured =
      MeasurementOf(fitted, job.frame.boards[board].size, cell_m, job.options.print_tolerance, job.lens);
  UndoRollingShutter(job, board, identity, measured);
  return measured;
}

struct PosesOnPaper {
  std::optional<BoardPoses> poses;
  bool may_bend = false;  ///< they are a mean of flat and bent paper
};

PosesOnPaper FindPoses(const BoardMeasurement& measured, const FittedBoard& fitted) {
  PosesOnPaper found{.poses = PosesOf(measured)};
  if (!found.poses) return found;
  const std::optional<BoardMeasurement> bent = AllowForBend(fitted.bend, measured, found.poses->poses[0]);
  found.may_bend = bent.has_value();
  if (bent) found.poses = PosesOf(*bent);
  return found;
}

/// PhotometricFit::StepOn().
bool StepOn(const ImageJob& job, const FittedBoard& fitted, PhotometricFit& fit, BoardOutcome& outcome) {
  const bool stepped = fit.StepOn(job.measured, job.lens, fitted);
  outcome.work.Add(fit.work());
  return stepped;
}

/// PhotometricFit::FitWithout().
void FitWithout(const ImageJob& job, const FittedBoard& fitted, const Visibility& shows, PhotometricFit& fit,
                BoardOutcome& outcome) {
  fit.FitWithout(job.measured, job.lens, fitted, shows);
  outcome.work.Add(fit.work());
}

/// Makes the pose better by what was learnt of the board, nothing else: all that is found in a stream is the same
/// without it. Whether it does.
bool UseLearntLevels(const ImageJob& job, std::size_t board, const FittedBoard& fitted, PhotometricFit& fit,
                     BoardOutcome& outcome) {
  if (!job.frame.stream.learns) return false;
  if (job.frame.IsExpected(board)) outcome.learnt = job.frame.expected[board].learnt;
  const bool used = fit.UseLearntLevels(fitted, outcome.learnt);
  outcome.work.Add(fit.work());
  return used;
}

}  // namespace

BoardOutcome ReadBoard(const ImageJob& job, const FitOrder& order, BoardReader& reader) {
  job.TellProgress();
  const std::size_t index = order.board;
  const MarkerSize size = job.frame.boards[index].size;
  BoardOutcome outcome;
  const FittedBoard* fitted = reader.fit.Fit(job.measured, job.lens, StartOf(job, order));
  outcome.wants_more = reader.fit.wants_more();
  outcome.expected.lies_elsewhere = reader.fit.lies_elsewhere();
  outcome.work.Add(reader.fit.work());
  outcome.work.Add(WorkStep::kReading);
  const auto refuse = [&](Refusal why, double measured = 0, double required = 0) {
    job.tracer.Refuse(index, why, measured, required);
    return outcome;
  };
  if (!fitted) return refuse(Refusal::kNoFit);
  if (fitted->signal_to_noise < kLeastSignal) return refuse(Refusal::kNoise, fitted->signal_to_noise, kLeastSignal);
  if (fitted->reprojection_rms_px > kMostDeviationPx)
    return refuse(Refusal::kCornersOff, fitted->reprojection_rms_px, kMostDeviationPx);
  Identity identity = reader.identifier.Identify(*fitted, size, job.measured, job.lens);
  outcome.work.Add(WorkStep::kMixedPixel, identity.mixed_pixels);
  // What the colours show to be covered, if in part, pulled the pose.
  if (identity.saturation_told) FitWithout(job, *fitted, reader.identifier.WhollyVisible(), reader.fit, outcome);
  job.tracer.Read(index, *fitted, identity, reader.identifier, job.lens);
  if (!identity.id_decided || !identity.plausible)
    outcome.expected.agrees = AgreesWithExpected(job, index, *fitted, identity, reader.identifier);
  if (!identity.plausible) {
    if (!outcome.expected.agrees) return refuse(Refusal::kCellsHidden);
    // Too little shows for a board that is not followed: it counts only with the identity that it had.
    outcome.expected.carried_or_none = true;
    identity.id_decided = false;
  }
  const auto find_poses = [&] {
    return job.lens.calibrated() ? FindPoses(Measure(job, index, *fitted, identity, outcome.expected.agrees), *fitted)
                                 : PosesOnPaper{};
  };
  PosesOnPaper found = find_poses();
  // How likely a bend is follows from what corners are off by: the fit has to be near its end.
  if (found.may_bend && StepOn(job, *fitted, reader.fit, outcome)) found = find_poses();
  outcome.plane_from_board = fitted->geometry.plane_from_board();
  const bool learnt = UseLearntLevels(job, index, *fitted, reader.fit, outcome);
  if (learnt) found = find_poses();
  if (job.lens.calibrated() && !found.poses) return refuse(Refusal::kNoPose);
  outcome.poses = found.poses;
  outcome.accepted = true;
  if (identity.id_decided) outcome.kernel = identity.decoded->kernel;
  outcome.image = fitted->image;
  outcome.motion = fitted->motion;
  outcome.along_edges = fitted->along_edges;
  outcome.blur_shape = fitted->blur_shape;
  outcome.light_levels = LightLevelsOf(*fitted, job.frame.boards[index]);
  outcome.moved_square = fitted->moved_square;
  outcome.visibility = identity.saturation_told ? reader.identifier.visibility() : fitted->visibility;
  Describe(*fitted, identity, job.options, job.lens, outcome.marker);
  if (learnt && outcome.poses) Set(outcome.marker, Warning::kLevelsLearnt);
  outcome.plain_covariance = reader.fit.cut_short();
  return outcome;
}

}  // namespace chequer
