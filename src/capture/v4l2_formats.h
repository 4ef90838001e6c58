#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "chequer/image.h"

namespace chequer {

/// Four characters that name a format of V4L2, as its headers pack them.
using FourCc = std::uint32_t;

constexpr FourCc MakeFourCc(std::string_view four) {
  return static_cast<FourCc>(four[0]) | static_cast<FourCc>(four[1]) << 8 | static_cast<FourCc>(four[2]) << 16 |
         static_cast<FourCc>(four[3]) << 24;
}

/// The four characters, what is not printable as a dot.
std::string FourCcText(FourCc code);

/// Whether frames of that format are JPEG files.
bool IsJpeg(FourCc code);

/// The layout of a format that is handed to the detector as it comes; nothing for JPEG and all others.
std::optional<PixelFormat> PixelFormatOf(FourCc code);

/// The name that configurations use: MJPEG or PixelFormatName; empty for formats that cannot be used.
std::string NameOfFourCc(FourCc code);

/// Sizes that a format comes in; one size where minimum and maximum are the same.
struct V4l2SizeOffer {
  int min_width = 0, max_width = 0, step_width = 1;
  int min_height = 0, max_height = 0, step_height = 1;
  std::vector<double> rates_hz;  ///< falling; of a range its ends. Empty: the driver does not say.

  bool Holds(int width, int height) const;
};

struct V4l2FormatOffer {
  FourCc code = 0;
  std::string description;
  std::vector<V4l2SizeOffer> sizes;  ///< empty: the driver does not say
};

/// What is wanted; what is left out is chosen.
struct V4l2FormatWish {
  std::optional<std::string> pixel_format;  ///< NameOfFourCc
  std::optional<int> width;
  std::optional<int> height;
  double fps = 30;
};

struct V4l2FormatChoice {
  FourCc code = 0;
  int width = 0;
  int height = 0;
  std::string wrong;  ///< empty, or what was asked, what is there and what to type; then nothing is chosen
  enum class Key { kNone, kPixelFormat, kSize } wrong_key = Key::kNone;
};

/// Chooses what reaches the rate, then what has the most pixels, then what has colour and the least loss: raw Bayer,
/// RGB, 4:2:2, 4:2:0, JPEG, grey.
/// @param current_width, current_height taken where the driver does not say which sizes there are.
V4l2FormatChoice ChooseV4l2Format(const std::vector<V4l2FormatOffer>& offers, const V4l2FormatWish& wish,
                                  int current_width, int current_height);

/// "YUYV 640x480 (30, 25 fps), 1280x720 (10 fps); MJPEG …", formats that can be used alone.
std::string OfferText(const std::vector<V4l2FormatOffer>& offers);

}  // namespace chequer
