#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "chequer/detector.h"
#include "chequer/image.h"

namespace chequer {

/// Says on standard error, every two seconds, how far a search among frames has come, which may take long.
class SearchProgress {
 public:
  /// @param total frames there are; 0 where nobody knows.
  explicit SearchProgress(std::size_t total) : total_(total) {}
  void Tell(std::size_t searched, std::size_t taken);

 private:
  static constexpr std::chrono::seconds kEach{2};
  std::size_t total_;
  std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + kEach;
};

/// Notices that somebody shows markers where a chessboard is sought. Markers keep the search for a chessboard busy.
class MarkerWatch {
 public:
  explicit MarkerWatch(std::vector<MarkerFamily> families);

  /// Whether the image shows a sheet of markers. Throws std::runtime_error with what would help where frame after frame
  /// did and nothing else was ever seen. @param views that were taken so far.
  bool Sees(const ImageView& image, std::size_t views);

 private:
  Detector detector_;
  int frames_ = 0;
};

}  // namespace chequer
