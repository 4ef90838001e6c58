#include <fmt/format.h>

#include <algorithm>

#include "tools/explanation.h"
#include "tools/explanation_panel.h"
#include "tools/explanation_picture.h"

namespace chequer {
namespace {

constexpr int kTileColumns = 3;
constexpr double kTilePitch = kCloseViewSide + 12, kTileHeight = kCloseViewSide + 34, kTileLetters = 12;
constexpr double kTilesWidth = kTileColumns * kTilePitch;
/// The most that a picture of few pixels is enlarged.
constexpr double kMostOverviewScale = 4;

/// A close view of a candidate, its number and what became of it.
void DrawTile(Canvas& canvas, double left, double top, const Explanation& explanation, std::size_t index, int number) {
  const TraceCandidate& candidate = explanation.candidate(index);
  const Eigen::AlignedBox2d box = CandidateBox(explanation, candidate);
  const double reach = std::clamp(0.7 * box.sizes().maxCoeff(), 4.0, 2000.0);
  const PictureScale to = DrawAround(canvas, left, top, explanation.image, box.center(), reach);
  DrawCells(canvas, to, candidate);
  canvas.EndClip();
  canvas.Rectangle(left, top + kCloseViewSide, kCloseViewSide, 4, VerdictInk(candidate));
  const std::string text = fmt::format("{}: {}", number, Verdict(explanation, candidate));
  canvas.Text(text, left, top + kCloseViewSide + 20, kTileLetters, kPanelInk, Align::kLeft, true);
}

}  // namespace

std::vector<std::uint8_t> DrawContactSheet(const Explanation& explanation) {
  const std::vector<std::size_t> told = ToldCandidates(explanation);
  const bool has_tiles = !told.empty();
  const ImageRegion& region = explanation.region;
  const double room_width = has_tiles ? kSheetWidth - kTilesWidth - 12 : kSheetWidth;
  const double room_height = kSheetHeight - kHeadHeight;
  const double scale = std::min({room_width / region.width, room_height / region.height, kMostOverviewScale});
  const auto rows = static_cast<int>(room_height / kTileHeight);
  const auto shown = std::min<std::size_t>(told.size(), static_cast<std::size_t>(rows * kTileColumns));
  const auto tile_rows = static_cast<int>((shown + kTileColumns - 1) / kTileColumns);
  const double height = kHeadHeight + std::max(region.height * scale, tile_rows * kTileHeight);
  Canvas canvas = Canvas::Png(kSheetWidth, std::min(static_cast<int>(height) + 1, kSheetHeight));
  DrawHead(canvas, kSheetWidth, explanation.name + ":  " + StageCounts(explanation));
  DrawPicture(canvas, {0, kHeadHeight, static_cast<double>(region.x), static_cast<double>(region.y), scale},
              explanation, told);
  for (std::size_t i = 0; i < shown; ++i) {
    const double left = room_width + 12 + kTilePitch * static_cast<double>(i % kTileColumns);
    const double top = kHeadHeight + 6 + kTileHeight * static_cast<double>(i / kTileColumns);
    DrawTile(canvas, left, top, explanation, told[i], static_cast<int>(i) + 1);
  }
  return canvas.Finish();
}

}  // namespace chequer
