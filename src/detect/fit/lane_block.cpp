#include "detect/fit/lane_block.h"

#include <algorithm>

namespace chequer {
namespace {

/// Pixels of a lane that are worth to be dealt to others.
constexpr int kFewestFolded = 12;

}  // namespace

void LaneBlock::Reset(int lanes, int pixels_per_lane) {
  lanes_ = lanes;
  padded_ = (lanes + kGroup - 1) / kGroup * kGroup;
  capacity_ = pixels_per_lane;
  const auto padded = static_cast<std::size_t>(padded_);
  // Values beyond a lane's count are multiplied by zero: they must be finite, whatever an earlier board left there is.
  pixels_.resize(std::max(pixels_.size(), 3 * padded / kGroup * static_cast<std::size_t>(capacity_)));
  static constexpr GroupValues kOnes = [] {
    GroupValues ones{};
    for (float& value : ones.values) value = 1;
    return ones;
  }();
  parameters_.assign(padded / kGroup * kParameters, kOnes);
  std::fill_n(parameter_data(kFadeX), 2 * padded, 0.0f);
  sums_.resize(padded / kGroup * kLaneSums);
  counts_.assign(padded, 0);
  folded_ = padded_;
}

int LaneBlock::MostOfGroup(int group) const {
  const auto first = counts_.begin() + group * kGroup;
  return *std::max_element(first, first + kGroup);
}

void LaneBlock::KeepOriginals() {
  originals_.clear();
  for (int group = 0; group < padded_ / kGroup; ++group) {
    const auto first = pixels_.begin() + std::ptrdiff_t{3} * group * capacity_;
    originals_.insert(originals_.end(), first, first + std::ptrdiff_t{3} * MostOfGroup(group));
  }
}

void LaneBlock::RestoreOriginals() {
  auto from = originals_.begin();
  for (int group = 0; group < padded_ / kGroup; ++group) {
    const auto past = from + std::ptrdiff_t{3} * MostOfGroup(group);
    std::copy(from, past, pixels_.begin() + std::ptrdiff_t{3} * group * capacity_);
    from = past;
  }
}

void LaneBlock::Fold() {
  if (lanes_ % kGroup != kFold) return;
  const int first = lanes_ - kFold;
  int most = 0;
  for (int lane = first; lane < lanes_; ++lane) most = std::max(most, count(lane));
  // Of short ones a stride would leave out too few.
  if (most < kFewestFolded) return;
  float* const start = u_data() + Place(first, 0);
  for (int i = 0; i < most; ++i) {
    const float* const from = start + i * kNextPixel;
    float* const to = start + i / kFolds * kNextPixel + i % kFolds * kFold;
    for (int value = 0; value < kNextPixel; value += kGroup) std::copy_n(from + value, kFold, to + value);
  }
  for (int lane = first; lane < lanes_; ++lane) {
    const int pixels = count(lane);
    for (int fold = 0; fold < kFolds; ++fold)
      counts_[static_cast<std::size_t>(lane + fold * kFold)] = (pixels - fold + kFolds - 1) / kFolds;
  }
  folded_ = first;
}

}  // namespace chequer
