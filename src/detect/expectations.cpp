#include "detect/expectations.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/median.h"
#include "detect/camera_motion.h"
#include "detect/expected_places.h"
#include "detect/identity/marker_description.h"
#include "detect/memory/common_shift.h"
#include "detect/region_choice.h"

namespace chequer {
namespace {

/// A board that shows less contrast than before may be blurred: its remembered contrast falls by no more than this
/// factor a frame (a guess).
constexpr double kContrastKept = 0.9;
/// A board that shows less of it is not where it was expected: half a cell off leaves none. One that moved while the
/// shutter was open shows more, and is missed by the plain fit alone. (With half or more, which would spare boards of
/// 3 px cells fits that begin a third of a cell off, 2 to 5 % less are read in knocks.)
constexpr double kContrastThatIsThere = 0.25;
/// Boards in plain view show this share of the contrast of the clearest one, each relative to its own in the last frame
/// (a guess).
constexpr double kClearAmongAll = 0.8;
/// Of what earlier frames said of edges that follow the pixels, so much counts beside what this one says: some hundred
/// frames, as the light, and with it what noise hides, may change (a guess).
constexpr double kEdgesKept = 0.99;

/// Whether some of a board's contrast shows where it was expected.
bool Shows(const ImageState& frame, std::size_t board) {
  return SampledContrast(frame.boards[board]) > kContrastThatIsThere * frame.expected[board].contrast;
}

/// Whether too little of it shows there.
bool MayLieElsewhere(const ImageState& frame, std::size_t board) {
  if (frame.expected[board].is_followed()) return !Shows(frame, board);
  // Where it went is not known.
  return !ShowsShare(frame, board, double{StreamState::kContrastOfExpected});
}

/// The first board tells the image's traits: makes it one that shows as it did in the last frame.
void LeadWithClearest(ImageState& frame) {
  // It gives the noise and blur, which an occlusion would falsify.
  const auto clearness = [&](std::size_t i) {
    const AnchoredBoard& board = frame.boards[i];
    if (!ShowsAllCorners(board)) return 0.0;
    return SampledContrast(board) / std::max(frame.expected[i].contrast, 1e-6) *
           (frame.expected[i].decided == frame.stream.last_captured ? 1 : 0.5);
  };
  double most = 0;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) most = std::max(most, clearness(i));
  if (most == 0) return;
  const std::size_t first =
      frame.Topmost(frame.expected.size(), [&](std::size_t i) { return clearness(i) >= kClearAmongAll * most; });
  if (first == 0) return;
  std::swap(frame.boards[0], frame.boards[first]);
  std::swap(frame.expected[0], frame.expected[first]);
}

/// Refuses a board whose word contradicts the remembered one: it is another board, or none, and may lie otherwise.
void RefuseContradicting(const ImageJob& job, std::size_t board) {
  BoardOutcome& outcome = job.frame.outcomes[board];
  if (!outcome.is_read() || job.frame.WasRead(board)) return;
  outcome.accepted = outcome.wants_more = false;
  outcome.expected.contradicted = true;
  job.tracer.Refuse(board, Refusal::kSeenTwice);
}

/// Whether a board that was fitted, but not read, keeps its identity.
bool MayCarry(const ImageJob& job, const StreamImage& stream, std::size_t board) {
  const BoardOutcome& outcome = job.frame.outcomes[board];
  const RememberedBoard& expected = job.frame.expected[board];
  return !job.frame.WasRead(board) && outcome.accepted && outcome.expected.agrees && expected.may_carry &&
         AreCellsAlike(job.options, outcome.marker.family, expected.family) &&
         Seconds(stream.captured - expected.decided) <= job.options.carry_s && !job.frame.ReadElsewhere(board);
}

/// Makes what was learnt of the expected boards what is known of them in this frame. A board's levels move as much as
/// those of half of the others at least, which tells of boards that are new or were quiet by chance.
void AgeLearnt(ImageState& frame) {
  std::vector<float>& steps = frame.stream.shares;
  for (const RememberedBoard& board : frame.expected)
    if (board.learnt.known()) steps.push_back(static_cast<float>(board.learnt.light.step));
  const double least = steps.empty() ? 0 : double{MedianInPlace(steps)};
  steps.clear();
  for (RememberedBoard& board : frame.expected) board.learnt.light.Age(frame.stream.frames_on, least);
}

/// What was remembered of a board that was read where none was expected; null: nothing. Where several copies of its
/// marker were, it is the nearest of those that were not read where they were expected.
const RememberedBoard* FindBefore(const ImageState& frame, const MemoryState& state, const BoardOutcome& outcome) {
  const auto is_it = [&](const RememberedBoard& board) {
    return board.id == *outcome.marker.id && board.family == outcome.marker.family;
  };
  // Expected boards are copies of the remembered ones, in another order.
  const auto was_read = [&](const RememberedBoard& board) {
    for (std::size_t i = 0; i < frame.expected.size(); ++i)
      if (frame.WasRead(i) && is_it(frame.expected[i]) && frame.expected[i].plane_from_board == board.plane_from_board)
        return true;
    return false;
  };
  const auto center = [](const Eigen::Matrix3d& place) -> Eigen::Vector2d { return place.col(2).hnormalized(); };
  const RememberedBoard* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const RememberedBoard& board : state.boards) {
    if (!is_it(board) || was_read(board)) continue;
    const double way = (center(board.plane_from_board) - center(outcome.plane_from_board)).norm();
    if (way < least) nearest = &board, least = way;
  }
  return nearest;
}

/// What the next frames are to know of what all boards have in common.
void RememberTraits(const ImageState& frame, MemoryState& state) {
  state.traits_age += frame.stream.frames_on;
  // What moves hides what ink and lens do.
  if (!frame.traits || !frame.traits->motion_px.isZero()) return;
  state.dot_gain = frame.traits->dot_gain;
  if (frame.known_traits) return;
  state.simple_traits = frame.traits->AreSimple() ? frame.traits : std::nullopt;
  state.traits_age = 0;
}

/// What the next frame is to know of a board that was read; of its motion alone nothing yet.
/// @param before what was known of it; null: nothing.
void DescribeRead(const ImageJob& job, std::size_t board, FrameTime captured, const LastPlaces& last_places,
                  const RememberedBoard* before, RememberedBoard& read) {
  const ImageState& frame = job.frame;
  const BoardOutcome& outcome = frame.outcomes[board];
  const AnchoredBoard& anchored = frame.boards[board];
  read.family = outcome.marker.family;
  read.id = *outcome.marker.id;
  read.kernel = outcome.expected.carried ? before->kernel : outcome.kernel;
  read.decided = outcome.expected.carried ? before->decided : captured;
  read.scale = anchored.scale;
  if (frame.IsExpected(board) && frame.stream.shift_px.isZero() && last_places.same()) {
    read.motion.Learn(before->motion, before->plane_from_board, frame.stream.ahead_s, outcome.plane_from_board);
  }
  read.box = anchored.box;
  read.blur_shape = outcome.blur_shape;
  read.light_levels = outcome.light_levels;
  read.blur_px = outcome.image.blur_px;
  read.moved_square = outcome.moved_square;
  read.visibility = outcome.visibility;
  read.contrast = SampledContrast(anchored);
  if (before) read.contrast = std::max(read.contrast, kContrastKept * before->contrast);
  read.learnt = outcome.learnt;
  if (!outcome.expected.carried && !outcome.marker.Has(Warning::kPartlyHidden) &&
      outcome.marker.corners_used == CornerCount(anchored.size))
    job.expected_boards.LearnLeads(anchored, read);
  else if (before)
    read.leads = before->leads;
}

}  // namespace

void ExpectBoards(const ImageJob& job, const StreamImage& stream) {
  ImageState& frame = job.frame;
  MemoryState& state = stream.memory;
  frame.stream.is_one = true;
  frame.stream.frames_on = state.Continue(stream.captured, job.image.width(), job.image.height());
  const double ahead_s = frame.stream.ahead_s = Seconds(stream.captured - state.captured);
  frame.stream.last_captured = state.captured;
  for (const RememberedBoard& remembered : state.boards) {
    AnchoredBoard& board = frame.boards.emplace_back();
    frame.work.Add(WorkStep::kBoard);
    if (job.expected_boards.Expect(remembered, remembered.Ahead(ahead_s), job.reader, job.lens, board))
      frame.expected.push_back(remembered);
    else
      frame.boards.pop_back();
  }
  frame.stats.expected = static_cast<int>(frame.expected.size());
  frame.stream.learns = job.options.learn_levels;
  if (frame.stream.learns) AgeLearnt(frame);
  FollowPlaces(job);
  const bool sharp = frame.stream.IsSharp();
  for (std::size_t i = 0; i < frame.expected.size(); ++i)
    job.expected_boards.HideWhatDoesNotShow(frame.expected[i], sharp, frame.boards[i]);
  LeadWithClearest(frame);
  // Boards that all do not show where their motion takes them may be blurred: they are fitted first.
  const bool may_search = sharp || !MostAreFollowed(frame);
  for (std::size_t i = 0; i < frame.expected.size(); ++i)
    frame.stream.postponed.push_back(may_search && MayLieElsewhere(frame, i));
}

void JudgeExpected(const ImageJob& job, const StreamImage& stream) {
  ImageState& frame = job.frame;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) {
    RefuseContradicting(job, i);
    const BoardOutcome& outcome = frame.outcomes[i];
    const bool shows = Shows(frame, i);
    frame.stream.missing += !outcome.accepted && !shows;
    if (outcome.expected.lies_elsewhere) frame.stream.postponed[i] = true;
    // What shows where it was expected is fitted further first; what does not is searched for in any case.
    if (frame.WasRead(i) || MayCarry(job, stream, i) || (outcome.wants_more && (outcome.accepted || shows))) continue;
    frame.stream.lost.push_back(i);
    SearchAround(frame.boards[i].box, frame.regions);
  }
}

void DecideExpected(const ImageJob& job, const StreamImage& stream) {
  ImageState& frame = job.frame;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) {
    RefuseContradicting(job, i);
    BoardOutcome& outcome = frame.outcomes[i];
    frame.stats.expected_read += frame.WasRead(i);
    if (MayCarry(job, stream, i)) {
      outcome.expected.carried = true;
      CarryIdentity(frame.expected[i].family, frame.expected[i].id, job.options, outcome.marker);
    } else if (outcome.expected.carried_or_none && outcome.accepted) {
      outcome.accepted = false;
      job.tracer.Refuse(i, Refusal::kCellsHidden);
    }
  }
}

void TraceExpectations(const ImageJob& job, const StreamImage& stream) {
  if (!job.tracer) return;
  const ImageState& frame = job.frame;
  std::vector<TraceExpected> traced;
  for (std::size_t i = 0; i < frame.expected.size(); ++i) {
    const AnchoredBoard& board = frame.boards[i];
    const BoardOutcome& outcome = frame.outcomes[i];
    TraceExpected& expected = traced.emplace_back();
    expected.id = frame.expected[i].id;
    expected.ago_s = Seconds(stream.captured - frame.expected[i].decided);
    const auto outline = OutlineOf(board.size, board.plane_from_board, job.lens);
    for (std::size_t corner = 0; corner < outline.size(); ++corner)
      expected.outline_px[corner] = outline[corner].cast<float>();
    const auto center = [&](const Eigen::Matrix3d& plane_from_board) {
      return job.lens.ToImage(plane_from_board.col(2).hnormalized());
    };
    expected.center_px = center(board.plane_from_board);
    if (outcome.accepted) expected.off_px = center(outcome.plane_from_board) - expected.center_px;
    expected.fate = outcome.expected.carried               ? ExpectedFate::kCarried
                    : outcome.accepted && frame.WasRead(i) ? ExpectedFate::kRead
                    : outcome.accepted                     ? ExpectedFate::kNoId
                    : outcome.expected.contradicted        ? ExpectedFate::kOther
                    : outcome.deferred                     ? ExpectedFate::kDeferred
                                                           : ExpectedFate::kLost;
  }
  job.tracer.Expected(std::move(traced), frame.stream.shift_px);
}

void Remember(const ImageJob& job, const StreamImage& stream) {
  ImageState& frame = job.frame;
  MemoryState& state = stream.memory;
  const LastPlaces last_places(job);
  const double passed_s = Seconds(stream.captured - state.captured);
  for (std::size_t i = 0; i < frame.outcomes.size(); ++i) {
    const BoardOutcome& outcome = frame.outcomes[i];
    if (outcome.is_read()) {
      const RememberedBoard* before = frame.IsExpected(i) ? &frame.expected[i] : FindBefore(frame, state, outcome);
      RememberedBoard& read = frame.stream.read.emplace_back();
      DescribeRead(job, i, stream.captured, last_places, before, read);
      read.Move(before, before ? last_places.Of(before->plane_from_board) : Eigen::Matrix3d::Identity(),
                outcome.plane_from_board, passed_s);
    } else if (frame.IsExpected(i) && outcome.deferred && !outcome.accepted) {
      // It waits for the next frame where it is expected in this one. Its identity cannot be carried across the gap.
      RememberedBoard& waits = frame.stream.read.emplace_back(frame.expected[i]);
      waits.may_carry = false;
      waits.Move(&frame.expected[i], last_places.Of(frame.expected[i].plane_from_board),
                 frame.boards[i].plane_from_board, passed_s);
    } else if (frame.IsExpected(i) || outcome.accepted) {
      frame.open.push_back(frame.boards[i].box);
    }
  }
  MemoryState::Lesson lesson{
      .now = stream.captured, .frames_on = frame.stream.frames_on, .open = frame.open, .cut = frame.cut};
  const int bands = BandsOf(job.options);
  for (int band = 0; band < bands; ++band)
    lesson.searched[static_cast<std::size_t>(band)] = frame.regions.HasBand(band, bands);
  state.Learn(lesson, frame.stream.read);
  RememberTraits(frame, state);
  state.edge_tally.Forget(kEdgesKept);
  frame.AddEdgesTo(state.edge_tally);
}

}  // namespace chequer
