#include "capture/aravis_formats.h"

#include <algorithm>
#include <array>

namespace chequer {
namespace {

struct Known {
  std::string_view name;
  std::uint32_t code;
  PixelFormat format;
};

// Names of the Pixel Format Naming Convention, and older ones of GigE Vision 1. In the order in which they are
// preferred.
constexpr std::array<Known, 15> kKnown{{
    {"BayerRG8", 0x01080009, PixelFormat::kBayerRg8},
    {"BayerGB8", 0x0108000A, PixelFormat::kBayerGb8},
    {"BayerGR8", 0x01080008, PixelFormat::kBayerGr8},
    {"BayerBG8", 0x0108000B, PixelFormat::kBayerBg8},
    {"BGR8", 0x02180015, PixelFormat::kBgr8},
    {"BGR8Packed", 0x02180015, PixelFormat::kBgr8},
    {"RGB8", 0x02180014, PixelFormat::kRgb8},
    {"RGB8Packed", 0x02180014, PixelFormat::kRgb8},
    {"YUV422_8", 0x02100032, PixelFormat::kYuyv},
    {"YUV422_YUYV_Packed", 0x02100032, PixelFormat::kYuyv},
    {"YCbCr422_8", 0x0210003B, PixelFormat::kYuyv},
    {"YUV422_8_UYVY", 0x0210001F, PixelFormat::kUyvy},
    {"YUV422Packed", 0x0210001F, PixelFormat::kUyvy},
    {"YCbCr422_8_CbYCrY", 0x02100043, PixelFormat::kUyvy},
    {"Mono8", 0x01080001, PixelFormat::kMono8},
}};

}  // namespace

std::optional<PixelFormat> PixelFormatOfGenicam(std::string_view name) {
  for (const Known& known : kKnown)
    if (known.name == name) return known.format;
  return std::nullopt;
}

std::optional<PixelFormat> PixelFormatOfGenicam(std::uint32_t code) {
  for (const Known& known : kKnown)
    if (known.code == code) return known.format;
  return std::nullopt;
}

GenicamFormatChoice ChooseGenicamFormat(const std::vector<std::string>& offered,
                                        const std::optional<std::string>& wanted) {
  for (const Known& known : kKnown) {
    const bool is_offered = std::find(offered.begin(), offered.end(), known.name) != offered.end();
    if (is_offered && (!wanted || *wanted == PixelFormatName(known.format))) return {std::string(known.name), {}};
  }
  std::string usable, all;
  for (const std::string& name : offered) {
    const auto format = PixelFormatOfGenicam(name);
    const std::string shown(format ? PixelFormatName(*format) : std::string_view());
    if (format && usable.find(shown) == std::string::npos) usable += (usable.empty() ? "" : ", ") + shown;
    all += (all.empty() ? "" : ", ") + name;
  }
  if (usable.empty()) return {{}, "none of the camera's formats can be used: " + (all.empty() ? "it has none" : all)};
  return {{}, "the camera does not offer " + wanted.value_or("") + "; it offers " + usable};
}

}  // namespace chequer
