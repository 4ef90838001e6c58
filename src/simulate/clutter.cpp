#include "simulate/clutter.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "chequer/check.h"

// Everything here is drawn to mislead a detector of checkerboards: corners, saddles, lattices and strong colours.

namespace chequer {
namespace {

// A seed must give the same frame whatever the compiler: in which order it works out the arguments of a call is its own
// affair, so that no call has two that draw.

double Level(Random& random, double low = 0, double high = 255) { return std::floor(random.Uniform(low, high)); }

/// A colour between these levels, all alike.
cv::Scalar ColourBetween(double low, double high, Random& random) {
  const double third = Level(random, low, high), second = Level(random, low, high), first = Level(random, low, high);
  return {first, second, third};
}

cv::Scalar AnyColour(Random& random) {
  if (random.Below(2) == 0) {
    const double grey = Level(random);
    return {grey, grey, grey};
  }
  return {Level(random), Level(random), Level(random)};
}

cv::Scalar Shade(const cv::Scalar& colour, double factor) {
  return {colour[0] * factor, colour[1] * factor, colour[2] * factor};
}

cv::Point AnyPoint(const cv::Mat& image, Random& random) {
  return {random.Below(image.cols), random.Below(image.rows)};
}

/// Grey noise of one scale, of mean 0, about ±1.
cv::Mat OctaveOf(cv::Size size, int scale, Random& random) {
  cv::Mat small(size.height / scale + 3, size.width / scale + 3, CV_32F);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) small.at<float>(y, x) = static_cast<float>(random.Uniform(-1, 1));
  cv::Mat large;
  cv::resize(small, large, {small.cols * scale, small.rows * scale}, 0, 0, cv::INTER_LINEAR);
  return large(cv::Rect({random.Below(scale), random.Below(scale)}, size)).clone();
}

void DrawNoise(cv::Mat& image, Random& random) {
  cv::Mat sum = cv::Mat::zeros(image.size(), CV_32F);
  const double rough = random.Uniform(0.5, 1.0);
  double weight = random.Uniform(10, 30);
  for (int scale = 1; scale <= 128; scale *= 2, weight *= 1 / std::max(rough, 0.7)) {
    sum += weight * 0.5 * OctaveOf(image.size(), scale, random);
  }
  const cv::Scalar base = ColourBetween(60, 190, random);
  const double third = random.Uniform(0.5, 1), second = random.Uniform(0.5, 1), first = random.Uniform(0.5, 1);
  const cv::Scalar gain(first, second, third);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      for (int c = 0; c < 3; ++c)
        image.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(base[c] + gain[c] * sum.at<float>(y, x));
}

/// A quadrilateral grid of cells with corner `origin` and the two sides of one cell.
void FillLattice(cv::Mat& image, cv::Point2d origin, cv::Point2d u, cv::Point2d v, int cols, int rows,
                 const std::vector<cv::Scalar>& colours, bool shuffled, Random& random) {
  constexpr int kShift = 4;
  const auto fixed = [](cv::Point2d p) {
    return cv::Point(static_cast<int>(std::lround(p.x * (1 << kShift))),
                     static_cast<int>(std::lround(p.y * (1 << kShift))));
  };
  for (int row = 0; row < rows; ++row)
    for (int col = 0; col < cols; ++col) {
      const cv::Point2d corner = origin + u * col + v * row;
      const cv::Point points[] = {fixed(corner), fixed(corner + u), fixed(corner + u + v), fixed(corner + v)};
      const auto index = shuffled ? static_cast<std::size_t>(random.Below(static_cast<int>(colours.size())))
                                  : static_cast<std::size_t>(row + col) % colours.size();
      cv::fillConvexPoly(image, points, 4, colours[index], cv::LINE_AA, kShift);
    }
}

void DrawChess(cv::Mat& image, Random& random) {
  image.setTo(AnyColour(random));
  const int boards = 4 + image.cols * image.rows / 40000;
  for (int i = 0; i < boards; ++i) {
    const double cell = 4 * std::pow(10.0, random.Uniform());
    const double angle = random.Uniform(0, 2 * M_PI), shear = random.Uniform(-0.3, 0.3);
    const cv::Point2d u(cell * std::cos(angle), cell * std::sin(angle));
    const cv::Point2d v(-u.y + shear * u.x, u.x + shear * u.y);
    std::vector<cv::Scalar> colours{AnyColour(random), AnyColour(random)};
    const bool shuffled = random.Below(3) == 0;
    // The inks of the markers themselves, in no order that any border has.
    if (shuffled) colours = {{40, 40, 40}, {235, 235, 235}, {160, 70, 45}, {60, 205, 225}};
    const int rows = 2 + random.Below(9), cols = 2 + random.Below(9);
    FillLattice(image, AnyPoint(image, random), u, v, cols, rows, colours, shuffled, random);
  }
}

void DrawText(cv::Mat& image, Random& random) {
  image.setTo(AnyColour(random));
  const int words = 10 + image.cols * image.rows / 6000;
  for (int i = 0; i < words; ++i) {
    std::string word;
    for (int letters = 2 + random.Below(8); letters > 0; --letters) word += static_cast<char>('!' + random.Below(94));
    const int thickness = 1 + random.Below(4);
    const cv::Scalar colour = AnyColour(random);
    const double size = random.Uniform(0.3, 2.5);
    const int font = random.Below(8);
    cv::putText(image, word, AnyPoint(image, random), font, size, colour, thickness, cv::LINE_AA);
    if (random.Below(3) == 0) {
      const int width = 1 + random.Below(4);
      const cv::Scalar line_colour = AnyColour(random);
      const cv::Point to = AnyPoint(image, random), from = AnyPoint(image, random);
      cv::line(image, from, to, line_colour, width, cv::LINE_AA);
    }
  }
}

void DrawTiles(cv::Mat& image, Random& random) {
  image.setTo(AnyColour(random));
  const double size = random.Uniform(12, 120), joint = random.Uniform(1, 5);
  const cv::Scalar base = ColourBetween(60, 220, random);
  const double angle = random.Uniform(0, M_PI / 2);
  const cv::Point2d u(std::cos(angle), std::sin(angle)), v(-u.y, u.x);
  const int reach = static_cast<int>((image.cols + image.rows) / size) + 2;
  for (int row = -reach; row < reach; ++row)
    for (int col = -reach; col < reach; ++col) {
      const cv::Point2d corner = cv::Point2d(image.cols / 2.0, image.rows / 2.0) + (size * col) * u + (size * row) * v;
      const double diagonal = 2 * size;
      if (corner.x < -diagonal || corner.y < -diagonal || corner.x > image.cols + diagonal ||
          corner.y > image.rows + diagonal)
        continue;
      FillLattice(image, corner, (size - joint) * u, (size - joint) * v, 1, 1, {Shade(base, random.Uniform(0.8, 1.15))},
                  false, random);
    }
}

void DrawWood(cv::Mat& image, Random& random) {
  const double plank = random.Uniform(40, 160), stretch = random.Uniform(30, 90), rings = random.Uniform(3, 9);
  const double red = Level(random, 130, 190), green = Level(random, 80, 130), blue = Level(random, 40, 90);
  const cv::Scalar base(blue, green, red);
  const cv::Mat bends = OctaveOf({image.cols, image.rows}, 64, random);
  const cv::Mat grain = OctaveOf({image.cols, image.rows}, 2, random);
  std::vector<double> offsets, shades;
  for (int i = 0; i <= image.rows / plank; ++i) {
    offsets.push_back(random.Uniform(0, 100));
    shades.push_back(random.Uniform(0.8, 1.1));
  }
  for (int y = 0; y < image.rows; ++y) {
    const auto index = static_cast<std::size_t>(y / plank);
    const double within = std::fmod(y, plank);
    for (int x = 0; x < image.cols; ++x) {
      const double phase =
          offsets[index] + within / rings + x / stretch + 2.5 * static_cast<double>(bends.at<float>(y, x));
      double shade = shades[index] * (1 + 0.12 * std::sin(phase) + 0.06 * static_cast<double>(grain.at<float>(y, x)));
      if (within < 2) shade *= 0.4;
      for (int c = 0; c < 3; ++c) image.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(base[c] * shade);
    }
  }
}

void DrawBlobs(cv::Mat& image, Random& random) {
  image.setTo(AnyColour(random));
  const int blobs = 20 + image.cols * image.rows / 4000;
  for (int i = 0; i < blobs; ++i) {
    const int size = static_cast<int>(3 * std::pow(30.0, random.Uniform()));
    const float angle_deg = static_cast<float>(random.Uniform(0, 360)), slant = static_cast<float>(random.Uniform(0.3, 1));
    const cv::RotatedRect box(cv::Point2f(AnyPoint(image, random)),
                              cv::Size2f(static_cast<float>(size), static_cast<float>(size) * slant), angle_deg);
    if (random.Below(2) == 0) {
      cv::ellipse(image, box, AnyColour(random), cv::FILLED, cv::LINE_AA);
    } else {
      cv::Point2f corners[4];
      box.points(corners);
      const cv::Point2d u = corners[1] - corners[0], v = corners[3] - corners[0];
      FillLattice(image, corners[0], u, v, 1, 1, {AnyColour(random)}, false, random);
    }
  }
}

void DrawMixed(cv::Mat& image, Random& random) {
  constexpr BackgroundKind kKinds[] = {BackgroundKind::kNoise, BackgroundKind::kChess, BackgroundKind::kText,
                                       BackgroundKind::kTiles, BackgroundKind::kWood,  BackgroundKind::kBlobs};
  const int columns = std::max(1, image.cols / 240), rows = std::max(1, image.rows / 240);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const cv::Point from(image.cols * column / columns, image.rows * row / rows);
      const cv::Point to(image.cols * (column + 1) / columns, image.rows * (row + 1) / rows);
      cv::Mat patch = image(cv::Rect(from, to));
      DrawClutter(kKinds[random.Below(6)], patch, random);
    }
}

}  // namespace

void DrawClutter(BackgroundKind kind, cv::Mat& image, Random& random) {
  switch (kind) {
    case BackgroundKind::kNoise: return DrawNoise(image, random);
    case BackgroundKind::kChess: return DrawChess(image, random);
    case BackgroundKind::kText: return DrawText(image, random);
    case BackgroundKind::kTiles: return DrawTiles(image, random);
    case BackgroundKind::kWood: return DrawWood(image, random);
    case BackgroundKind::kBlobs: return DrawBlobs(image, random);
    case BackgroundKind::kMixed: return DrawMixed(image, random);
    case BackgroundKind::kPlain:
    case BackgroundKind::kImage: break;
  }
  CHEQUER_CHECK(false, "a plain colour and an image file are not procedural");
}

}  // namespace chequer
