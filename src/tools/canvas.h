#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// A colour to draw with, 0..1 each.
struct Ink {
  double red = 0, green = 0, blue = 0, opacity = 1;
};

enum class Align : std::uint8_t { kLeft, kMiddle, kRight };

/// A picture to draw on, in units of its pixels from its top left; white at first. Text in a PNG is drawn in the
/// drawing library's own font, so that pictures look the same on every machine, whatever fonts it has; in an SVG in the
/// machine's sans-serif, or in that own one where there is none.
class Canvas {
 public:
  static Canvas Png(int width, int height);
  static Canvas Svg(double width, double height);
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  void Line(double x0, double y0, double x1, double y1, const Ink& ink, double width = 1);
  void Polyline(std::span<const Eigen::Vector2d> points, const Ink& ink, double width, bool closed = false);
  void FillPolygon(std::span<const Eigen::Vector2d> points, const Ink& ink);
  void Rectangle(double x, double y, double width, double height, const Ink& fill);
  void Circle(double x, double y, double radius, const Ink& ink, double width);
  void Disc(double x, double y, double radius, const Ink& ink);
  /// @param y of the baseline. @param turned upwards by a quarter turn, about (x, y).
  void Text(const std::string& text, double x, double y, double size, const Ink& ink, Align align = Align::kLeft,
            bool bold = false, bool turned = false);
  double TextWidth(const std::string& text, double size, bool bold = false) const;
  /// Draws an image (BGR8) with its pixel (0, 0) over the square from (x, y) to (x + scale, y + scale); enlarged pixels
  /// stay squares. Only what lies in the clip is drawn.
  void Picture(const ImageView& image, double x, double y, double scale);
  /// From now on, nothing is drawn outside that rectangle; until EndClip.
  void Clip(double x, double y, double width, double height);
  void EndClip();

  /// The finished file; the canvas is used up. Throws std::runtime_error where drawing failed.
  std::vector<std::uint8_t> Finish();

 private:
  struct Impl;
  explicit Canvas(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Breaks a text into lines of at most that width, between words.
std::vector<std::string> Wrapped(const Canvas& canvas, const std::string& text, double size, double width);

}  // namespace chequer
