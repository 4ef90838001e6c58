#pragma once

#include <optional>
#include <string>

#include "chequer/detector.h"
#include "chequer/image.h"

namespace chequer {

/// What kind of marker an image shows, as far as its boards tell.
struct LikelyKind {
  MarkerSize size;
  Variant variant = Variant::kUnconstrained;
  int boards = 0;  ///< of that size
  int words = 0;   ///< of them, whose cells are a word of the variant without a mistake

  /// "6x6 secded (8 of 8 boards)".
  std::string Text() const;
  /// "6x6:secded".
  std::string Option() const;
};

/// The kind of most boards; nothing where no board is seen. Tries all sizes from 4x4 to 10x10: tenths of a second.
/// @param image BGR8. @param sought how colours are told; its families are tried first.
std::optional<LikelyKind> GuessKind(const ImageView& image, const DetectorOptions& sought);

}  // namespace chequer
