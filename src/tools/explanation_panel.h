#pragma once

#include <cstddef>
#include <string>

#include "tools/canvas.h"
#include "tools/explanation.h"

namespace chequer {

/// A panel, and the square close view in it.
inline constexpr double kPanelWidth = 700, kPanelHeight = 290, kCloseViewSide = 205;

inline constexpr Ink kPanelInk{0.1, 0.1, 0.1}, kOpenLinkInk{0.65, 0.6, 1, 0.65}, kSquareLinkInk{0.1, 0.95, 0.3};

/// Green where a candidate was read, amber where its id is open, red where it was refused.
Ink VerdictInk(const TraceCandidate& candidate);

/// Image pixels to the canvas: the centre of pixel (0, 0) comes to lie in the middle of its square.
struct PictureScale {
  double left = 0, top = 0;  ///< on the canvas, of the pixel's corner (x, y)
  double x = 0, y = 0;
  double scale = 1;

  Eigen::Vector2d operator()(const Eigen::Vector2d& pixel) const {
    return {left + (pixel.x() + 0.5 - x) * scale, top + (pixel.y() + 0.5 - y) * scale};
  }
};

/// Outlines of the cells and, in their middle, what each was taken for: K, W, B or Y as a disc in that colour, a cross
/// where it did not show, a red ring where the border should be otherwise, an amber one where a kernel cell is
/// doubtful.
void DrawCells(Canvas& canvas, const PictureScale& to, const TraceCandidate& candidate);

/// The background of a panel with a stripe of that colour, its title, and a sentence below it, broken into lines.
void DrawPanelHead(Canvas& canvas, double left, double top, const Ink& stripe, const std::string& title,
                   const std::string& sentence);

/// Draws what lies up to `reach` pixels around a place of an image as a square of kCloseViewSide, and clips to it until
/// Canvas::EndClip.
PictureScale DrawAround(Canvas& canvas, double left, double top, const ImageView& image, const Eigen::Vector2d& middle,
                        double reach);

/// The candidate's number, what became of it and why, a close view, and the two plots of the publication's figure 8:
/// luminances of dark and light cells, saturations of unsaturated and saturated ones, with their Gaussians.
void DrawPanel(Canvas& canvas, double left, double top, const Explanation& explanation, std::size_t candidate,
               int number);

}  // namespace chequer
