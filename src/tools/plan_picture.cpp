#include "tools/plan_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/canvas.h"

namespace chequer {
namespace {

constexpr int kPlanWidth = 1000, kPlanPicture = 400, kPlanMargin = 24, kPlanLine = 22;
constexpr double kPlanLetters = 15;
constexpr Ink kPlanText{0.1, 0.1, 0.1}, kPlanFloor{0.92, 0.92, 0.9}, kPlanRim{0.45, 0.45, 0.45};
/// More would be a grey haze.
constexpr int kMostDrawn = 12;

/// The marker, with its pixels as squares.
void DrawSeen(Canvas& canvas, const PlanScene& scene, double left, double top) {
  const Image seen = RenderPlanned(scene);
  const ImageView view = seen.view();
  const double scale = static_cast<double>(kPlanPicture) / std::max(view.width(), view.height());
  canvas.Clip(left, top, kPlanPicture, kPlanPicture);
  canvas.Picture(view, left, top, scale);
  canvas.EndClip();
  canvas.Text(fmt::format("As the camera sees it, {:.1f} times as large", scale), left, top - 8, kPlanLetters,
              kPlanText);
}

/// What the image shows of the plane, from above, with markers in rows as large as they are there.
void DrawSeenPlane(Canvas& canvas, const PlanScene& scene, const PlanEstimate& estimate, double left, double top) {
  const double most_width = kPlanWidth - left - kPlanMargin;
  const double per_metre = std::min(most_width / estimate.seen_m.x(), kPlanPicture / estimate.seen_m.y());
  const double width = per_metre * estimate.seen_m.x(), height = per_metre * estimate.seen_m.y();
  canvas.Rectangle(left, top, width, height, kPlanFloor);
  const double side = per_metre * scene.side_m;
  // As far apart as is clear, and no more than are told apart.
  const double pitch = std::max({2 * side, width / kMostDrawn, height / kMostDrawn});
  const int rows = scene.code.size().rows, cols = scene.code.size().cols;
  const Board board = MakeBoard(scene.code, 0);
  const double cell = side / std::max(rows, cols);
  for (double y = pitch / 2; y + side / 2 < height; y += pitch)
    for (double x = pitch / 2; x + side / 2 < width; x += pitch)
      for (int i = 0; i < rows * cols; ++i) {
        const char colour = board.cells[static_cast<std::size_t>(i)];
        const Ink ink = colour == 'K'   ? Ink{0.1, 0.1, 0.1}
                        : colour == 'W' ? Ink{1, 1, 1}
                        : colour == 'B' ? Ink{0.1, 0.2, 0.8}
                                        : Ink{1, 0.85, 0};
        canvas.Rectangle(left + x - side / 2 + i % cols * cell, top + y - side / 2 + i / cols * cell, cell, cell, ink);
      }
  canvas.Line(left, top, left + width, top, kPlanRim);
  canvas.Line(left, top + height, left + width, top + height, kPlanRim);
  canvas.Line(left, top, left, top + height, kPlanRim);
  canvas.Line(left + width, top, left + width, top + height, kPlanRim);
  canvas.Text(fmt::format("The image shows {:.2f} x {:.2f} m", estimate.seen_m.x(), estimate.seen_m.y()), left, top - 8,
              kPlanLetters, kPlanText);
}

}  // namespace

std::vector<std::uint8_t> DrawPlan(const PlanScene& scene, const PlanEstimate& estimate,
                                   const std::vector<std::string>& lines) {
  const int top = kPlanMargin + kPlanLine, below = top + kPlanPicture + kPlanMargin;
  Canvas canvas = Canvas::Png(kPlanWidth, below + static_cast<int>(lines.size()) * kPlanLine + kPlanMargin);
  if (estimate.fits) DrawSeen(canvas, scene, kPlanMargin, top);
  DrawSeenPlane(canvas, scene, estimate, 2 * kPlanMargin + kPlanPicture, top);
  double y = below + kPlanLine;
  for (const std::string& line : lines) {
    canvas.Text(line, kPlanMargin, y, kPlanLetters, kPlanText);
    y += kPlanLine;
  }
  return canvas.Finish();
}

}  // namespace chequer
