#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/image.h"

namespace chequer::test {

/// Names of textures without any marker that look, in one way or another, like a great many of them: endless
/// chessboards of black and white ("chess10": cells of 10 px) and of the markers' four inks ("inkchess10"), the
/// markers' own border over and over ("borders10"), blocks of random inks ("inks6"), halftone, print, noise, moire,
/// stripes.
std::vector<std::string> TextureNames();

/// The texture of that name, BGR, with a little blur and noise. The same arguments give the same bytes. Throws
/// std::runtime_error where there is none of that name.
Image DrawTexture(std::string_view name, int width, int height, std::uint64_t seed = 1);

}  // namespace chequer::test
