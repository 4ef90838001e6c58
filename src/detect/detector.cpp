#include "chequer/detector.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <stdexcept>
#include <tuple>

#include "chequer/check.h"
#include "core/crop.h"
#include "detect/boards/twins.h"
#include "detect/common/board_geometry.h"
#include "detect/detector_impl.h"
#include "detect/identity/marker_description.h"
#include "detect/pose/constant_errors.h"
#include "detect/pose/plane_pose.h"

namespace chequer {
namespace {

/// Least contrast of a board over the noise of a pixel.
constexpr double kLeastSignal = 2.5;

/// What is left undone in an image is looked for within so much of its side in the next.
constexpr float kDeferredReach = 0.5f;

/// Units for a grid that is begun, in any case: boards of six take a tenth.
constexpr std::uint64_t kLeastForGrid = 500;

/// Units of a board's plain fit at most, and for a pixel of its box; those that a full fit needs and takes at most, in
/// plain fits of the same board.
constexpr double kUnitsOfPlain = 300, kUnitsOfPlainPixel = 0.15;
/// With a budget, after so many plain fits that found no board, one is fitted in full. The dot gain that it shows is
/// that of all boards: plain fits would find none of them, and full ones that begin with it cost no more. After as many
/// with the last image's dot gain, that is forgotten.
constexpr std::size_t kFruitlessFits = 2;
constexpr std::uint64_t kLeastOfPlain = 5, kMostOfPlain = 50;
/// The covariance of a pose by the plain fit where another would explain the board better, over what that fit says.
/// With it, squared errors over the covariance are 0.6 to 1.1 in the mean, measured on robots that move, knocks and
/// hands.
constexpr double kPlainCovariance = 4;

/// Share of the contrast of boards that were found that others have at least.
constexpr float kShareOfContrast = 0.4f;

/// Corners of boards lie where they should to 0.15 px even with 8 px of motion blur.
constexpr double kMostDeviationPx = 0.5;

/// Smaller images, and parts of them, have no room for a board.
constexpr int kLeastSide = 16;
bool LiesOn(const AnchoredBoard& board, const AnchoredBoard& other) {
  return chequer::LiesOn(board.plane_from_board, other.plane_from_board, other.size);
}

/// Of a board's corners, those that were found.
std::ptrdiff_t Found(const AnchoredBoard& board) { return std::count(board.found.begin(), board.found.end(), true); }

std::vector<BorderPattern> PatternsOf(const DetectorOptions& options) {
  std::vector<BorderPattern> patterns;
  for (const MarkerFamily& family : options.families) {
    const MarkerSize size = family.code.size();
    if (std::none_of(patterns.begin(), patterns.end(), [&](const BorderPattern& p) { return p.size == size; }))
      patterns.emplace_back(size);
  }
  return patterns;
}

DetectorOptions WithUsualCalibration(DetectorOptions options) {
  if (options.camera && options.print_tolerance.any() && options.camera->covariance.isZero(0))
    options.camera->covariance = UsualLensCovariance(*options.camera);
  return options;
}

}  // namespace

Detector::Impl::Impl(DetectorOptions given)
    : options(WithUsualCalibration(std::move(given))),
      expected_boards(options),
      finder(PatternsOf(options), options.color_space),
      pool(options.threads, options.on_thread_start),
      budget(options.budget) {
  for (int worker = 0; worker < pool.workers(); ++worker) workers.emplace_back(options);
}

void Detector::Impl::FindMosaic(const ImageView& image, const std::array<float, 256>& table, const Lens& lens,
                                LightReader& reader) const {
  // The boards' surroundings have the texture that tells.
  for (std::size_t i = 0; i < frame->boards.size() && i < 3; ++i) {
    const Eigen::Vector2d center = (frame->boards[i].plane_from_board * Eigen::Vector3d(0, 0, 1)).hnormalized();
    const Eigen::Vector2d pixel = lens.ToImage(center);
    const int x = static_cast<int>(pixel.x()), y = static_cast<int>(pixel.y());
    if (const auto mosaic = FindInterpolatedMosaic(image, table, x - 16, y - 8, x + 15, y + 7)) {
      reader.SetMosaic(*mosaic);
      return;
    }
  }
}

void Detector::Impl::FindBoards(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  frame->boards_before = frame->boards.size();
  finder.Start(frame->corners.size());
  SortGrids();
  AnchorGrids(reader, lens, tracer);
  LookAgain(reader, lens, tracer);
  tracer.Anchored(frame->boards, lens, options.color_space);
}

PixelBox Detector::Impl::BoxOf(const Grid& grid) const {
  PixelBox box;
  for (const LatticeCorner& at : frame->grids.Of(grid)) {
    const Eigen::Vector2f& position = frame->corners[static_cast<std::size_t>(at.corner)].position;
    box.Add(position.x(), position.y());
  }
  return box;
}

void Detector::Impl::SortGrids() {
  // The largest first: what is left over of them makes no boards of its own.
  std::vector<Grid>& grids = frame->grids.grids;
  std::sort(grids.begin(), grids.end(),
            [](const Grid& a, const Grid& b) { return std::tuple(b.count, a.first) < std::tuple(a.count, b.first); });
  if (memory.grids.size() == 0 && memory.boards.size() == 0) return;
  const auto waited = [&](const Grid& grid) {
    const Eigen::Vector2f center = BoxOf(grid).Center();
    return std::max(memory.grids.Waited(center), memory.boards.Waited(center));
  };
  std::sort(grids.begin(), grids.end(), [&](const Grid& a, const Grid& b) {
    return std::tuple(waited(b), b.count, a.first) < std::tuple(waited(a), a.count, b.first);
  });
}

void Detector::Impl::AnchorGrids(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  const std::vector<Grid>& grids = frame->grids.grids;
  const std::uint64_t most = frame->plan.MostForBoards(memory.second_look_most);
  const auto ask_for_grid = [&](std::size_t i) {
    if (i >= grids.size()) return;
    PixelBox box = BoxOf(grids[i]);
    box.Widen(0.3f);
    reader.Prefetch(box);
  };
  ask_for_grid(0);
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const std::uint64_t spent = frame->work.units();
    if (i > 0 && spent >= most) {
      Defer(BoxOf(grids[i]));
      continue;
    }
    ask_for_grid(i + 1);
    TellProgress();
    const bool found = finder.Find(grids[i], frame->grids.Of(grids[i]), frame->corners, &frame->linker.search(), reader,
                                   lens, frame->boards, tracer.StartGrid(),
                                   {.units = std::max(most - std::min(spent, most), kLeastForGrid),
                                    .waited = memory.grids.Waited(BoxOf(grids[i]).Center())});
    frame->work.Add(finder.work());
    if (finder.left_undone()) Defer(BoxOf(grids[i]));
    stats.refused_border += !found;
    if (!found && frame->regions.MayBeCut(BoxOf(grids[i]), frame->region)) frame->cut.push_back(BoxOf(grids[i]));
    tracer.EndGrid(frame->grids.Of(grids[i]), found);
  }
}

void Detector::Impl::Defer(const PixelBox& box) {
  const Eigen::Vector2f center = box.Center();
  memory.grids.Defer(center, kDeferredReach * box.Side(), memory.grids.Waited(center));
  frame->open.push_back(box);
  ++stats.deferred;
}

void Detector::Impl::Defer(const FitTask& task) {
  const PixelBox& box = frame->boards[task.board].box;
  memory.boards.Defer(box.Center(), kDeferredReach * box.Side(), task.waited);
  frame->open.push_back(box);
  frame->outcomes[task.board].deferred = true;
  ++stats.deferred;
}

void Detector::Impl::StartSecondLook(const LightReader& reader, Tracer& tracer) {
  // Among boards, what matters has some of their contrast.
  float least = kStrongContrast;
  frame->found_in.clear();
  for (std::size_t i = 0; i < frame->boards.size(); ++i)
    if (i >= frame->expected.size() || WasRead(i)) frame->found_in.push_back(frame->boards[i].box);
  if (frame->boards.size() > frame->boards_before)
    least = std::max(least, kShareOfContrast * finder.ContrastOf(frame->corners));
  frame->strong.assign(frame->pyramid.strong.begin(), frame->pyramid.strong.end());
  for (const Corner& corner : frame->corners)
    if (corner.contrast >= least) frame->strong.push_back({corner.position, corner.contrast});
  second_look.Start(reader, frame->strong, least, frame->found_in, tracer.places());
}

void Detector::Impl::LookAgain(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  StartSecondLook(reader, tracer);
  // All that it may take at first; boards that it shows give it more looks, while the budget lasts.
  const std::uint64_t most = second_look.MostUnits();
  const auto may_look = [&](bool first) {
    const std::uint64_t spent = frame->work.units() + second_look.work().units();
    return first ? frame->plan.MayLookAgain(spent, most, memory.second_look_most > 0)
                 : frame->plan.MayLookAgain(spent, SecondLook::kMostUnitsOfLook, false);
  };
  bool undone = false;
  for (bool first = true;; first = false) {
    undone = !may_look(first) && second_look.MayGoOn();
    if (undone || !second_look.Next(frame->pyramid, reader)) break;
    tracer.StartLook(second_look, frame->boards.size());
    const std::size_t known_before = frame->boards.size();
    finder.Start(second_look.corners().size());
    for (const Grid& grid : second_look.grids().grids) {
      TellProgress();
      const std::size_t known = frame->boards.size();
      const auto members = second_look.grids().Of(grid);
      const bool found =
          finder.Find(grid, members, second_look.corners(), nullptr, reader, lens, frame->boards, tracer.StartGrid());
      for (std::size_t i = known; i < frame->boards.size(); ++i)
        frame->boards[i].motion_blurred = second_look.motion_blurred();
      frame->work.Add(finder.work());
      tracer.EndGrid(members, found);
      KeepBetter(known, tracer);
    }
    if (frame->boards.size() > known_before) second_look.CountBoard();
    tracer.EndLook(frame->boards.size());
  }
  frame->work.Add(second_look.work());
  memory.second_look_most = undone ? second_look.MostUnits() : 0;
  stats.deferred += undone;
}

void Detector::Impl::KeepBetter(std::size_t known, Tracer& tracer) {
  for (std::size_t i = known; i < frame->boards.size();) {
    std::size_t same = frame->expected.size();
    while (same < known && !LiesOn(frame->boards[i], frame->boards[same])) ++same;
    if (same >= known) {
      ++i;
      continue;
    }
    if (Found(frame->boards[i]) > Found(frame->boards[same])) {
      std::swap(frame->boards[i], frame->boards[same]);
      tracer.Replace(same);
    }
    frame->boards.erase(frame->boards.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void Detector::Impl::RefuseTwins(Tracer& tracer) {
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i)
    if (const MarkerPose& marker = frame->outcomes[i].marker; frame->outcomes[i].accepted)
      frame->seen.push_back({i, marker.center_px, frame->boards[i].box, frame->boards[i].size,
                             frame->outcomes[i].plane_from_board, marker.id.has_value(), marker.corners_used,
                             marker.reprojection_rms_px});
  TakeOutTwins(frame->seen, frame->twins);
  for (const std::size_t i : frame->twins) {
    frame->outcomes[i].accepted = false;
    tracer.Refuse(i, Refusal::kSeenTwice, 0, 0);
  }
}

void Detector::Impl::SearchIn(const ImageView& image, SearchRegion region, const LightReader& reader, const Lens& lens,
                              Tracer& tracer) {
  const bool whole = region.area() == std::int64_t{image.width()} * image.height();
  const ImageView part = whole ? image : Crop(image, region.x, region.y, region.width, region.height);
  if (part.width() < kLeastSide || part.height() < kLeastSide) return;
  const double pixels = static_cast<double>(region.area());
  frame->region = region;
  tracer.StartSearch();
  const int peaks = FindCorners(part, frame->pyramid, frame->corners, tracer.refused_peaks(),
                                frame->plan.MostPeaks(pixels), {region.x, region.y, &frame->known});
  frame->linker.Link(frame->pyramid.base, frame->corners, frame->grids);
  frame->work.Add(WorkStep::kPixel, static_cast<std::uint64_t>(pixels));
  frame->work.Add(WorkStep::kPeak, static_cast<std::uint64_t>(peaks));
  frame->work.Add(frame->linker.work());
  stats.corner_candidates += peaks;
  stats.corners += static_cast<int>(frame->corners.size());
  stats.grids += static_cast<int>(frame->grids.grids.size());
  stats.searched_px += region.area();
  tracer.Linked(frame->corners, frame->linker, frame->grids);
  FindBoards(reader, lens, tracer);
}

void Detector::Impl::Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace,
                            const StreamFrame* stream) {
  Tracer tracer(trace);
  markers.clear();
  stats = DetectStats{};
  if (image.width() < kLeastSide || image.height() < kLeastSide) return;
  frame.Start().plan = WorkPlan(budget);
  if (!frame->plan.limited()) memory = {};
  frame->work.Add(WorkStep::kFrame);
  const bool knows_curve = options.camera && options.camera->tone_curve;
  const std::array<float, 256>& table = tone.Of(knows_curve ? *options.camera->tone_curve : image.tone_curve());
  // Boards are sought in the image as it is, and fitted to what the camera has measured of it.
  const LightReader reader(image, table);
  LightReader measured(image, table);
  const bool calibrated =
      options.camera && options.camera->width == image.width() && options.camera->height == image.height();
  const Lens lens = calibrated ? Lens(*options.camera) : Lens();

  frame->regions.Start(image.width(), image.height());
  frame->known.Start(image.width(), image.height());
  if (stream) ExpectBoards(*stream, reader, lens);
  std::optional<ImageTraits>& remembered = stream ? stream->memory.traits : memory.traits;
  frame->last_traits = remembered;
  frame->needs_dot_gain = frame->last_traits.has_value();
  const std::size_t expected = frame->expected.size();
  if (expected > 0) {
    tracer.Anchored(frame->boards, lens, options.color_space);
    FindMosaic(image, table, lens, measured);
    FitBoards(0, measured, lens, tracer);
    JudgeExpected(*stream, false, tracer);
  }
  ChooseRegions(stream, lens);
  for (const SearchRegion& region : frame->regions.regions()) SearchIn(image, region, reader, lens, tracer);
  if (expected == 0) FindMosaic(image, table, lens, measured);
  FitBoards(expected, measured, lens, tracer);
  FitPostponed(measured, lens, tracer);
  if (frame->plan.limited()) {
    Refine(measured, lens, tracer);
    SearchGivenUp(image, reader, measured, lens, tracer);
  }
  tracer.EndSearch();
  if (stream) JudgeExpected(*stream, true, tracer);
  RefuseTwins(tracer);
  stats.boards = static_cast<int>(frame->boards.size());
  for (std::size_t i = 0; i < frame->outcomes.size(); ++i) {
    const Outcome& outcome = frame->outcomes[i];
    if (!outcome.accepted) {
      stats.refused_fit += !outcome.deferred;
      continue;
    }
    stats.undecided += !outcome.marker.id;
    tracer.Accept(i, static_cast<int>(markers.size()));
    markers.push_back(outcome.marker);
  }
  if (stream) {
    TraceExpectations(*stream, lens, tracer);
    Remember(*stream, lens);
  }
  RememberTraits(remembered);
  memory.grids.EndImage();
  memory.boards.EndImage();
  stats.work = frame->work.units();
}

void Detector::Impl::SearchGivenUp(const ImageView& image, const LightReader& reader, const LightReader& measured,
                                   const Lens& lens, Tracer& tracer) {
  if (!ChooseGivenUp(lens)) return;
  const std::size_t known = frame->boards.size();
  for (const SearchRegion& region : frame->given_up.regions()) SearchIn(image, region, reader, lens, tracer);
  FitBoards(known, measured, lens, tracer);
  Refine(measured, lens, tracer);
}

std::size_t Detector::Impl::FitFirst(const LightReader& reader, const Lens& lens, std::span<FitTask> tasks,
                                     Tracer& tracer) {
  // The noise is the camera's, and mostly the blur: the first board that is one tells it for all.
  const bool limited = frame->plan.limited();
  std::size_t done = 0, fruitless = 0;
  while (done < tasks.size() && !frame->traits) {
    FitTask& task = tasks[done];
    const ImageTraits* last = frame->last_traits ? &*frame->last_traits : nullptr;
    // With the dot gain that prints had before, boards are fitted in full at once.
    if (limited && last) task.most *= kMostOfPlain;
    if (GrantRound(frame->plan, frame->work.units(), done == 0, tasks.subspan(done, 1)) == 0) break;
    Outcome& outcome = frame->outcomes[task.board];
    outcome = Measure(reader, lens, {task.board, last, limited && !last, task.granted}, workers[0], tracer);
    frame->work.Add(outcome.work);
    ++done;
    if (!outcome.accepted && ++fruitless == kFruitlessFits) {
      if (limited && !last) FitFully(task, reader, lens, tracer);
      frame->last_traits.reset();
      frame->needs_dot_gain = outcome.accepted;
    }
    if (outcome.accepted && TellsTraits(task.board)) frame->traits = outcome.image;
  }
  return done;
}

void Detector::Impl::RememberTraits(std::optional<ImageTraits>& traits) const {
  // With a budget, what plain fits find goes without.
  if (frame->plan.limited() && !frame->needs_dot_gain) return traits.reset();
  const Outcome* telling = nullptr;
  for (const Outcome& outcome : frame->outcomes) {
    // What moves hides what ink does.
    if (!outcome.accepted || !outcome.marker.id || outcome.wants_more || !outcome.image.motion_px.isZero()) continue;
    if (!telling || (outcome.image.shares_dot_gain() && !telling->image.shares_dot_gain())) telling = &outcome;
  }
  if (!telling) return;
  if (telling->image.shares_dot_gain())
    traits = telling->image;
  else
    traits.reset();
}

void Detector::Impl::FitFully(const FitTask& task, const LightReader& reader, const Lens& lens, Tracer& tracer) {
  Outcome& outcome = frame->outcomes[task.board];
  const std::uint64_t most = std::min(kMostOfPlain * outcome.work.units(), frame->plan.MostForOneFit());
  if (!frame->expected.empty() || !outcome.wants_more || most > frame->plan.Left(frame->work.units())) return;
  outcome = Measure(reader, lens, {task.board, nullptr, false, most}, workers[0], tracer);
  frame->work.Add(outcome.work);
}

std::size_t Detector::Impl::FitInRounds(const LightReader& reader, const Lens& lens, bool plain_only,
                                        std::span<FitTask> tasks, Tracer& tracer) {
  const auto fit_round = [&](std::span<const FitTask> round) {
    const auto fit_one = [&](int item, int worker) {
      const std::size_t i = static_cast<std::size_t>(item), later = i + workers.size();
      if (later < round.size()) reader.Prefetch(frame->boards[round[later].board].box);
      frame->outcomes[round[i].board] = Measure(
          reader, lens, {round[i].board, frame->traits ? &*frame->traits : nullptr, plain_only, round[i].granted},
          workers[static_cast<std::size_t>(worker)], tracer);
    };
    // By reference: a copy would be allocated.
    pool.Run(static_cast<int>(round.size()), std::ref(fit_one));
    for (const FitTask& task : round) frame->work.Add(frame->outcomes[task.board].work);
    ShareTraits(round);
  };
  return RunInRounds(
      frame->plan, !plain_only, tasks, [&] { return frame->work.units(); }, fit_round);
}

void Detector::Impl::ShareTraits(std::span<const FitTask> round) {
  for (const FitTask& task : round) {
    const Outcome& outcome = frame->outcomes[task.board];
    if (!outcome.accepted) continue;
    if (!frame->traits) {
      if (TellsTraits(task.board)) frame->traits = outcome.image;
      continue;
    }
    ImageTraits& traits = *frame->traits;
    if (traits.motion_px.isZero()) traits.motion_px = outcome.image.motion_px;
    // Blur and noise, too: plain fits have taken a part of the dot gain for them.
    if (traits.motion_px.isZero() && traits.dot_gain == 0 && outcome.image.dot_gain != 0) traits = outcome.image;
  }
}

void Detector::Impl::LeadWithTopmost(std::span<FitTask> tasks) const {
  if (tasks.empty() || tasks[0].waited > 0) return;
  const std::size_t topmost =
      Topmost(frame->boards.size(), [&](std::size_t i) { return ShowsAllCorners(frame->boards[i]); });
  const auto lead =
      std::find_if(tasks.begin(), tasks.end(), [&](const FitTask& task) { return task.board == topmost; });
  if (lead != tasks.end()) std::iter_swap(tasks.begin(), lead);
}

void Detector::Impl::FitBoards(std::size_t first, const LightReader& reader, const Lens& lens, Tracer& tracer) {
  frame->outcomes.resize(frame->boards.size());
  const std::size_t tasks_before = frame->tasks.size();
  for (std::size_t i = first; i < frame->boards.size(); ++i)
    if (i >= frame->expected.size() || !frame->postponed[i]) frame->tasks.push_back(TaskOf(i));
  FitTasks(tasks_before, reader, lens, tracer);
}

void Detector::Impl::FitPostponed(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  const std::size_t tasks_before = frame->tasks.size();
  for (std::size_t i = 0; i < frame->expected.size(); ++i)
    if (frame->postponed[i] && !ReadElsewhere(i)) frame->tasks.push_back(TaskOf(i));
  FitTasks(tasks_before, reader, lens, tracer);
}

void Detector::Impl::FitTasks(std::size_t first, const LightReader& reader, const Lens& lens, Tracer& tracer) {
  const bool limited = frame->plan.limited();
  const std::span<FitTask> tasks = std::span(frame->tasks).subspan(first);
  if (tasks.empty()) return;
  if (limited) SortByWaiting(tasks);
  if (first == 0 && frame->expected.empty()) LeadWithTopmost(tasks);
  std::size_t done = FitFirst(reader, lens, tasks, tracer);
  if (first == 0 && CameraMoved(tasks.first(done)))
    for (std::size_t i = 0; i < frame->expected.size(); ++i) frame->boards[i].motion_blurred = true;
  const bool plain_only = limited && !(frame->traits && frame->traits->dot_gain != 0);
  if (limited && !plain_only) {
    const std::uint64_t last = done > 0 ? frame->outcomes[tasks[done - 1].board].work.units() : 0;
    for (FitTask& task : tasks.subspan(done)) {
      task.most *= kMostOfPlain;
      task.expected = std::max(task.expected, last);
    }
  }
  done += FitInRounds(reader, lens, plain_only, tasks.subspan(done), tracer);
  for (std::size_t i = done; i < tasks.size(); ++i) Defer(tasks[i]);
}

bool Detector::Impl::WasReadAt(std::size_t board, std::size_t first, std::size_t past) const {
  for (std::size_t i = first; i < past; ++i) {
    const Outcome& outcome = frame->outcomes[i];
    if (outcome.accepted && outcome.marker.id && !outcome.wants_more && LiesOn(frame->boards[board], frame->boards[i]))
      return true;
  }
  return false;
}

bool Detector::Impl::WaitsAt(std::size_t board) const {
  for (std::size_t i = 0; i < frame->expected.size(); ++i)
    if (frame->outcomes[i].wants_more && LiesOn(frame->boards[board], frame->boards[i])) return true;
  return false;
}

void Detector::Impl::Refine(const LightReader& reader, const Lens& lens, Tracer& tracer) {
  std::vector<FitTask>& tasks = frame->tasks;
  // What was expected in another picture is not worth a look, nor is what was found since then and read.
  const std::size_t expected = frame->expected.size(), gone = IsAnotherPicture() ? expected : 0;
  std::erase_if(tasks, [&](const FitTask& task) {
    const Outcome& outcome = frame->outcomes[task.board];
    return !outcome.wants_more || outcome.deferred || (task.board < gone && !outcome.accepted) ||
           (task.board < expected && WasReadAt(task.board, expected, frame->boards.size()));
  });
  for (FitTask& task : tasks) {
    const Outcome& outcome = frame->outcomes[task.board];
    task.unclear = !outcome.accepted || !outcome.marker.id;
    task.least = kLeastOfPlain * outcome.work.units();
    task.most = task.expected = kMostOfPlain * outcome.work.units();
  }
  // Of a board that was expected and found again, only one needs to be fitted.
  const auto twins = std::partition(tasks.begin(), tasks.end(), [&](const FitTask& task) {
    return task.board < expected || gone > 0 || !WaitsAt(task.board);
  });
  const std::size_t first = static_cast<std::size_t>(twins - tasks.begin());
  SortByWorth(std::span(tasks).first(first));
  std::size_t done = FitInRounds(reader, lens, false, std::span(tasks).first(first), tracer);
  const auto lasts = [&] { return tasks[first].expected <= frame->plan.Left(frame->work.units()); };
  if (done == first && first < tasks.size() && (first == 0 || lasts())) {
    tasks.erase(std::remove_if(tasks.begin() + static_cast<std::ptrdiff_t>(first), tasks.end(),
                               [&](const FitTask& task) {
                                 const bool read = WasReadAt(task.board, 0, expected);
                                 if (read) frame->outcomes[task.board].accepted = false;
                                 if (read) tracer.Refuse(task.board, Refusal::kSeenTwice);
                                 return read;
                               }),
                tasks.end());
    SortByWorth(std::span(tasks).subspan(first));
    done += FitInRounds(reader, lens, false, std::span(tasks).subspan(first), tracer);
  }
  for (std::size_t i = done; i < tasks.size(); ++i) {
    Outcome& outcome = frame->outcomes[tasks[i].board];
    if (outcome.accepted) outcome.marker.covariance *= kPlainCovariance;
    Defer(tasks[i]);
  }
}

FitTask Detector::Impl::TaskOf(std::size_t board) const {
  FitTask task{.board = board};
  if (!frame->plan.limited()) return task;
  const PixelBox& box = frame->boards[board].box;
  const double area = static_cast<double>(box.right - box.left) * (box.bottom - box.top);
  task.waited = memory.boards.Waited(box.Center());
  task.least = task.most = task.expected = static_cast<std::uint64_t>(kUnitsOfPlain + kUnitsOfPlainPixel * area);
  return task;
}

double Detector::Impl::CellRatioOf(MarkerSize size) const {
  for (const MarkerFamily& family : options.families)
    if (family.code.size() == size) return family.CellM().y() / family.CellM().x();
  return 1;
}

Eigen::Vector2d Detector::Impl::RegisterOf(MarkerSize size) const {
  Eigen::Vector2d cells = Eigen::Vector2d::Zero();
  for (const MarkerFamily& family : options.families)
    if (family.code.size() == size)
      cells = cells.cwiseMax(options.print_tolerance.register_m * family.CellM().cwiseInverse());
  return cells;
}

Eigen::Vector2d Detector::Impl::CellOf(const Identity& identity, std::size_t board, bool agrees) const {
  const MarkerFamily& family = options.families[static_cast<std::size_t>(identity.family)];
  if (identity.id_decided) return family.CellM(identity.decoded->id);
  if (!agrees || !SameSide(identity.family, frame->expected[board].family)) return family.CellM();
  // It may be given the identity of the board that was expected there.
  const RememberedBoard& expected = frame->expected[board];
  return options.families[static_cast<std::size_t>(expected.family)].CellM(expected.id);
}

Detector::Impl::Outcome Detector::Impl::Measure(const LightReader& reader, const Lens& lens, const FitOrder& order,
                                                Worker& worker, Tracer& tracer) const {
  const std::size_t index = order.board;
  TellProgress();
  const AnchoredBoard& board = frame->boards[index];
  Outcome outcome;
  const auto refuse = [&](Refusal why, double measured = 0, double required = 0) {
    tracer.Refuse(index, why, measured, required);
    return outcome;
  };
  const FittedBoard* fitted = worker.fit.Fit(reader, lens,
                                             {.board = {.size = board.size,
                                                        .cell_ratio = CellRatioOf(board.size),
                                                        .geometry = BoardGeometry(board.plane_from_board),
                                                        .blur_px = 0.8 * board.scale,
                                                        .light = board.light,
                                                        .saturated = board.saturated,
                                                        .covered = board.covered,
                                                        .found = board.found,
                                                        .known = KnownTo(index),
                                                        .register_cells = RegisterOf(board.size),
                                                        .image = order.image},
                                              .motion_blurred = board.motion_blurred,
                                              .most_units = order.most_units,
                                              .plain_only = order.plain_only});
  outcome.wants_more = worker.fit.wants_more();
  outcome.work.Add(worker.fit.work());
  outcome.work.Add(WorkStep::kReading);
  if (!fitted) return refuse(Refusal::kNoFit);
  if (fitted->signal_to_noise < kLeastSignal) return refuse(Refusal::kNoise, fitted->signal_to_noise, kLeastSignal);
  if (fitted->reprojection_rms_px > kMostDeviationPx)
    return refuse(Refusal::kCornersOff, fitted->reprojection_rms_px, kMostDeviationPx);
  Identity identity = worker.identifier.Identify(*fitted, board.size, reader, lens);
  outcome.work.Add(WorkStep::kMixedPixel, identity.mixed_pixels);
  tracer.Read(index, *fitted, identity, worker.identifier, lens);
  if (!identity.id_decided || !identity.plausible)
    outcome.agrees = AgreesWithExpected(index, *fitted, identity, worker);
  if (!identity.plausible) {
    if (!outcome.agrees) return refuse(Refusal::kCellsHidden);
    // Too little shows for a board that is not followed: it is one only with the identity that it had.
    outcome.carried_or_none = true;
    identity.id_decided = false;
  }
  std::optional<std::array<PlanePose, 2>> poses;
  BoardMeasurement measured;
  if (lens.calibrated()) {
    const Eigen::Vector2d cell_m = CellOf(identity, index, outcome.agrees);
    measured = MeasurementOf(*fitted, board.size, cell_m, options.print_tolerance, lens);
    poses = PosesOf(measured);
    if (!poses) return refuse(Refusal::kNoPose);
  }
  outcome.accepted = true;
  outcome.plane_from_board = fitted->geometry.plane_from_board();
  if (identity.id_decided) outcome.kernel = identity.decoded->kernel;
  outcome.image = fitted->image;
  Describe(*fitted, identity, options, lens, outcome.marker);
  if (!poses) return outcome;
  DescribePose(*poses, measured, outcome.marker);
  if (worker.fit.cut_short()) outcome.marker.covariance *= kPlainCovariance;
  return outcome;
}

Detector::Detector(DetectorOptions options) {
  if (const std::string error = options.Check(); !error.empty()) throw std::runtime_error(error);
  impl_ = std::make_unique<Impl>(std::move(options));
}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

std::vector<MarkerPose> Detector::Detect(const ImageView& image) {
  std::vector<MarkerPose> markers;
  impl_->Detect(image, markers, nullptr);
  return markers;
}

void Detector::Detect(const ImageView& image, std::vector<MarkerPose>& markers, DetectTrace* trace) {
  impl_->Detect(image, markers, trace);
}

void Detector::Detect(const ImageView& image, std::chrono::nanoseconds captured, DetectorMemory& memory,
                      std::vector<MarkerPose>& markers, DetectTrace* trace) {
  const Impl::StreamFrame stream{captured, memory.state()};
  impl_->Detect(image, markers, trace, &stream);
}

void Detector::set_budget(std::uint64_t units) {
  CHEQUER_CHECK(units == 0 || units >= kLeastBudget, "the budget is too small for any image");
  impl_->budget = units;
}

const DetectStats& Detector::stats() const { return impl_->stats; }
const DetectorOptions& Detector::options() const { return impl_->options; }

}  // namespace chequer
