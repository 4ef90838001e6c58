#include "detect/board_search.h"

#include <algorithm>
#include <tuple>

#include "core/crop.h"

namespace chequer {
namespace {

/// Units for a grid that is begun, in any case: boards of six take a tenth (a guess).
constexpr std::uint64_t kLeastForGrid = 500;

/// Share of the contrast of boards that were found that others have at least (a guess).
constexpr float kShareOfContrast = 0.4f;

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

}  // namespace

BoardSearch::BoardSearch(const DetectorOptions& options) : finder_(PatternsOf(options), options.color_space) {}

void BoardSearch::Search(const ImageJob& job, SearchRegion region) {
  const ImageView& image = job.image;
  const bool whole = region.area() == std::int64_t{image.width()} * image.height();
  const ImageView part = whole ? image : Crop(image, region.x, region.y, region.width, region.height);
  if (part.width() < kLeastSide || part.height() < kLeastSide) return;
  FindGrids(job, part, region);
  const std::size_t before = job.frame.boards.size();
  finder_.Start(seen_->corners.size());
  SortGrids(job.undone);
  AnchorGrids(job, region);
  StartSecondLook(job, before);
  LookAgain(job);
  job.tracer.Anchored(job.frame.boards, job.lens, job.options.color_space);
}

void BoardSearch::FindGrids(const ImageJob& job, const ImageView& part, const SearchRegion& region) {
  ImageState& frame = job.frame;
  const double pixels = static_cast<double>(region.area());
  job.tracer.StartSearch();
  const int peaks = FindCorners(part, seen_->pyramid, seen_->corners, job.tracer.refused_peaks(),
                                frame.plan.MostPeaks(pixels), {region.x, region.y, &frame.known});
  seen_->linker.Link(seen_->pyramid.base, seen_->corners, seen_->grids);
  frame.work.Add(WorkStep::kPixel, static_cast<std::uint64_t>(pixels));
  frame.work.Add(WorkStep::kPeak, static_cast<std::uint64_t>(peaks));
  frame.work.Add(seen_->linker.work());
  frame.stats.corner_candidates += peaks;
  frame.stats.corners += static_cast<int>(seen_->corners.size());
  frame.stats.grids += static_cast<int>(seen_->grids.grids.size());
  frame.stats.searched_px += region.area();
  job.tracer.Linked(seen_->corners, seen_->linker, seen_->grids);
}

PixelBox BoardSearch::BoxOf(const Grid& grid) const {
  PixelBox box;
  for (const LatticeCorner& at : seen_->grids.Of(grid)) {
    const Eigen::Vector2f& position = seen_->corners[static_cast<std::size_t>(at.corner)].position;
    box.Add(position.x(), position.y());
  }
  return box;
}

void BoardSearch::SortGrids(const Undone& undone) {
  // What is left over of the largest makes no boards of its own.
  std::vector<Grid>& grids = seen_->grids.grids;
  std::sort(grids.begin(), grids.end(),
            [](const Grid& a, const Grid& b) { return std::tuple(b.count, a.first) < std::tuple(a.count, b.first); });
  if (undone.grids.size() == 0 && undone.boards.size() == 0) return;
  const auto waited = [&](const Grid& grid) {
    const Eigen::Vector2f center = BoxOf(grid).Center();
    return std::max(undone.grids.Waited(center), undone.boards.Waited(center));
  };
  std::sort(grids.begin(), grids.end(), [&](const Grid& a, const Grid& b) {
    return std::tuple(waited(b), b.count, a.first) < std::tuple(waited(a), a.count, b.first);
  });
}

void BoardSearch::AnchorGrids(const ImageJob& job, const SearchRegion& region) {
  ImageState& frame = job.frame;
  const std::vector<Grid>& grids = seen_->grids.grids;
  const std::uint64_t most = frame.plan.MostForBoards(job.undone.second_look_most);
  const auto ask_for_grid = [&](std::size_t i) {
    if (i >= grids.size()) return;
    PixelBox box = BoxOf(grids[i]);
    box.Widen(0.3f);  // with the border
    job.reader.Prefetch(box);
  };
  ask_for_grid(0);
  for (std::size_t i = 0; i < grids.size(); ++i) {
    const std::uint64_t spent = frame.work.units();
    const PixelBox box = BoxOf(grids[i]);
    const int waited = job.undone.grids.Waited(box.Center());
    if (i > 0 && spent >= most) {
      job.Defer(box, waited, job.undone.grids);
      continue;
    }
    ask_for_grid(i + 1);
    job.TellProgress();
    const auto members = seen_->grids.Of(grids[i]);
    const bool found = finder_.Find(grids[i], members, seen_->corners, &seen_->linker.search(), job.reader, job.lens,
                                    frame.boards, job.tracer.StartGrid(),
                                    {.units = std::max(most - std::min(spent, most), kLeastForGrid), .waited = waited});
    frame.work.Add(finder_.work());
    if (finder_.left_undone()) job.Defer(box, waited, job.undone.grids);
    frame.stats.refused_border += !found;
    if (!found && frame.regions.MayBeCut(box, region)) frame.cut.push_back(box);
    job.tracer.EndGrid(members, found);
  }
}

void BoardSearch::StartSecondLook(const ImageJob& job, std::size_t before) {
  const ImageState& frame = job.frame;
  seen_->found_in.clear();
  for (std::size_t i = 0; i < frame.boards.size(); ++i)
    if (!frame.IsExpected(i) || frame.WasRead(i)) seen_->found_in.push_back(frame.boards[i].box);
  // Among boards, what matters has some of their contrast.
  float least = kStrongContrast;
  if (frame.boards.size() > before) least = std::max(least, kShareOfContrast * finder_.ContrastOf(seen_->corners));
  seen_->strong.assign(seen_->pyramid.strong.begin(), seen_->pyramid.strong.end());
  for (const Corner& corner : seen_->corners)
    if (corner.contrast >= least) seen_->strong.push_back({corner.position, corner.contrast});
  second_look_.Start(job.reader, seen_->strong, least, seen_->found_in, job.tracer.places());
}

void BoardSearch::LookAgain(const ImageJob& job) {
  ImageState& frame = job.frame;
  // All that it may take at first; boards that it shows give it more looks, while the budget lasts.
  const std::uint64_t most = second_look_.MostUnits();
  const auto may_look = [&](bool first) {
    const std::uint64_t spent = frame.work.units() + second_look_.work().units();
    return first ? frame.plan.MayLookAgain(spent, most, job.undone.second_look_most > 0)
                 : frame.plan.MayLookAgain(spent, SecondLook::kMostUnitsOfLook, false);
  };
  bool undone = false;
  for (bool first = true;; first = false) {
    undone = !may_look(first) && second_look_.MayGoOn();
    if (undone || !second_look_.Next(seen_->pyramid, job.reader)) break;
    AnchorView(job);
  }
  frame.work.Add(second_look_.work());
  job.undone.second_look_most = undone ? second_look_.MostUnits() : 0;
  frame.stats.deferred += undone;
}

void BoardSearch::AnchorView(const ImageJob& job) {
  std::vector<AnchoredBoard>& boards = job.frame.boards;
  const std::size_t known_before = boards.size();
  job.tracer.StartLook(second_look_, known_before);
  finder_.Start(second_look_.corners().size());
  for (const Grid& grid : second_look_.grids().grids) {
    job.TellProgress();
    const std::size_t known = boards.size();
    const auto members = second_look_.grids().Of(grid);
    const bool found = finder_.Find(grid, members, second_look_.corners(), nullptr, job.reader, job.lens, boards,
                                    job.tracer.StartGrid());
    for (std::size_t i = known; i < boards.size(); ++i) boards[i].motion_blurred = second_look_.motion_blurred();
    job.frame.work.Add(finder_.work());
    job.tracer.EndGrid(members, found);
    KeepBetter(job, known);
  }
  if (boards.size() > known_before) second_look_.CountBoard();
  job.tracer.EndLook(boards.size());
}

void BoardSearch::KeepBetter(const ImageJob& job, std::size_t known) {
  std::vector<AnchoredBoard>& boards = job.frame.boards;
  for (std::size_t i = known; i < boards.size();) {
    std::size_t same = job.frame.expected.size();
    while (same < known && !LiesOn(boards[i], boards[same])) ++same;
    if (same >= known) {
      ++i;
      continue;
    }
    if (Found(boards[i]) > Found(boards[same])) {
      std::swap(boards[i], boards[same]);
      job.tracer.Replace(same);
    }
    boards.erase(boards.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

}  // namespace chequer
