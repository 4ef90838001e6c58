#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "detect/boards/boards.h"

namespace chequer {
namespace {

/// How far from the middle of a box its middle half goes, along each axis (a guess).
constexpr double kMiddleHalf = 0.25;

bool LiesInTheMiddle(const SeenBoard& board, const SeenBoard& other) {
  const PixelBox& box = other.box;
  const Eigen::Vector2d size(double{box.right} - double{box.left}, double{box.bottom} - double{box.top});
  return ((board.center_px - other.center_px).cwiseAbs() - kMiddleHalf * size).maxCoeff() < 0;
}

/// Both cannot be boards.
bool AreOne(const SeenBoard& a, const SeenBoard& b) {
  if (LiesInTheMiddle(a, b) || LiesInTheMiddle(b, a)) return true;
  if (a.has_id && b.has_id) return false;
  return LiesOn(a.plane_from_board, b.plane_from_board, b.size) ||
         LiesOn(b.plane_from_board, a.plane_from_board, a.size);
}

bool IsBetter(const SeenBoard& a, const SeenBoard& b) {
  return std::tuple(a.has_id, a.corners_used, -a.rms_px) > std::tuple(b.has_id, b.corners_used, -b.rms_px);
}

}  // namespace

bool LiesOn(const Eigen::Matrix3d& plane_from_board, const Eigen::Matrix3d& plane_from_other,
            MarkerSize size_of_other) {
  const Eigen::Vector2d at = (plane_from_other.inverse() * plane_from_board.col(2)).hnormalized();
  return std::abs(at.x()) < 0.5 * size_of_other.cols && std::abs(at.y()) < 0.5 * size_of_other.rows;
}

void TakeOutTwins(std::vector<SeenBoard>& seen, std::vector<std::size_t>& worse) {
  std::sort(seen.begin(), seen.end(),
            [](const SeenBoard& a, const SeenBoard& b) { return a.center_px.x() < b.center_px.x(); });
  double farthest = 0;
  for (const SeenBoard& board : seen) farthest = std::max(farthest, double{board.box.right} - double{board.box.left});
  constexpr std::size_t kTakenOut = std::numeric_limits<std::size_t>::max();
  for (std::size_t i = 0; i < seen.size(); ++i)
    for (std::size_t k = i + 1; k < seen.size() && seen[k].center_px.x() - seen[i].center_px.x() < farthest; ++k) {
      SeenBoard &a = seen[i], &b = seen[k];
      if (a.index == kTakenOut || b.index == kTakenOut || !AreOne(a, b)) continue;
      std::size_t& index = IsBetter(a, b) ? b.index : a.index;
      worse.push_back(index);
      index = kTakenOut;
    }
  std::erase_if(seen, [](const SeenBoard& board) { return board.index == kTakenOut; });
}

}  // namespace chequer
