#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "publish/view_messages.h"
#include "view/topics.h"

namespace chequer {

/// What a page looks at. Nothing else can be asked for: a page changes nothing.
struct PageWish {
  bool visible = false;                 ///< a hidden page gets nothing
  std::uint32_t kinds = 0;              ///< bits 1 << TopicKind
  std::optional<std::uint16_t> camera;  ///< frames, pictures and details of this one alone; nothing: of all
  int picture_width = 640;              ///< pixels
  PixelRegion region;                   ///< of the camera's frame, that is zoomed into
  std::optional<MarkerChoice> detail;   ///< of the camera

  bool Wants(TopicKind kind) const { return (kinds & (1u << static_cast<unsigned>(kind))) != 0; }
};

/// Where a page's own replay is to go on.
struct PageSeek {
  double at_ms = 0;  ///< UTC
  double speed = 1;  ///< 0.1 … 16
  bool playing = true;
};

using ClientMessage = std::variant<PageWish, PageSeek>;

/// Longest message of a page.
inline constexpr std::size_t kMaxClientMessage = 64;

/// What a page says; nothing where it is not of this form, which ends its connection.
std::optional<ClientMessage> ParseClientMessage(std::span<const std::uint8_t> bytes);

}  // namespace chequer
