#include "tools/lens_watch.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace chequer {
namespace {

/// A marker may hang on a wall; so many are a sheet.
constexpr std::size_t kSheet = 2;
/// Frames after which nobody can mean the chessboard.
constexpr int kSure = 3;

DetectorOptions OptionsOf(std::vector<MarkerFamily> families) {
  DetectorOptions options;
  options.families = std::move(families);
  return options;
}

}  // namespace

void SearchProgress::Tell(std::size_t searched, std::size_t taken) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + kEach;
  fmt::print(stderr, "chequer calibrate lens: {} of {} frames searched, {} views taken\n", searched,
             total_ > 0 ? std::to_string(total_) : "?", taken);
}

MarkerWatch::MarkerWatch(std::vector<MarkerFamily> families) : detector_(OptionsOf(std::move(families))) {}

bool MarkerWatch::Sees(const ImageView& image, std::size_t views) {
  if (detector_.Detect(image).size() < kSheet) return false;
  if (views == 0 && ++frames_ >= kSure)
    throw std::runtime_error(
        fmt::format("the first {} frames show chequer's markers, and no chessboard: leave out --chessboard and give "
                    "--side, such as "
                    "--marker 6x6 --side 60mm",
                    frames_));
  return true;
}

}  // namespace chequer
