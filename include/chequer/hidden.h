#pragma once

#include <cstdint>
#include <string_view>

#pragma GCC visibility push(default)  // part of libchequer's interface

namespace chequer {

/// Why a cell or an inner corner of a board does not show, or does not count: the first that was found.
enum class Hidden : std::uint8_t {
  kNot,        ///< it shows
  kOutside,    ///< it lies outside the image
  kFlat,       ///< a cell that does not stand out from its neighbours as its class should; a corner of little contrast
  kCovered,    ///< a cell of a side without which the border is a marker's
  kMisfit,     ///< a corner whose pixels the model of a board does not explain
  kBeside,     ///< a corner of a hidden cell, or a cell whose corners are hidden
  kEnclosed,   ///< a cell between hidden ones
  kLeftOut,    ///< a corner without which the board fits better
  kPulled,     ///< a corner next to hidden ones that disagrees with the others; its cells count
  kOffColour,  ///< a light cell of a colour that boards do not have
};
inline constexpr int kReasonsToHide = static_cast<int>(Hidden::kOffColour) + 1;
/// "outside", …; "not".
std::string_view HiddenName(Hidden hidden);

}  // namespace chequer

#pragma GCC visibility pop
