#pragma once

#include "detect/image_state.h"

// What a detector makes of frames of a stream (DetectorMemory).

namespace chequer {

/// A frame of a stream.
struct StreamImage {
  FrameTime captured{};
  MemoryState& memory;
};

/// Places the boards that the memory expects, as if a search had found them there: the first of ImageState::boards.
void ExpectBoards(const ImageJob& job, const StreamImage& stream);
/// Of the boards that were expected and fitted, refuses those that read as others, and notes where the others are to be
/// searched.
void JudgeExpected(const ImageJob& job, const StreamImage& stream);
/// The same once all fits are done: carries identities.
void DecideExpected(const ImageJob& job, const StreamImage& stream);
/// For the trace: what became of what was expected.
void TraceExpectations(const ImageJob& job, const StreamImage& stream);
/// Makes the memory that for the next frame.
void Remember(const ImageJob& job, const StreamImage& stream);

}  // namespace chequer
