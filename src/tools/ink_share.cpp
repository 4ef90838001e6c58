#include "tools/ink_share.h"

#include <algorithm>

namespace chequer {

double InkShare(const ImageView& image, const Eigen::AlignedBox2d& box) {
  // Of an image's values; faded inks have as much.
  constexpr int kLeastColour = 30;
  const Eigen::Vector2d last(image.width() - 1, image.height() - 1);
  const Eigen::Vector2i from = box.min().cwiseMax(0).cwiseMin(last).cast<int>();
  const Eigen::Vector2i to = box.max().cwiseMax(0).cwiseMin(last).cast<int>();
  int blue = 0, yellow = 0, all = 0;
  for (int y = from.y(); y <= to.y(); ++y)
    for (int x = from.x(); x <= to.x(); ++x, ++all) {
      const std::uint8_t* pixel = image.row(y) + 3 * x;
      blue += pixel[0] > std::max(pixel[1], pixel[2]) + kLeastColour;
      yellow += std::min(pixel[1], pixel[2]) > pixel[0] + kLeastColour;
    }
  return static_cast<double>(std::min(blue, yellow)) / std::max(1, all);
}

}  // namespace chequer
