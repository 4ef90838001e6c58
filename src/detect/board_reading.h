#pragma once

#include <cstddef>
#include <cstdint>

#include "detect/fit/fit.h"
#include "detect/identity/marker_description.h"
#include "detect/image_state.h"

namespace chequer {

/// What a thread needs to read boards; begins anew with every board.
struct BoardReader {
  explicit BoardReader(const DetectorOptions& options) : identifier(options) {}
  PhotometricFit fit;
  Identifier identifier;
};

/// How a board is to be fitted.
struct FitOrder {
  std::size_t board = 0;
  const ImageTraits* image = nullptr;  ///< null: not known yet
  bool plain_only = false;
  std::uint64_t most_units = 0;
};

/// Fits a board, reads its identity and finds its poses. Changes nothing of the frame, so that threads may read
/// different boards at once.
BoardOutcome ReadBoard(const ImageJob& job, const FitOrder& order, BoardReader& reader);

}  // namespace chequer
