#include "lens/coverage.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace chequer {
namespace {

constexpr int kEnough = 2;

}  // namespace

void Coverage::Add(const LensView& view) {
  std::array<bool, kCols * kRows> here{};
  for (const SeenPoint& point : view.points) {
    const int col = std::clamp(static_cast<int>(point.pixel.x() * kCols / width_), 0, kCols - 1);
    const int row = std::clamp(static_cast<int>(point.pixel.y() * kRows / height_), 0, kRows - 1);
    here[static_cast<std::size_t>(row * kCols + col)] = true;
  }
  for (std::size_t i = 0; i < here.size(); ++i) counts_[i] += here[i] ? 1 : 0;
}

double Coverage::Share() const {
  const auto covered = std::count_if(counts_.begin(), counts_.end(), [](int count) { return count >= kEnough; });
  return static_cast<double>(covered) / static_cast<double>(counts_.size());
}

std::string Coverage::Where() const {
  // The emptiest ninth of the image.
  std::string where;
  int least = kEnough * (kCols / 3) * (kRows / 3);
  static constexpr std::array<const char*, 3> kVertical{"top", "", "bottom"}, kHorizontal{"left", "", "right"};
  for (int v = 0; v < 3; ++v)
    for (int h = 0; h < 3; ++h) {
      int sum = 0, parts = 0;
      for (int row = v * kRows / 3; row < (v + 1) * kRows / 3; ++row)
        for (int col = h * kCols / 3; col < (h + 1) * kCols / 3; ++col, ++parts)
          sum += std::min(CountAt(col, row), kEnough);
      // The rim mostly stays empty: half of a ninth in a corner of the image, less elsewhere.
      const int needed_of_8 = v != 1 && h != 1 ? 4 : 6;
      if (8 * sum >= needed_of_8 * kEnough * parts || sum >= least) continue;
      least = sum;
      where = kVertical[static_cast<std::size_t>(v)];
      if (*kHorizontal[static_cast<std::size_t>(h)] != '\0')
        where.append(where.empty() ? "" : " ").append(kHorizontal[static_cast<std::size_t>(h)]);
      if (where.empty()) where = "middle";
    }
  return where;
}

std::string Coverage::Picture() const {
  std::string text;
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const int count = CountAt(col, row);
      text += count == 0 ? '.' : count < 10 ? static_cast<char>('0' + count) : '+';
      text += ' ';
    }
    text.back() = '\n';
  }
  return text;
}

double Foreshortening(const LensView& view) {
  // The affine map of the board with most points, board to pixels: the ratio of its singular values.
  std::array<int, 2> best{-1, 0};
  for (const SeenPoint& point : view.points) {
    const int count = static_cast<int>(std::count_if(view.points.begin(), view.points.end(),
                                                     [&](const SeenPoint& p) { return p.board == point.board; }));
    if (count > best[1]) best = {point.board, count};
  }
  Eigen::Matrix2d board = Eigen::Matrix2d::Zero(), across = Eigen::Matrix2d::Zero();
  Eigen::Vector2d board_mean(0, 0), pixel_mean(0, 0);
  for (const SeenPoint& point : view.points)
    if (point.board == best[0]) {
      board_mean += point.on_board_m / best[1];
      pixel_mean += point.pixel / best[1];
    }
  for (const SeenPoint& point : view.points)
    if (point.board == best[0]) {
      const Eigen::Vector2d on_board = point.on_board_m - board_mean, pixel = point.pixel - pixel_mean;
      board += on_board * on_board.transpose();
      across += pixel * on_board.transpose();
    }
  if (!(std::abs(board.determinant()) > 1e-18)) return 1;
  const Eigen::Matrix2d pixel_from_board = across * board.inverse();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> scales;
  scales.computeDirect(pixel_from_board.transpose() * pixel_from_board, Eigen::EigenvaluesOnly);
  return std::sqrt(scales.eigenvalues()[1] / std::max(scales.eigenvalues()[0], 1e-12));
}

}  // namespace chequer
