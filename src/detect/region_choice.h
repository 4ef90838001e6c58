#pragma once

#include "detect/image_state.h"

namespace chequer {

/// Adds what lies around a place where a board was lost.
void SearchAround(PixelBox box, SearchRegions& regions);
/// What is searched for boards: the places that are open, and bands of the image in their turn.
/// @param memory of a stream; null: an image for itself.
void ChooseRegions(const ImageJob& job, const MemoryState* memory);
/// Where boards were expected and not searched for, and no fit found and read them: they lie elsewhere. False if
/// nowhere.
bool ChooseGivenUp(const ImageJob& job);
/// Bands that the image is searched in by turns.
int BandsOf(const DetectorOptions& options);

}  // namespace chequer
