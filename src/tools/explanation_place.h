#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tools/canvas.h"
#include "tools/explanation.h"
#include "tools/explanation_panel.h"

namespace chequer {

/// What the second look shows is drawn in a colour of its own.
inline constexpr Ink kLookInk{1, 0.3, 0.7}, kIdlePlaceInk{0.85, 0.75, 0.85, 0.8};

/// The places in the region that were considered for a second look, in the order of their numbers P1, P2, …: first
/// those that were viewed, then those that came near to it. Of the others only a few are told.
std::vector<std::size_t> ToldPlaces(const Explanation& explanation);

/// Lines for people, one a place.
std::string DescribePlaces(const Explanation& explanation);

/// What a place is called in the picture: "P1: 1 board", "P2: no board", "P3: not viewed".
std::string PlaceLabel(const TracePlace& place, int number);

/// The place's number, what it showed and why it was viewed, the image there, and the view that was searched with its
/// corners and links.
void DrawPlacePanel(Canvas& canvas, double left, double top, const Explanation& explanation, std::size_t place,
                    int number);

}  // namespace chequer
