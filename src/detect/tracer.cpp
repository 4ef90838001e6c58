#include "detect/tracer.h"

#include <algorithm>
#include <numeric>

#include "detect/common/colours.h"

namespace chequer {
namespace {

/// Fewer linked corners are chance nearly everywhere: a square is where a board begins (a guess).
constexpr std::size_t kFewestTold = 4;

/// The cells of a board as they lie in the image, not yet judged.
std::vector<TraceCell> PlaceCells(MarkerSize size, const BoardGeometry& geometry, const Lens& lens) {
  const std::vector<std::uint8_t> border = CellSaturation(size, 0);
  const auto pixel = [&](double col, double row) {
    return lens.ToImage(geometry.ToPlane({col - 0.5 * size.cols, row - 0.5 * size.rows}));
  };
  std::vector<TraceCell> cells;
  ForCells(size, [&](std::size_t index, int row, int col) {
    TraceCell cell;
    cell.at = {row, col};
    cell.center_px = pixel(col + 0.5, row + 0.5);
    cell.outline_px = {pixel(col, row).cast<float>(), pixel(col + 1, row).cast<float>(),
                       pixel(col + 1, row + 1).cast<float>(), pixel(col, row + 1).cast<float>()};
    if (IsBorder(size, row, col)) cell.expected = border[index] != 0;
    cells.push_back(cell);
  });
  return cells;
}

/// White by the border's white cells that show.
Eigen::Vector3f WhiteOf(const AnchoredBoard& board, const std::vector<TraceCell>& cells) {
  Eigen::Vector3f white = Eigen::Vector3f::Constant(1e-4f);
  int whites = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].dark() || cells[i].expected.value_or(true) || !board.visibility.Shows(i)) continue;
    white += board.light[i];
    ++whites;
  }
  return whites > 0 ? Eigen::Vector3f(white / static_cast<float>(whites)) : Eigen::Vector3f::Ones();
}

TraceCandidate AsAnchored(const AnchoredBoard& board, const Lens& lens, ColorSpace space) {
  TraceCandidate candidate;
  candidate.size = board.size;
  const BoardGeometry geometry(board.plane_from_board);
  candidate.center_px = lens.ToImage(geometry.ToPlane({0, 0}));
  candidate.cells = PlaceCells(board.size, geometry, lens);
  const Eigen::Vector3f white = WhiteOf(board, candidate.cells);
  for (std::size_t i = 0; i < candidate.cells.size(); ++i) {
    TraceCell& cell = candidate.cells[i];
    const CellColour colour = ColourOf(board.light[i], white, cell.dark(), space);
    cell.luminance = colour.luminance;
    cell.saturation = colour.saturation;
    cell.seen = board.visibility.Shows(i);
    cell.hidden = board.visibility.cells()[i];
    if (cell.seen) cell.saturated = board.saturated[i] != 0;
  }
  return candidate;
}

}  // namespace

Tracer::Tracer(DetectTrace* trace) : trace_(trace) {
  if (trace_) *trace_ = DetectTrace{};
}

void Tracer::Linked(const std::vector<Corner>& corners, const GridLinker& linker, const Grids& grids) {
  if (!trace_) return;
  first_corner_ = static_cast<int>(trace_->corners.size());
  for (const Corner& corner : corners)
    trace_->corners.push_back({corner.position, corner.contrast, corner.scale, place_});
  std::vector<int> group(corners.size());
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](int i) {
    while (group[static_cast<std::size_t>(i)] != i) i = group[static_cast<std::size_t>(i)];
    return i;
  };
  for (std::size_t i = 0; i < linker.links().size(); ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const GridLinker::Links& links = linker.links()[i];
      const int from = static_cast<int>(i), to = links.corner[k];
      if (to < from) continue;  // none, or told from the other end
      const bool in_square = (links.squares >> k & 1) != 0;
      trace_->links.push_back({first_corner_ + from, first_corner_ + to, in_square});
      if (in_square) group[static_cast<std::size_t>(root(from))] = root(to);
    }
  std::vector<bool> in_grid(corners.size());
  for (const LatticeCorner& corner : grids.corners) in_grid[static_cast<std::size_t>(corner.corner)] = true;
  std::vector<std::vector<int>> members(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (!in_grid[i]) members[static_cast<std::size_t>(root(static_cast<int>(i)))].push_back(static_cast<int>(i));
  for (const std::vector<int>& few : members) {
    if (few.size() < kFewestTold) continue;
    TraceCandidate candidate;
    candidate.refusal = static_cast<int>(few.size()) < GridLinker::kFewest ? Refusal::kFewLinked : Refusal::kUneven;
    candidate.measured = static_cast<double>(few.size());
    candidate.required = GridLinker::kFewest;
    candidate.place = place_;
    for (const int corner : few) candidate.corners.push_back(first_corner_ + corner);
    groups_.push_back(std::move(candidate));
  }
}

TraceCandidate* Tracer::StartGrid() {
  if (!trace_) return nullptr;
  attempt_ = TraceCandidate{};
  return &attempt_;
}

void Tracer::EndGrid(std::span<const LatticeCorner> members, bool found) {
  if (!trace_ || found) return;
  for (const LatticeCorner& member : members) attempt_.corners.push_back(first_corner_ + member.corner);
  attempt_.place = place_;
  groups_.push_back(std::move(attempt_));
}

void Tracer::StartLook(const SecondLook& look, std::size_t boards) {
  if (!trace_) return;
  place_ = static_cast<int>(trace_->places.size()) - 1;
  place_of_board_.resize(boards, -1);
  Linked(look.corners(), look.linker(), look.grids());
  TracePlace& place = trace_->places.back();
  place.corners = static_cast<int>(look.corners().size());
  for (const Grid& grid : look.grids().grids) place.most_linked = std::max(place.most_linked, grid.count);
  for (const TraceCandidate& group : groups_)
    if (group.place == place_) place.most_linked = std::max(place.most_linked, static_cast<int>(group.corners.size()));
}

void Tracer::Replace(std::size_t board) {
  if (trace_ && board < place_of_board_.size()) place_of_board_[board] = place_;
}

void Tracer::EndLook(std::size_t boards) {
  if (!trace_) return;
  trace_->places.back().boards = static_cast<int>(boards - place_of_board_.size());
  place_of_board_.resize(boards, place_);
}

void Tracer::Anchored(std::span<const AnchoredBoard> boards, const Lens& lens, ColorSpace space) {
  if (!trace_) return;
  place_of_board_.resize(boards.size(), -1);
  for (std::size_t i = trace_->candidates.size(); i < boards.size(); ++i) {
    trace_->candidates.push_back(AsAnchored(boards[i], lens, space));
    trace_->candidates.back().place = place_of_board_[i];
  }
}

void Tracer::Expected(std::vector<TraceExpected> expected, const Eigen::Vector2d& shift_px) {
  if (!trace_) return;
  trace_->expected = std::move(expected);
  trace_->shift_px = shift_px;
}

void Tracer::EndSearch() {
  if (!trace_) return;
  for (TraceCandidate& group : groups_) {
    if (group.cells.empty()) {
      for (const int corner : group.corners)
        group.center_px += trace_->corners[static_cast<std::size_t>(corner)].position_px.cast<double>();
      group.center_px /= std::max(1.0, static_cast<double>(group.corners.size()));
    }
    trace_->candidates.push_back(std::move(group));
  }
}

void Tracer::Refuse(std::size_t board, Refusal why, double measured, double required) {
  if (!trace_) return;
  TraceCandidate& candidate = trace_->candidates[board];
  candidate.refusal = why;
  candidate.measured = measured;
  candidate.required = required;
}

void Tracer::Read(std::size_t board, const FittedBoard& fitted, const Identity& identity, const Identifier& identifier,
                  const Lens& lens) {
  if (!trace_) return;
  if (!identity.saturation_told)
    Refuse(board, Refusal::kNoBorderInks);
  else if (!identity.decoded)
    Refuse(board, Refusal::kNoWord, identity.cells_off, identity.cells_corrected);
  else if (!identity.id_decided)
    Refuse(board, Refusal::kTwoWords, identity.margin, identity.least_margin);
  TraceCandidate& candidate = trace_->candidates[board];
  const std::vector<TraceCell> before = std::move(candidate.cells);
  candidate.cells = PlaceCells(candidate.size, fitted.geometry, lens);
  candidate.center_px = lens.ToImage(fitted.geometry.ToPlane({0, 0}));
  candidate.inner_corners.assign(fitted.visibility.corners().begin(), fitted.visibility.corners().end());
  for (std::size_t i = 0; i < candidate.cells.size(); ++i) {
    TraceCell& cell = candidate.cells[i];
    cell.luminance = before[i].luminance;
    cell.saturation = before[i].saturation;
    if (!identity.saturation_told) continue;
    const Identifier::Reading reading = identifier.ReadingOf(candidate.size, cell.at);
    cell.luminance = reading.colour.luminance;
    cell.saturation = reading.colour.saturation;
    cell.seen = reading.hidden == Hidden::kNot;
    cell.hidden = reading.hidden;
    if (cell.seen) cell.saturated = reading.saturated;
    cell.log_likelihood = reading.log_likelihood;
  }
}

void Tracer::Accept(std::size_t board, int marker) {
  if (trace_) trace_->candidates[board].marker = marker;
}

}  // namespace chequer
