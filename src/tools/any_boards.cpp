#include "tools/any_boards.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "chequer/detect_trace.h"
#include "detect/toolbox.h"

namespace chequer {
namespace {

/// Fewer corners may be clutter.
constexpr std::size_t kBoardLike = 9;
// Of 3x3 a chessboard shows many.
constexpr int kSmallest = 4, kLargest = 10;

/// Squares first, as nearly all markers are; then the others; the larger first, as a board may hold the border of a
/// smaller one by chance.
std::vector<MarkerSize> Sizes(bool squares) {
  std::vector<MarkerSize> sizes;
  for (int rows = kLargest; rows >= kSmallest; --rows)
    for (int cols = kLargest; cols >= kSmallest; --cols)
      if (IsValid({rows, cols}) && (rows == cols) == squares) sizes.push_back({rows, cols});
  std::stable_sort(sizes.begin(), sizes.end(),
                   [](MarkerSize a, MarkerSize b) { return a.rows * a.cols > b.rows * b.cols; });
  return sizes;
}

/// @pre image is BGR8.
Image Mirrored(const ImageView& image) {
  Image mirrored(PixelFormat::kBgr8, image.width(), image.height(), image.tone_curve());
  std::uint8_t* out = mirrored.bytes().data();
  for (int y = 0; y < image.height(); ++y) {
    const std::uint8_t* row = image.row(y);
    for (int x = image.width() - 1; x >= 0; --x, out += 3) std::copy_n(row + 3 * x, 3, out);
  }
  return mirrored;
}

double ReachOf(const MarkerPose& marker) {
  double reach = 0;
  for (int i = 0; i < CornerCount(marker.size); ++i) {
    const Eigen::Vector2d corner = marker.corners[static_cast<std::size_t>(i)].cast<double>();
    if (corner.allFinite()) reach = std::max(reach, (corner - marker.center_px).norm());
  }
  // The outermost corners that are seen are one cell inside the border.
  const int least = std::min(marker.size.rows, marker.size.cols);
  return reach * least / (least - 2);
}

/// Adds the boards of one size to those that are known.
class Search {
 public:
  Search(const ImageView& image, ColorSpace space) : image_(image) { options_.color_space = space; }

  void Add(MarkerSize size) {
    options_.families = {{.code = MarkerCode(size, Variant::kUnconstrained), .side_m = 0, .roster = {}}};
    Detector detector(options_);
    detector.Detect(image_, markers_, &trace_);
    for (const TraceCandidate& candidate : trace_.candidates) {
      if (candidate.marker < 0) continue;
      const MarkerPose& marker = markers_[static_cast<std::size_t>(candidate.marker)];
      const AnyBoard board{marker.center_px, ReachOf(marker), marker.size, KernelOf(candidate)};
      if (!IsOnKnown(board.center_px)) boards_.push_back(board);
    }
  }
  /// Whether corners hang together somewhere as a board's do, and no board is known there.
  bool IsSomethingLeft() const {
    return std::any_of(trace_.candidates.begin(), trace_.candidates.end(), [&](const TraceCandidate& candidate) {
      return candidate.marker < 0 && candidate.corners.size() >= kBoardLike && !IsOnKnown(candidate.center_px);
    });
  }
  std::vector<AnyBoard>& boards() { return boards_; }

 private:
  bool IsOnKnown(const Eigen::Vector2d& pixel) const {
    return std::any_of(boards_.begin(), boards_.end(),
                       [&](const AnyBoard& known) { return (known.center_px - pixel).norm() < known.reach_px; });
  }

  const ImageView& image_;
  DetectorOptions options_;
  std::vector<MarkerPose> markers_;
  DetectTrace trace_;
  std::vector<AnyBoard> boards_;
};

}  // namespace

std::vector<AnyBoard> FindAnyBoards(const ImageView& image, const DetectorOptions& sought, bool mirrored) {
  Image turned;
  if (mirrored) turned = Mirrored(image);
  const ImageView view = mirrored ? turned.view() : image;
  Search search(view, sought.color_space);
  for (const MarkerFamily& family : sought.families) search.Add(family.code.size());
  for (const MarkerSize size : Sizes(true)) search.Add(size);
  if (search.IsSomethingLeft())
    for (const MarkerSize size : Sizes(false)) search.Add(size);
  if (mirrored)
    for (AnyBoard& board : search.boards()) board.center_px.x() = image.width() - 1 - board.center_px.x();
  return std::move(search.boards());
}

}  // namespace chequer
