#include "tools/diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "core/picture_check.h"
#include "detect/toolbox.h"
#include "marker/variant_guess.h"
#include "marker/variants.h"
#include "tools/any_boards.h"
#include "tools/ink_share.h"

namespace chequer {
namespace {

/// Places whose blur is looked at: each takes a fraction of a millisecond.
constexpr std::size_t kMostPlaces = 20;
/// Sharpest edges of that width are reported: of less where no marker is found. A lens in focus makes 2 to 3 px.
constexpr double kSoftPx = 4, kBlurredPx = 6;
/// Refused groups of corners that are reported, and how many corners they have at least.
constexpr std::size_t kMostRefused = 5, kFewestCorners = 6;
/// Named in one line.
constexpr std::size_t kMostIds = 8;

const MarkerFamily* FamilyOf(const DetectorOptions& sought, MarkerSize size) {
  for (const MarkerFamily& family : sought.families)
    if (family.code.size() == size) return &family;
  return nullptr;
}

std::string SoughtSizes(const DetectorOptions& sought) {
  std::set<std::string> sizes;
  for (const MarkerFamily& family : sought.families) sizes.insert(ToString(family.code.size()));
  return fmt::format("{}", fmt::join(sizes, ", "));
}

/// The variants of which a kernel is a word, exactly, as "secded (id 7)"; those that take nearly any kernel say
/// nothing.
std::string WordsIn(MarkerSize size, std::uint64_t kernel) {
  std::string words;
  for (const auto& [name, variant] : kVariants) {
    if (variant == Variant::kTable || variant == Variant::kUnconstrained) continue;
    try {
      const auto word = MarkerCode(size, variant).DecodeHard(kernel);
      if (word && word->bits_corrected == 0)
        words += fmt::format("{}{} (id {})", words.empty() ? "" : " or ", name, word->id);
    } catch (const std::runtime_error&) {
      // It does not exist at that size.
    }
  }
  return words;
}

class Diagnosis {
 public:
  Diagnosis(const ImageView& image, const DetectorOptions& sought, std::span<const MarkerPose> markers,
            const DetectTrace& trace)
      : image_(image), sought_(sought), markers_(markers), trace_(trace) {}

  std::vector<Finding> Make() {
    JudgePicture();
    boards_ = FindAnyBoards(image_, sought_, false);
    JudgeVariants();
    for (const AnyBoard& board : boards_)
      if (!IsRead(board)) JudgeBoard(board);
    for (const AnyBoard& board : FindAnyBoards(image_, sought_, true))
      if (!IsRead(board) && !IsExplained(board.center_px)) JudgeMirrored(board);
    JudgeBlurOfPlaces();
    JudgeRefused();
    return std::move(findings_);
  }

 private:
  void Say(std::string text) { findings_.push_back({{0, 0}, 0, std::move(text)}); }
  void Say(const AnyBoard& board, std::string text) {
    findings_.push_back({board.center_px, board.reach_px, std::move(text)});
  }
  bool IsExplained(const Eigen::Vector2d& pixel) const {
    return std::any_of(findings_.begin(), findings_.end(), [&](const Finding& f) { return f.IsAbout(pixel); });
  }
  /// Whether a marker was read there.
  bool IsRead(const AnyBoard& board) const {
    return std::any_of(markers_.begin(), markers_.end(), [&](const MarkerPose& marker) {
      return marker.id && (marker.center_px - board.center_px).norm() < board.reach_px;
    });
  }

  void JudgePicture() {
    const PictureCheck check = CheckPicture(image_, image_.height());
    if (check.IsBlack()) {
      Say("the picture is black: is the cap on the lens, is there light, is the exposure long enough?");
    } else if (check.IsWhite()) {
      Say("the picture is white: the exposure is too long, or the gain too high");
    } else if (check.IsBlank()) {
      Say("the picture has no contrast: is the lens focused on the markers, is something in front of it?");
    } else if (check.Blur(markers_.empty() ? kSoftPx : kBlurredPx)) {
      blurred_ = true;
      Say("the whole picture is blurred: " + BlurText(check));
    }
  }

  static std::string BlurText(const PictureCheck& check) {
    const double across = check.edge_along_rows_px.value_or(0), down = check.edge_along_columns_px.value_or(0);
    const bool one_way = std::max(across, down) > 1.4 * std::min(across, down);
    return fmt::format("even the sharpest edges are {:.0f} px wide across and {:.0f} px down: {}", across, down,
                       one_way
                           ? "it moved during the exposure, or the lens is out of focus; expose for a shorter time, "
                             "with more light"
                           : "focus the lens; if things moved, expose for a shorter time");
  }

  /// Which variant the boards of each size are of.
  void JudgeVariants() {
    std::map<std::pair<int, int>, std::vector<const AnyBoard*>> by_size;
    for (const AnyBoard& board : boards_)
      if (board.kernel) by_size[{board.size.rows, board.size.cols}].push_back(&board);
    for (const auto& [size, boards] : by_size) {
      const MarkerFamily* family = FamilyOf(sought_, boards[0]->size);
      if (family == nullptr || family->code.variant() == Variant::kTable) continue;
      VariantGuess guess(family->code);
      for (const AnyBoard* board : boards) guess.Add(*board->kernel);
      const auto other = guess.LooksLike();
      if (!other) continue;
      other_variants_.insert({boards[0]->size.rows, boards[0]->size.cols});
      SayVariant(*family, *other, boards);
    }
  }

  void SayVariant(const MarkerFamily& family, Variant other, const std::vector<const AnyBoard*>& boards) {
    const MarkerCode code(family.code.size(), other);
    std::vector<std::uint64_t> ids;
    for (const AnyBoard* board : boards)
      if (const auto word = code.DecodeHard(*board->kernel); word && ids.size() < kMostIds) ids.push_back(word->id);
    std::sort(ids.begin(), ids.end());
    const std::string text = fmt::format(
        "these look like {}, not {}: of {} boards of {}, {} explains the cells far better (ids {}{}): use --variant {}",
        VariantName(other), VariantName(family.code.variant()), boards.size(), ToString(family.code.size()),
        VariantName(other), fmt::join(ids, ", "), boards.size() > ids.size() ? ", ..." : "", VariantName(other));
    Say(text);
  }

  void JudgeBoard(const AnyBoard& board) {
    const MarkerFamily* family = FamilyOf(sought_, board.size);
    if (family == nullptr) {
      const std::string words = board.kernel ? WordsIn(board.size, *board.kernel) : std::string();
      Say(board, fmt::format("this is a marker of {} cells, and {} is sought: use --marker {}{}", ToString(board.size),
                             SoughtSizes(sought_), ToString(board.size),
                             words.empty() ? "" : "; its cells are a word of " + words));
      return;
    }
    if (!board.kernel || other_variants_.contains({board.size.rows, board.size.cols})) return;
    const auto word = family->code.DecodeHard(*board.kernel);
    if (word && word->bits_corrected == 0) {
      if (!family->roster.empty() &&
          std::find(family->roster.begin(), family->roster.end(), word->id) == family->roster.end())
        Say(board,
            fmt::format("this is id {}, which --ids (or the roster) leaves out: add it, or leave --ids out", word->id));
      return;
    }
    const std::string words = WordsIn(board.size, *board.kernel);
    Say(board, fmt::format("this is no word of {}; {}", VariantName(family->code.variant()),
                           words.empty() ? "nor of any other variant with rules: --variant unconstrained or a table "
                                           "of one's own, or cells that are dirty or covered"
                                         : "it is one of " + words + ": try that --variant"));
  }

  void JudgeMirrored(const AnyBoard& board) {
    const MarkerFamily* family = FamilyOf(sought_, board.size);
    const auto word = family != nullptr && board.kernel ? family->code.DecodeHard(*board.kernel) : std::nullopt;
    Say(board, fmt::format("this is the mirror image of a marker of {} cells{}: the print or the picture is mirrored; "
                           "print it anew, or switch off the flip of the camera or its driver",
                           ToString(board.size), word ? fmt::format(" (id {})", word->id) : std::string()));
  }

  /// Of what was seen and not read, and is not explained otherwise: is it blurred there?
  void JudgeBlurOfPlaces() {
    std::size_t looked_at = 0;
    for (const TracePlace& place : trace_.places) {
      if (place.fate != PlaceFate::kViewed || place.boards > 0 || IsExplained(place.center_px)) continue;
      if (++looked_at > kMostPlaces) return;
      Eigen::AlignedBox2d box;
      for (const Eigen::Vector2f& corner : place.outline_px) box.extend(corner.cast<double>());
      // Motion mixes the colours of a board: where nothing was found, stripes are enough.
      if (InkShare(image_, box) < kLeastInkShare && !(place.sharpened && markers_.empty())) continue;
      const double reach = box.diagonal().norm() / 2;
      if (IsRead({place.center_px, reach, {}, {}})) continue;  // its inks
      const PictureCheck check = CheckAround(place.center_px, reach);
      if (check.Blur() && !blurred_)
        findings_.push_back({place.center_px, reach, "this may be a blurred board: " + BlurText(check)});
      else if (place.sharpened)
        findings_.push_back({place.center_px, reach,
                             fmt::format("this may be a board that moved during the exposure by more than its cells of "
                                         "{:.0f} px: expose for a shorter time, with more light",
                                         place.cell_px)});
      else
        findings_.push_back(
            {place.center_px, reach,
             fmt::format("this has a marker's inks, but shows no board, even straightened: cells of about "
                         "{:.0f} px may be too small, too slanted or covered",
                         place.cell_px)});
    }
  }

  /// Of what is still unexplained, what has a marker's inks.
  void JudgeRefused() {
    std::size_t said = 0;
    for (const TraceCandidate& candidate : trace_.candidates) {
      if (candidate.marker >= 0 || candidate.corners.size() < kFewestCorners ||
          candidate.refusal == Refusal::kSeenTwice)
        continue;
      Eigen::AlignedBox2d box;
      for (const int corner : candidate.corners)
        box.extend(trace_.corners[static_cast<std::size_t>(corner)].position_px.cast<double>());
      const AnyBoard there{candidate.center_px, box.diagonal().norm() / 2, {}, {}};
      if (IsExplained(there.center_px) || IsRead(there) || InkShare(image_, box) < kLeastInkShare) continue;
      if (++said > kMostRefused) return;
      Say(there, fmt::format("this has a marker's inks and was refused ({}): its line below says by what",
                             RefusalName(candidate.refusal)));
    }
  }

  PictureCheck CheckAround(const Eigen::Vector2d& center, double reach) const {
    const int left = std::clamp(static_cast<int>(center.x() - reach), 0, image_.width() - 1);
    const int top = std::clamp(static_cast<int>(center.y() - reach), 0, image_.height() - 1);
    const int width = std::clamp(static_cast<int>(2 * reach), 1, image_.width() - left);
    const int height = std::clamp(static_cast<int>(2 * reach), 1, image_.height() - top);
    const std::array<Plane, 1> plane{{{image_.row(top) + 3 * left, image_.plane(0).stride_bytes}}};
    return CheckPicture(ImageView(PixelFormat::kBgr8, width, height, plane, image_.tone_curve()), height);
  }

  const ImageView& image_;
  const DetectorOptions& sought_;
  std::span<const MarkerPose> markers_;
  const DetectTrace& trace_;
  std::vector<AnyBoard> boards_;
  std::set<std::pair<int, int>> other_variants_;  ///< sizes of which another variant explains all
  bool blurred_ = false;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> Diagnose(const ImageView& image, const DetectorOptions& sought,
                              std::span<const MarkerPose> markers, const DetectTrace& trace) {
  return Diagnosis(image, sought, markers, trace).Make();
}

}  // namespace chequer
