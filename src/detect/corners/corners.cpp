#include "detect/corners/corners.h"

#include <algorithm>

#include "detect/corners/saddle.h"

namespace chequer {
namespace {

/// Least response of a peak, grey levels: a corner of 8-bit contrast C answers with 0.2 C to 0.7 C, noise of 1 to 2
/// levels with 1 to 4.
constexpr std::uint8_t kLeastResponse = 5;
/// Rows of the image that are worked on together: few enough for the second cache, and a multiple of 4, so that every
/// level gets whole rows.
constexpr int kBandRows = 16;
static_assert(kBandRows % (1 << (Pyramid::kLevels - 1)) == 0);

/// Peaks a pixel that are a lot: a thousand boards in 12 Mpx have twice as many.
constexpr double kManyPeaks = 0.0005;
/// Where there is a lot to look at, peaks count that have this share of the response that one in twenty reaches:
/// corners of one board, of cells of 4 px, differ by as much.
constexpr float kWeakShare = 0.15f;
/// Of all others, there may be no more than a lot, unless they have this response, grey levels, or this share: textured
/// ground has less for the most part, print more (guesses).
constexpr int kClearResponse = 12;
constexpr float kClearShare = 0.7f;
/// The same where the strongest are print, or boards in good light: of a sharp board of 60 grey levels all corners have
/// it.
constexpr int kClearAmongPrint = 20;
constexpr float kClearShareAmongPrint = 0.5f;

/// Leaves out the weakest of too many. Of those that are equally weak, some are left out everywhere in the image. The
/// others stay in their order. @param count peaks by their response.
void KeepStrongest(std::size_t most, const std::array<std::size_t, 256>& count, std::vector<Peak>& peaks) {
  if (peaks.size() <= most) return;
  std::size_t least = count.size(), stronger = 0;
  while (least > 0 && stronger + count[least - 1] <= most) stronger += count[--least];
  if (least == 0) return;
  const std::size_t equals = count[--least], kept = most - stronger;
  std::size_t share = 0;
  std::erase_if(peaks, [&](const Peak& peak) {
    if (peak.response != least) return peak.response < least;
    share += kept;
    if (share < equals) return true;
    share -= equals;
    return false;
  });
}

using ResponseCounts = std::array<std::size_t, 256>;

/// Where there is a lot to look at, leaves out what is much weaker than the strongest, and then the weakest of what is
/// as weak as grain and grout: a board would have to lie in light many times as dim as its surroundings to be among
/// them. That bounds what textured ground costs a pixel. @param many a lot. @param count peaks by their response.
void LeaveOutTexture(std::size_t many, const ResponseCounts& count, std::vector<Peak>& peaks) {
  std::size_t above = 0;
  int strong = 255;
  while (strong > 0 && (above += count[static_cast<std::size_t>(strong)]) < peaks.size() / 20) --strong;
  const auto share_of_strong = [&](float share) { return static_cast<int>(share * static_cast<float>(strong)); };
  const int weak = share_of_strong(kWeakShare);
  int least = std::max({weak, std::min(share_of_strong(kClearShare), kClearResponse),
                        std::min(share_of_strong(kClearShareAmongPrint), kClearAmongPrint)});
  std::size_t kept = 0;
  for (std::size_t response = static_cast<std::size_t>(least); response < count.size(); ++response)
    kept += count[response];
  while (least > weak && kept + count[static_cast<std::size_t>(least - 1)] <= many)
    kept += count[static_cast<std::size_t>(--least)];
  std::erase_if(peaks, [&](const Peak& peak) { return peak.response < least; });
}

/// @param most peaks that may be left.
void LimitPeaks(double area_px, std::size_t most, std::vector<Peak>& peaks) {
  const std::size_t many = static_cast<std::size_t>(kManyPeaks * area_px);
  if (peaks.size() <= std::min(many, most)) return;
  ResponseCounts count{};
  for (const Peak& peak : peaks) ++count[peak.response];
  if (peaks.size() > many) LeaveOutTexture(many, count, peaks);
  KeepStrongest(std::min<std::size_t>(kMaxPeaks, most), count, peaks);
}

/// Of the peaks that are left to look at, coarser levels have one in so many (as of the pixels).
constexpr std::size_t kShareOfCoarser = 4;

/// Where corners of finer levels lie, one bit for every block of 2 × 2 image pixels.
class Occupancy {
 public:
  /// @param top, past rows of the image in which they may lie.
  Occupancy(std::vector<std::uint64_t>& words, int width, int top, int past)
      : words_(words),
        cols_(width / 2 + 2),
        first_row_(top / 2),
        rows_(past / 2 - top / 2 + 2),
        row_words_(static_cast<std::size_t>(cols_ / 64) + 2) {
    words_.assign(row_words_ * static_cast<std::size_t>(rows_), 0);
  }
  void Mark(const Eigen::Vector2f& p) {
    const std::size_t col = Col(p.x());
    words_[Row(p.y()) * row_words_ + col / 64] |= std::uint64_t{1} << col % 64;
  }
  /// @param radius below 60 px.
  bool Near(const Eigen::Vector2f& p, float radius) const {
    const std::size_t first = Col(p.x() - radius), last = Col(p.x() + radius), shift = first % 64;
    std::uint64_t found = 0;
    for (std::size_t row = Row(p.y() - radius); row <= Row(p.y() + radius); ++row) {
      // Each row has a word more than it needs.
      const std::uint64_t* word = words_.data() + row * row_words_ + first / 64;
      found |= word[0] >> shift | word[1] << 1 << (63 - shift);
    }
    return (found & ((std::uint64_t{2} << (last - first)) - 1)) != 0;
  }

 private:
  std::size_t Col(float x) const { return static_cast<std::size_t>(std::clamp(static_cast<int>(x / 2), 0, cols_ - 1)); }
  std::size_t Row(float y) const {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(y / 2) - first_row_, 0, rows_ - 1));
  }

  std::vector<std::uint64_t>& words_;
  int cols_, first_row_, rows_;
  std::size_t row_words_;
};

/// Fills planes and scans for peaks, band by band: each row is used by all while it is in a near cache.
void Scan(const ImageView& image, Pyramid& pyramid) {
  StartDetectionPlane(image, pyramid.base);
  for (std::size_t level = 0; level < Pyramid::kLevels; ++level) {
    const BytePlane& plane = pyramid.level(static_cast<int>(level));
    pyramid.scans[level].Start(plane, kLeastResponse);
    if (level + 1 < Pyramid::kLevels) pyramid.halves[level].Resize(plane.width() / 2, plane.height() / 2);
  }
  const int height = pyramid.base.plane.height();
  for (int first = 0; first < height; first += kBandRows) {
    int from = first, past = std::min(first + kBandRows, height);
    FillDetectionPlane(image, from, past, pyramid.base);
    for (std::size_t level = 0; level < Pyramid::kLevels; ++level) {
      const BytePlane& plane = pyramid.level(static_cast<int>(level));
      pyramid.scans[level].Advance(plane, past);
      if (level + 1 == Pyramid::kLevels) break;
      from /= 2;
      past /= 2;
      HalveRows(plane, from, past, pyramid.halves[level]);
    }
  }
}

}  // namespace

void FindCornersIn(const BytePlane& plane, PeakScan& scan, std::vector<Corner>& corners,
                   std::vector<RefusedPeak>& refused) {
  corners.clear();
  scan.Start(plane, kLeastResponse);
  scan.Advance(plane, plane.height());
  AppendSaddles(plane, scan.peaks(), corners, refused, kStrongContrast);
}

int FindCorners(const ImageView& image, Pyramid& pyramid, std::vector<Corner>& corners,
                std::vector<Eigen::Vector2f>* refused_px, std::size_t most_peaks, const ImagePart& part) {
  corners.clear();
  pyramid.strong.clear();
  pyramid.base.region_px = Eigen::Vector2i(part.x, part.y).cast<float>();
  Scan(image, pyramid);
  int looked_at = 0;
  Occupancy occupancy(pyramid.occupied, part.x + pyramid.base.plane.width(), part.y,
                      part.y + pyramid.base.plane.height());
  for (int level = 0; level < Pyramid::kLevels; ++level) {
    const BytePlane& plane = pyramid.level(level);
    std::vector<Peak>& peaks = pyramid.scans[static_cast<std::size_t>(level)].peaks();
    const auto place = [&](const Peak& peak) {
      return pyramid.ToImage({static_cast<float>(peak.x), static_cast<float>(peak.y)}, level);
    };
    if (part.known && part.known->any())
      std::erase_if(peaks, [&](const Peak& peak) { return part.known->Covers(place(peak)); });
    const std::size_t left = most_peaks - std::min(most_peaks, static_cast<std::size_t>(looked_at));
    const bool last = level + 1 == Pyramid::kLevels;
    LimitPeaks(static_cast<double>(plane.width()) * plane.height(), last ? left : left - left / kShareOfCoarser, peaks);
    looked_at += static_cast<int>(peaks.size());
    const float scale = static_cast<float>(1 << level);
    // Each corner counts at the finest level that shows it.
    if (level > 0) std::erase_if(peaks, [&](const Peak& peak) { return occupancy.Near(place(peak), 2 * scale); });
    const std::size_t finer = corners.size();
    AppendSaddles(plane, peaks, corners, pyramid.refused, refused_px ? -1e9f : kStrongContrast);
    for (std::size_t i = finer; i < corners.size(); ++i) {
      corners[i].position = pyramid.ToImage(corners[i].position, level);
      corners[i].scale = scale;
    }
    for (const RefusedPeak& refused : pyramid.refused) {
      const Eigen::Vector2f at = place(peaks[refused.index]);
      if (refused.contrast >= kStrongContrast) pyramid.strong.push_back({at, refused.contrast});
      if (refused_px) refused_px->push_back(at);
    }
    for (std::size_t i = finer; i < corners.size(); ++i) occupancy.Mark(corners[i].position);
  }
  return looked_at;
}

}  // namespace chequer
