#pragma once

#include <cstddef>
#include <vector>

namespace chequer {

/// Light or reflectance in linear RGB, three floats a pixel, rows without gaps.
struct LinearImage {
  int width = 0;
  int height = 0;
  std::vector<float> rgb;

  LinearImage() = default;
  LinearImage(int w, int h) : width(w), height(h), rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3) {}

  float* Pixel(int x, int y) { return &rgb[Index(x, y)]; }
  const float* Pixel(int x, int y) const { return &rgb[Index(x, y)]; }

 private:
  std::size_t Index(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) * 3;
  }
};

}  // namespace chequer
