#include "view/client_message.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "chequer/image.h"

namespace chequer {
namespace {

// First byte of each kind; page/socket.js has the same numbers.
constexpr std::uint8_t kWish = 1, kSeek = 2;
constexpr std::size_t kWishBytes = 48, kSeekBytes = 16;
constexpr std::uint16_t kAllCameras = 0xffff;
constexpr std::uint8_t kNoDetail = 0, kDetailById = 1, kDetailByPlace = 2;

template <typename Value>
Value At(std::span<const std::uint8_t> bytes, std::size_t at) {
  Value value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// A number of pixels as a page's float; nothing where it is none.
std::optional<int> Pixels(float value) {
  if (!(value >= 0) || !(value <= static_cast<float>(kMaxImageSide))) return std::nullopt;
  return static_cast<int>(value);
}

std::optional<MarkerChoice> ReadChoice(std::span<const std::uint8_t> bytes) {
  MarkerChoice choice;
  choice.family = At<std::uint16_t>(bytes, 30);
  if (bytes[28] == kDetailById)
    choice.id = At<std::uint32_t>(bytes, 32) | std::uint64_t{At<std::uint32_t>(bytes, 36)} << 32;
  choice.center_px = {static_cast<double>(At<float>(bytes, 40)), static_cast<double>(At<float>(bytes, 44))};
  const bool sound = choice.center_px.allFinite() && choice.family <= INT16_MAX;
  return sound ? std::optional(choice) : std::nullopt;
}

std::optional<ClientMessage> ReadWish(std::span<const std::uint8_t> bytes) {
  PageWish wish;
  wish.visible = bytes[1] != 0;
  wish.kinds = At<std::uint32_t>(bytes, 4);
  if (const auto camera = At<std::uint16_t>(bytes, 8); camera != kAllCameras) wish.camera = camera;
  wish.picture_width = std::clamp<int>(At<std::uint16_t>(bytes, 10), kLeastPreviewWidth, kMostPreviewWidth);
  int* const region[] = {&wish.region.x, &wish.region.y, &wish.region.width, &wish.region.height};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixels = Pixels(At<float>(bytes, 12 + 4 * i));
    if (!pixels) return std::nullopt;
    *region[i] = *pixels;
  }
  if (bytes[28] > kDetailByPlace) return std::nullopt;
  if (bytes[28] != kNoDetail && !(wish.detail = ReadChoice(bytes))) return std::nullopt;
  return wish;
}

std::optional<ClientMessage> ReadSeek(std::span<const std::uint8_t> bytes) {
  const PageSeek seek{At<double>(bytes, 8), static_cast<double>(At<float>(bytes, 4)), bytes[1] != 0};
  // Times of the years 1970 to 2286 in ms: sums of them stay numbers.
  const bool sound = seek.at_ms >= 0 && seek.at_ms < 1e13 && seek.speed >= 0.1 && seek.speed <= 16;
  return sound ? std::optional<ClientMessage>(seek) : std::nullopt;
}

}  // namespace

std::optional<ClientMessage> ParseClientMessage(std::span<const std::uint8_t> bytes) {
  if (bytes.size() == kWishBytes && bytes[0] == kWish) return ReadWish(bytes);
  if (bytes.size() == kSeekBytes && bytes[0] == kSeek) return ReadSeek(bytes);
  return std::nullopt;
}

}  // namespace chequer
