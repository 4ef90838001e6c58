#include <cmath>
#include <cstdio>

#include "chequer/detect_trace.h"
#include "detect/grids/grids.h"
#include "detect/toolbox.h"

namespace chequer {
namespace {

constexpr std::array<std::string_view, kRefusals> kNames{
    "none",        "few_linked",        "uneven",        "not_one_lattice", "few_corners",
    "no_yellow",   "cells_do_not_show", "border_unseen", "inks_alike",      "border_differs",
    "rivalled",    "goes_on",           "not_plane",     "no_fit",          "noise",
    "corners_off", "cells_hidden",      "no_pose",       "seen_twice",      "no_border_inks",
    "no_word",     "two_words"};

constexpr std::array<std::string_view, kReasonsToHide> kHiddenNames{
    "not", "outside", "flat", "covered", "misfit", "beside", "enclosed", "left_out", "pulled", "off_colour"};

/// A sentence with up to two figures in it.
std::string Fill(const char* sentence, double measured, double required) {
  std::array<char, 320> text{};
  // The sentences are the literals below; each takes the two figures in this order.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
  std::snprintf(text.data(), text.size(), sentence, measured, required);
#pragma GCC diagnostic pop
  return text.data();
}

const char* SentenceOf(Refusal refusal) {
  switch (refusal) {
    case Refusal::kNone: return "read";
    case Refusal::kFewLinked:
      return "only %.0f corners hang together in squares, %.0f are needed: cells too small, blurred or covered?";
    case Refusal::kUneven:
      return "%.0f corners hang together in squares, but not evenly enough for one plane: clutter, strong blur?";
    case Refusal::kNotOneLattice:
      return "the group is larger than any board, or its corners belong to a board that was found";
    case Refusal::kFewCorners:
      return "at most %.0f corners lie where a board of a size that is sought would have them, %.0f are needed";
    case Refusal::kNoYellow:
      return "no border: the cells that should be yellow return as much blue as the white ones, at every place and "
             "turn";
    case Refusal::kCellsDoNotShow:
      return "only %.0f cells are lighter or darker than their neighbours, as they should be; %.1f are needed";
    case Refusal::kBorderUnseen:
      return "too little of the border can be judged: %.0f cells of one kind where %.0f are needed";
    case Refusal::kInksAlike:
      return "the border's saturated and unsaturated cells are alike: %.1f standard errors apart, %.1f are needed "
             "(white balance, colour of the light, faded inks?)";
    case Refusal::kBorderDiffers:
      return "%.0f border cells are as a marker's, %.1f are needed: another size or no marker";
    case Refusal::kRivalled: return "another place or turn explains the border nearly as well";
    case Refusal::kGoesOn: return "the pattern goes on beyond the border: a chessboard, tiles";
    case Refusal::kNotPlane: return "its corners do not lie on one plane";
    case Refusal::kNoFit:
      return "the model of cells, edges and blur finds no place in the pixels (less than 6 corners that it explains, "
             "or "
             "it moved away by more than 3 px)";
    case Refusal::kNoise: return "the cells' contrast is %.1f times what the model leaves unexplained, %.1f is needed";
    case Refusal::kCornersOff:
      return "the corners lie %.2f px (RMS) off a plane, at most %.2f: bent paper, motion, or no marker";
    case Refusal::kCellsHidden: return "more than half of the cells do not stand out as they should";
    case Refusal::kNoPose: return "no pose explains it with this lens: is the calibration this camera's?";
    case Refusal::kSeenTwice: return "it is a marker that other corners have shown better";
    case Refusal::kNoBorderInks:
      return "found, but without an id: white or the inks of the border cannot be told (colour of the light, hidden?)";
    case Refusal::kNoWord:
      return "found, but without an id: %.0f cells differ from the nearest word of the code, it corrects %.0f "
             "(another variant, an id that the roster leaves out, dirt?)";
    case Refusal::kTwoWords:
      return "found, but without an id: the best id's log-likelihood leads the next by %.1f, %.1f is needed (hidden or "
             "pale cells?)";
  }
  return "";
}

}  // namespace

std::string_view RefusalName(Refusal refusal) { return kNames[static_cast<std::size_t>(refusal)]; }

std::string_view HiddenName(Hidden hidden) { return kHiddenNames[static_cast<std::size_t>(hidden)]; }

std::string Explain(const TraceCandidate& candidate) {
  // Inks that are there, and the other way round, are no matter of light.
  if (candidate.refusal == Refusal::kInksAlike && candidate.measured < -candidate.required)
    return Fill(
        "the border's cells have the inks that others of a marker have (%.1f standard errors the wrong way, %.1f "
        "decide): a mirrored print or picture?",
        -candidate.measured, candidate.required);
  return Fill(SentenceOf(candidate.refusal), candidate.measured, candidate.required);
}

std::string Explain(const TraceExpected& expected) {
  const double off_px = expected.off_px.norm();
  switch (expected.fate) {
    case ExpectedFate::kRead: return Fill("read %.2f px from where it was expected", off_px, 0);
    case ExpectedFate::kCarried:
      return Fill(
          "too much is occluded to read its id: carried, %.2f px from where it was expected, last read %.2f s ago",
          off_px, expected.ago_s);
    case ExpectedFate::kNoId:
      return Fill(
          "a board without a readable id lies %.2f px from there; its id was last read %.2f s ago and is not "
          "carried (too long ago, a frame without a fit since, or cells that contradict it)",
          off_px, expected.ago_s);
    case ExpectedFate::kOther: return "another id is read there: forgotten, and its place searched";
    case ExpectedFate::kLost: return "no board fits there: its place was searched";
    case ExpectedFate::kDeferred: return "the budget did not last for it: expected again in the next frame";
  }
  return "";
}

std::string Explain(const TracePlace& place) {
  const std::string points = std::to_string(place.points) + " strong contrasts";
  const std::string spread =
      points + Fill(place.by_change ? ", and what changes around them spreads like cells of %.1f px, %.1f times as long"
                                    : " that spread like the corners of cells of %.1f px, %.1f times as long",
                    place.cell_px, place.slant);
  switch (place.fate) {
    case PlaceFate::kViewed: break;
    case PlaceFate::kTooMany: return "not viewed: " + spread + "; other places of this image came first";
    case PlaceFate::kSparse: return "not viewed: " + spread + "; a board with cells so large would leave more of them";
    case PlaceFate::kLine: return "not viewed: " + spread + "; they lie along a line";
    case PlaceFate::kFrontal:
      if (place.views > 0) break;
      return "not viewed: " + spread + "; so large and so little slanted, the first look would have shown a board";
    case PlaceFate::kTooLarge: return "not viewed: " + points + " that go on for farther than a board";
    case PlaceFate::kFewPoints: return "not viewed: only " + points + " hang together, too few for a board";
  }
  const char* shows = place.sharpened && place.by_change ? "; straightened and sharpened, it shows %.0f corners, "
                      : place.sharpened ? "; it seems smeared: with its stripes made even, it shows %.0f corners, "
                                        : "; straightened, it shows %.0f corners, ";
  const std::string shown = spread + Fill(shows, place.corners, 0) +
                            (place.most_linked > 0 ? Fill("%.0f of them in the largest group: ", place.most_linked, 0)
                                                   : "none of them linked to squares: ");
  if (place.boards > 0)
    return shown + "found " + std::to_string(place.boards) + (place.boards > 1 ? " boards" : " board");
  return shown + (place.most_linked < GridLinker::kFewest
                      ? "too few hang together: too steep, blurred, or no board"
                      : "no board that was not known; its groups say what refused them");
}

std::optional<std::uint64_t> KernelOf(const TraceCandidate& candidate) {
  // A cell is wrong once in a thousand times at that log-likelihood (ln 1000 = 6.9).
  constexpr float kSure = 7;
  const Refusal refusal = candidate.refusal;
  const bool was_read = refusal == Refusal::kNone || refusal == Refusal::kNoWord || refusal == Refusal::kTwoWords;
  if (!was_read || candidate.marker < 0 || !candidate.CameFar()) return std::nullopt;
  std::uint64_t kernel = 0;
  for (const TraceCell& cell : candidate.cells) {
    if (IsBorder(candidate.size, cell.at.row, cell.at.col)) continue;
    if (!cell.seen || std::abs(cell.log_likelihood) < kSure) return std::nullopt;
    kernel = kernel << 1 | (cell.log_likelihood > 0 ? 1u : 0u);
  }
  return kernel;
}

}  // namespace chequer
