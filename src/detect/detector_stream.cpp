#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/median.h"
#include "detect/common/board_geometry.h"
#include "detect/detector_impl.h"
#include "detect/identity/marker_description.h"
#include "detect/memory/common_shift.h"

// What a detector makes of frames of a stream (DetectorMemory).

namespace chequer {
namespace {

/// A board that was lost is searched so far around where it was expected, as a share of its side: robots that brake or
/// turn as hard as they can move by a tenth within a frame, what is pushed by as much again.
constexpr float kLostReach = 0.6f;

/// A board that is followed lies where it was expected to within so much of a cell; a fit that was pulled to what lies
/// beside it, by a cell.
constexpr double kMostOffCells = 0.4;

/// Where boards show less of their contrast in the last frame, in the median, they may all lie elsewhere: half a cell
/// off leaves none of it. Also where the light changes, which costs the search.
constexpr float kContrastOfExpected = 0.8f;
/// Of what a board showed before a frame that shows less, which may be blurred: light that fades faster costs that search.
constexpr double kContrastKept = 0.9;
/// A board that shows less of it is not where it was expected: half a cell off leaves none. One that moved while the
/// shutter was open shows more, and is missed by the plain fit alone. (With half or more, which would spare boards of
/// 3 px cells fits that begin a third of a cell off, 2 to 5 % less are read in knocks.)
constexpr double kContrastThatIsThere = 0.25;
/// What that search takes for a board, in places of a second look.
constexpr std::uint64_t kPlacesOfShift = 67;
/// Of what is left of a budget, that search takes so much at most: a search of the image takes less.
constexpr double kMostOfBudgetForShift = 0.25;

/// Of boards in plain view, those show so much of the contrast of the one that shows most of its own.
constexpr double kClearAmongAll = 0.8;
/// Motion blur of half a cell leaves less of the contrast.
constexpr float kContrastOfBlurred = 0.95f;
/// Motion blur beyond a board's own: less is fitted as quickly without knowing it.
constexpr double kMotionOfCameraPx = 2;
/// Corners of boards in plain view lie where a plane has them to 0.03 px, blurred ones to 0.06.
constexpr double kMostOffOfFirst = 0.06;

/// The outline of a board in the image.
std::array<Eigen::Vector2d, 4> OutlineOf(MarkerSize size, const Eigen::Matrix3d& plane_from_board, const Lens& lens) {
  const double x = 0.5 * size.cols, y = 0.5 * size.rows;
  std::array<Eigen::Vector2d, 4> outline{Eigen::Vector2d(-x, -y), {x, -y}, {x, y}, {-x, y}};
  for (Eigen::Vector2d& at : outline) at = lens.ToImage((plane_from_board * at.homogeneous()).hnormalized());
  return outline;
}

/// How far at most the outline of a board lies from there, plane units.
double FarthestOff(const AnchoredBoard& board, const Eigen::Matrix3d& plane_from_board) {
  const Lens none;
  const auto expected = OutlineOf(board.size, board.plane_from_board, none),
             fitted = OutlineOf(board.size, plane_from_board, none);
  double farthest = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) farthest = std::max(farthest, (expected[i] - fitted[i]).norm());
  return farthest;
}

/// Whether a part of the box lies in one of the regions.
bool AnyReaches(std::span<const SearchRegion> regions, const PixelBox& box) {
  return std::any_of(regions.begin(), regions.end(), [&](const SearchRegion& region) {
    const float left = static_cast<float>(region.x), top = static_cast<float>(region.y);
    return box.right >= left && box.left <= left + static_cast<float>(region.width) && box.bottom >= top &&
           box.top <= top + static_cast<float>(region.height);
  });
}

}  // namespace

void Detector::Impl::ExpectBoards(const StreamFrame& stream, const LightReader& reader, const Lens& lens) {
  MemoryState& state = stream.memory;
  frame->frames_on = state.Continue(stream.captured, reader.width(), reader.height());
  const double ahead_s = Seconds(stream.captured - state.captured);
  frame->last_captured = state.captured;
  for (const RememberedBoard& remembered : state.boards) {
    AnchoredBoard& board = frame->boards.emplace_back();
    frame->work.Add(WorkStep::kBoard);
    if (expected_boards.Expect(remembered, Predict(remembered, ahead_s), reader, lens, board))
      frame->expected.push_back(remembered);
    else
      frame->boards.pop_back();
  }
  stats.expected = static_cast<int>(frame->expected.size());
  FollowShift(reader, lens);
  const bool sharp = frame->contrast_share >= kContrastOfExpected;
  for (std::size_t i = 0; i < frame->expected.size(); ++i)
    expected_boards.HideWhatDoesNotShow(frame->expected[i], sharp, frame->boards[i]);
  LeadWithClearest();
  // Boards that all do not show where their motion takes them may be blurred: they are fitted first.
  const bool may_search = sharp || !MostAreFollowed();
  for (std::size_t i = 0; i < frame->expected.size(); ++i) frame->postponed.push_back(may_search && MayLieElsewhere(i));
}

bool Detector::Impl::MostAreFollowed() const {
  const auto followed = std::count_if(frame->expected.begin(), frame->expected.end(),
                                      [](const RememberedBoard& board) { return board.before_s > 0; });
  return 2 * static_cast<std::size_t>(followed) > frame->expected.size();
}

bool Detector::Impl::MayLieElsewhere(std::size_t expected) const {
  const RememberedBoard& board = frame->expected[expected];
  if (board.before_s > 0) return !Shows(expected);
  // Where it went is not known.
  return SampledContrast(frame->boards[expected]) < kContrastOfExpected * board.contrast;
}

bool Detector::Impl::Shows(std::size_t expected) const {
  return SampledContrast(frame->boards[expected]) > kContrastThatIsThere * frame->expected[expected].contrast;
}

void Detector::Impl::LeadWithClearest() {
  // The first board gives the image's noise and blur, which an occlusion would falsify.
  const auto clearness = [&](std::size_t i) {
    const AnchoredBoard& board = frame->boards[i];
    if (!ShowsAllCorners(board)) return 0.0;
    return SampledContrast(board) / std::max(frame->expected[i].contrast, 1e-6) *
           (frame->expected[i].decided == frame->last_captured ? 1 : 0.5);
  };
  double most = 0;
  for (std::size_t i = 0; i < frame->expected.size(); ++i) most = std::max(most, clearness(i));
  if (most == 0) return;
  const std::size_t first =
      Topmost(frame->expected.size(), [&](std::size_t i) { return clearness(i) >= kClearAmongAll * most; });
  if (first == 0) return;
  std::swap(frame->boards[0], frame->boards[first]);
  std::swap(frame->expected[0], frame->expected[first]);
}

void Detector::Impl::FollowShift(const LightReader& reader, const Lens& lens) {
  std::vector<float>& shares = frame->shares;
  for (std::size_t i = 0; i < frame->expected.size(); ++i)
    shares.push_back(static_cast<float>(SampledContrast(frame->boards[i]) / frame->expected[i].contrast));
  if (shares.empty()) return;
  frame->contrast_share = MedianInPlace(shares);
  // What has moved by itself since it was found does not tell how a camera moved.
  if (frame->contrast_share >= kContrastOfExpected || !MostAreFollowed()) return;
  const double left = kMostOfBudgetForShift * static_cast<double>(frame->plan.Left(frame->work.units())),
               of_a_board = kPlacesOfShift * WorkMeter::Instructions(WorkStep::kPlace) / WorkMeter::kInstructionsPerUnit;
  const std::size_t asked =
      static_cast<std::size_t>(std::min(left / of_a_board, static_cast<double>(kMostAskedForShift)));
  if (asked < kFewestAskedForShift) return;
  frame->shift_px = FindCommonShift(frame->boards, asked, reader, lens);
  frame->work.Add(WorkStep::kPlace, kPlacesOfShift * std::min(frame->boards.size(), asked));
  if (frame->shift_px.isZero()) return;
  for (std::size_t i = 0; i < frame->expected.size();) {
    const Eigen::Matrix3d shifted = Shifted(frame->boards[i].plane_from_board, frame->shift_px, lens);
    if (expected_boards.Expect(frame->expected[i], shifted, reader, lens, frame->boards[i])) {
      ++i;
      continue;
    }
    const std::ptrdiff_t out = static_cast<std::ptrdiff_t>(i);
    frame->boards.erase(frame->boards.begin() + out);
    frame->expected.erase(frame->expected.begin() + out);
  }
}

bool Detector::Impl::AgreesWithExpected(std::size_t board, const FittedBoard& fitted, const Identity& identity,
                                        const Worker& worker) const {
  if (board >= frame->expected.size() || !identity.saturation_told) return false;
  const AnchoredBoard& expected = frame->boards[board];
  const double cell = std::sqrt(std::abs(BoardGeometry(expected.plane_from_board).PlaneByBoard({0, 0}).determinant()));
  return FarthestOff(expected, fitted.geometry.plane_from_board()) < kMostOffCells * cell &&
         AgreesWith(expected_boards.EvidenceOf(frame->expected[board], worker.identifier));
}

bool Detector::Impl::MayCarry(const StreamFrame& stream, std::size_t expected) const {
  const Outcome& outcome = frame->outcomes[expected];
  const RememberedBoard& board = frame->expected[expected];
  return outcome.accepted && outcome.agrees && board.may_carry && SameSide(outcome.marker.family, board.family) &&
         Seconds(stream.captured - board.decided) <= options.carry_s;
}

bool Detector::Impl::ReadElsewhere(std::size_t expected) const {
  const RememberedBoard& board = frame->expected[expected];
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i) {
    const Outcome& outcome = frame->outcomes[i];
    if (i != expected && outcome.accepted && outcome.marker.id == board.id && outcome.marker.family == board.family)
      return true;
  }
  return false;
}

void Detector::Impl::TraceExpectations(const StreamFrame& stream, const Lens& lens, Tracer& tracer) const {
  if (!tracer) return;
  std::vector<TraceExpected> traced;
  for (std::size_t i = 0; i < frame->expected.size(); ++i) {
    const AnchoredBoard& board = frame->boards[i];
    const Outcome& outcome = frame->outcomes[i];
    TraceExpected& expected = traced.emplace_back();
    expected.id = frame->expected[i].id;
    expected.ago_s = Seconds(stream.captured - frame->expected[i].decided);
    const auto outline = OutlineOf(board.size, board.plane_from_board, lens);
    for (std::size_t corner = 0; corner < outline.size(); ++corner)
      expected.outline_px[corner] = outline[corner].cast<float>();
    const auto center = [&](const Eigen::Matrix3d& plane_from_board) {
      return lens.ToImage(plane_from_board.col(2).hnormalized());
    };
    expected.center_px = center(board.plane_from_board);
    if (outcome.accepted) expected.off_px = center(outcome.plane_from_board) - expected.center_px;
    expected.fate = outcome.carried                  ? ExpectedFate::kCarried
                    : outcome.accepted && WasRead(i) ? ExpectedFate::kRead
                    : outcome.accepted               ? ExpectedFate::kNoId
                    : outcome.contradicted           ? ExpectedFate::kOther
                    : outcome.deferred               ? ExpectedFate::kDeferred
                                                     : ExpectedFate::kLost;
  }
  tracer.Expected(std::move(traced), frame->shift_px);
}

void Detector::Impl::JudgeExpected(const StreamFrame& stream, bool finally, Tracer& tracer) {
  for (std::size_t i = 0; i < frame->expected.size(); ++i) {
    Outcome& outcome = frame->outcomes[i];
    const RememberedBoard& board = frame->expected[i];
    const bool read = WasRead(i);
    stats.expected_read += finally && read;
    // A word that contradicts the remembered one: this is another board, or none, and may lie otherwise.
    if (outcome.accepted && outcome.marker.id && !read) {
      outcome.accepted = outcome.wants_more = false;
      outcome.contradicted = true;
      tracer.Refuse(i, Refusal::kSeenTwice);
    }
    const bool carried = !read && MayCarry(stream, i) && !ReadElsewhere(i);
    if (finally && carried) {
      outcome.carried = true;
      CarryIdentity(board.family, board.id, options, outcome.marker);
    }
    if (finally && !carried && outcome.carried_or_none && outcome.accepted) {
      outcome.accepted = false;
      tracer.Refuse(i, Refusal::kCellsHidden);
    }
    const bool shows = Shows(i);
    frame->missing += !finally && !outcome.accepted && !shows;
    // What shows where it was expected is fitted further first; what does not is searched for in any case.
    if (finally || read || carried || (outcome.wants_more && (outcome.accepted || shows))) continue;
    frame->lost.push_back(i);
    PixelBox box = frame->boards[i].box;
    box.Widen(kLostReach);
    frame->regions.Add(box);
  }
}

bool Detector::Impl::IsAnotherPicture() const {
  const std::size_t expected = frame->expected.size(), found = frame->boards.size() - expected;
  return 2 * frame->missing > expected && 2 * found > expected;
}

void Detector::Impl::ChooseRegions(const StreamFrame* stream, const Lens& lens) {
  // Where most boards are lost, it is another picture: a cut, or a camera that was turned.
  if (!stream || !stream->memory.filled || options.search_every == 1 || 2 * frame->lost.size() > frame->expected.size() ||
      2 * frame->missing > frame->expected.size()) {
    frame->regions.AddAll();
  } else {
    const int bands = Bands();
    for (int band = 0; band < bands; ++band)
      if (stream->memory.HasTurn(band, bands, options.search_every, frame->frames_on)) frame->regions.AddBand(band, bands);
    for (const OpenPlace& place : stream->memory.open) {
      PixelBox box = place.box;
      box.Widen(kLostReach);
      frame->regions.Add(box);
    }
    frame->regions.Merge();
  }
  MarkKnown(frame->regions, lens);
}

void Detector::Impl::MarkKnown(const SearchRegions& regions, const Lens& lens) {
  if (regions.regions().empty()) return;
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i) {
    const Outcome& outcome = frame->outcomes[i];
    const bool known = i < frame->expected.size() ? WasRead(i) : outcome.accepted && outcome.marker.id.has_value();
    if (known && AnyReaches(regions.regions(), frame->boards[i].box))
      frame->known.Add(OutlineOf(frame->boards[i].size, outcome.plane_from_board, lens));
  }
}

bool Detector::Impl::ChooseGivenUp(const Lens& lens) {
  frame->given_up.Start(frame->regions.width(), frame->regions.height());
  if (frame->regions.is_all()) return false;
  for (std::size_t i = 0; i < frame->expected.size(); ++i) {
    const Outcome& outcome = frame->outcomes[i];
    // Without an id, and where what shows is not the remembered one's, a fit may have slid along the pattern.
    const bool found = outcome.accepted && (outcome.marker.id || outcome.agrees);
    if (found || outcome.deferred || ReadElsewhere(i) ||
        std::find(frame->lost.begin(), frame->lost.end(), i) != frame->lost.end())
      continue;
    PixelBox box = frame->boards[i].box;
    box.Widen(kLostReach);
    frame->given_up.Add(box);
  }
  frame->given_up.Merge();
  MarkKnown(frame->given_up, lens);
  return !frame->given_up.regions().empty();
}

Eigen::Vector2d Detector::Impl::ShiftOfCamera(const Lens& lens) const {
  double own = 0, with_camera = 0;
  for (std::size_t i = 0; i < frame->expected.size(); ++i) {
    if (!frame->outcomes[i].accepted) continue;
    const Eigen::Matrix3d &last = frame->expected[i].plane_from_board, &now = frame->outcomes[i].plane_from_board;
    own += (now - last).col(2).head<2>().norm();
    with_camera += (now - Shifted(last, frame->shift_px, lens)).col(2).head<2>().norm();
  }
  return with_camera < own ? frame->shift_px : Eigen::Vector2d::Zero();
}

void Detector::Impl::Remember(const StreamFrame& stream, const Lens& lens) {
  MemoryState& state = stream.memory;
  const Eigen::Vector2d shift_px = ShiftOfCamera(lens);
  const double passed_s = Seconds(stream.captured - state.captured);
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i) {
    const Outcome& outcome = frame->outcomes[i];
    const bool is_expected = i < frame->expected.size();
    if (outcome.accepted && outcome.marker.id) {
      const RememberedBoard* before =
          is_expected ? &frame->expected[i] : state.Find(outcome.marker.family, *outcome.marker.id);
      RememberedBoard& read = frame->read.emplace_back();
      read.family = outcome.marker.family;
      read.id = *outcome.marker.id;
      read.kernel = outcome.carried ? before->kernel : outcome.kernel;
      read.decided = outcome.carried ? before->decided : stream.captured;
      read.scale = frame->boards[i].scale;
      if (is_expected) {
        read.off_px = FarthestOff(frame->boards[i], outcome.plane_from_board);
        if (before->before_s > 0 && frame->shift_px.isZero()) {
          const Eigen::Matrix3d &expected = frame->boards[i].plane_from_board, &fitted = outcome.plane_from_board;
          read.drift = before->drift + (fitted - expected).col(2).head<2>();
          read.spin = before->spin + TurnBetween(expected, fitted);
        }
      }
      read.box = frame->boards[i].box;
      read.contrast = std::max(SampledContrast(frame->boards[i]), before ? kContrastKept * before->contrast : 0.0);
      if (!outcome.carried && !outcome.marker.Has(Warning::kPartlyHidden) &&
          outcome.marker.corners_used == CornerCount(frame->boards[i].size))
        expected_boards.LearnLeads(frame->boards[i], read);
      else if (before)
        read.leads = before->leads;
      read.Move(before, before ? Shifted(before->plane_from_board, shift_px, lens) : Eigen::Matrix3d::Identity(),
                outcome.plane_from_board, passed_s);
    } else if (is_expected && outcome.deferred && !outcome.accepted) {
      // It waits for the next frame where it is expected in this one. Its identity cannot be carried across the gap.
      RememberedBoard& waits = frame->read.emplace_back(frame->expected[i]);
      waits.may_carry = false;
      waits.Move(&frame->expected[i], Shifted(frame->expected[i].plane_from_board, shift_px, lens),
                 frame->boards[i].plane_from_board, passed_s);
    } else if (is_expected || outcome.accepted) {
      frame->open.push_back(frame->boards[i].box);
    }
  }
  MemoryState::Lesson lesson{
      .now = stream.captured, .frames_on = frame->frames_on, .open = frame->open, .cut = frame->cut};
  for (int band = 0; band < Bands(); ++band)
    lesson.searched[static_cast<std::size_t>(band)] = frame->regions.HasBand(band, Bands());
  state.Learn(lesson, frame->read);
}

bool Detector::Impl::TellsTraits(std::size_t board) const {
  return board >= frame->expected.size() ||
         (WasRead(board) && frame->outcomes[board].marker.reprojection_rms_px <= kMostOffOfFirst);
}

bool Detector::Impl::CameraMoved(std::span<const FitTask> done) const {
  if (done.empty() || !frame->traits || done.back().board >= frame->expected.size()) return false;
  // Blur takes from all boards' contrast.
  if (frame->contrast_share > kContrastOfBlurred) return false;
  // No board moves farther by itself while the shutter is open than from one frame to the next.
  const RememberedBoard& board = frame->expected[done.back().board];
  const double own_px = (board.plane_from_board.col(2) - board.before.col(2)).norm();
  return board.before_s > 0 && frame->traits->motion_px.norm() > own_px + kMotionOfCameraPx;
}

}  // namespace chequer
