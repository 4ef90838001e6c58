#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// The layout of a format of GenICam, by name (of the current naming convention, or of older cameras) or by the code
/// that frames carry; nothing for formats that cannot be used.
std::optional<PixelFormat> PixelFormatOfGenicam(std::string_view name);
std::optional<PixelFormat> PixelFormatOfGenicam(std::uint32_t code);

/// The format to set.
struct GenicamFormatChoice {
  std::string name;   ///< as the camera calls it
  std::string wrong;  ///< empty, or what was asked, what is there and what to type
};

/// The format that is wanted, or the best there is: raw Bayer, RGB, 4:2:2, grey.
/// @param wanted a name of ParsePixelFormat.
GenicamFormatChoice ChooseGenicamFormat(const std::vector<std::string>& offered,
                                        const std::optional<std::string>& wanted);

}  // namespace chequer
