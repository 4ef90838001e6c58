#include "detect/boards/motion_blur_view.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "detect/boards/view_kernels.h"

namespace chequer {
namespace {

/// A pixel moves away from its neighbours by at most so many times its difference to them: beyond it, noise would be
/// raised too (a guess).
constexpr float kMostShare = 6;
/// Change along rows that is aimed at, of that across: what lies around the board, and its rim, change too (measured:
/// with 1 and with 2, fewer corners are linked).
constexpr float kChangeAlong = 1.5f;
/// Part of the contrasts that is kept, so that what is raised stays within a byte (a guess).
constexpr float kRaisedKept = 0.6f;
/// Around the middle of a board of six, its own cells, less what the spread misjudges (a guess below 3).
constexpr float kCircleCells = 2.6f;

/// Calls visit(x, y) for every other pixel of every other row within a circle, `rim` px inside the plane.
template <class Visit>
void ForCircle(const BytePlane& plane, const Eigen::Vector2f& middle, float radius, int rim, const Visit& visit) {
  const auto first = [&](float at) { return std::max(static_cast<int>(at), rim); };
  const auto last = [&](float at, int size) { return std::min(static_cast<int>(at), size - 1 - rim); };
  for (int y = first(middle.y() - radius); y <= last(middle.y() + radius, plane.height()); y += 2) {
    const float dy = static_cast<float>(y) - middle.y(), half = std::sqrt(std::max(radius * radius - dy * dy, 0.0f));
    for (int x = first(middle.x() - half); x <= last(middle.x() + half, plane.width()); x += 2) visit(x, y);
  }
}

void Transpose(const BytePlane& plane, BytePlane& turned) {
  turned.Resize(plane.height(), plane.width());
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) turned.row(x)[y] = plane.at(x, y);
}

}  // namespace

Change ChangeAround(const BytePlane& plane, const Eigen::Vector2f& middle, float cell_px) {
  int xx = 0, xy = 0, yy = 0;
  const int reach = std::max(static_cast<int>(cell_px / 5), 1);
  ForCircle(plane, middle, kCircleCells * cell_px, reach, [&](int x, int y) {
    const std::uint8_t* at = plane.row(y) + x;
    const int dx = at[reach] - at[-reach], dy = at[reach * plane.stride()] - at[-reach * plane.stride()];
    xx += dx * dx, xy += dx * dy, yy += dy * dy;
  });
  const Eigen::Matrix2d squares = (Eigen::Matrix2d() << xx, xy, xy, yy).finished();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(squares);
  const Eigen::Vector2d least = solver.eigenvectors().col(0);
  return {least.cast<float>(), static_cast<float>(solver.eigenvalues()[0] / std::max(solver.eigenvalues()[1], 1.0))};
}

void EvenOutChange(int cell_px, BytePlane& view, MotionBlurScratch& scratch) {
  const int width = view.width(), height = view.height(), apart = 5 * cell_px / 8, reach = cell_px / 2;
  // Only the first harmonics are left, which are a checkerboard too: the others would be zigzags.
  const int smooth = cell_px / 2 + 1 - cell_px / 2 % 2;
  SmoothRows(smooth, view, scratch.smoothed);
  Transpose(view, scratch.turned);
  SmoothRows(smooth, scratch.turned, scratch.smoothed);
  Transpose(scratch.turned, view);
  // How far each pixel lies from its neighbours: to move all away from them by a share of that raises the change along
  // rows, by a parabola of the share.
  scratch.far.resize(static_cast<std::size_t>(width * height));
  for (int y = 0, i = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, ++i)
      scratch.far[static_cast<std::size_t>(i)] =
          2 * view.at(x, y) - view.at(std::max(x - apart, 0), y) - view.at(std::min(x + apart, width - 1), y);
  float along = 0, both = 0, more = 0, across = 0, sum = 0, count = 0;
  const Eigen::Vector2f middle(0.5f * static_cast<float>(width - 1), 0.5f * static_cast<float>(height - 1));
  ForCircle(view, middle, kCircleCells * static_cast<float>(cell_px), reach, [&](int x, int y) {
    const std::uint8_t* at = view.row(y) + x;
    const int* far = scratch.far.data() + y * width + x;
    const float step = static_cast<float>(at[reach] - at[-reach]),
                far_step = static_cast<float>(far[reach] - far[-reach]);
    const float down = static_cast<float>(at[reach * view.stride()] - at[-reach * view.stride()]);
    along += step * step, both += step * far_step, more += far_step * far_step, across += down * down;
    sum += static_cast<float>(at[0]), count += 1;
  });
  if (!(more > 0) || along >= across) return;
  const float share =
      std::min((std::sqrt(both * both + more * (kChangeAlong * across - along)) - both) / more, kMostShare);
  const float mean = sum / count;
  for (int y = 0, i = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, ++i) {
      const float moved = view.at(x, y) + share * static_cast<float>(scratch.far[static_cast<std::size_t>(i)]);
      view.row(y)[x] = static_cast<std::uint8_t>(std::clamp(128 + kRaisedKept * (moved - mean), 0.0f, 255.0f));
    }
}

}  // namespace chequer
