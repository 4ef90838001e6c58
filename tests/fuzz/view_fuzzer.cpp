#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "chequer/check.h"
#include "view/client_message.h"
#include "view/feed.h"
#include "view/http_rules.h"
#include "view/view_client.h"

// Whatever pages, other pages and LCM may bring to the view. The first byte says which: a page's message, the headers
// Host and Origin, or messages on channels of a camera, each with its length before it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  if (data[0] % 3 == 0) {
    const auto message = chequer::ParseClientMessage(bytes);
    const auto* wish = message ? std::get_if<chequer::PageWish>(&*message) : nullptr;
    if (wish)
      CHEQUER_CHECK(wish->region.x >= 0 && wish->picture_width >= chequer::kLeastPreviewWidth, "a wish is in range");
    return 0;
  }
  if (data[0] % 3 == 1) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string_view host = text.substr(0, text.find('\n'));
    const std::string_view origin = host.size() == text.size() ? std::string_view() : text.substr(host.size() + 1);
    const chequer::HttpRules rules({"tower"});
    if (rules.OriginIsOurs(origin, host)) CHEQUER_CHECK(rules.HostIsOurs(host), "an origin is ours where its host is");
    return 0;
  }
  chequer::Feed feed(7);
  feed.set_watched(true);
  chequer::ViewClient client(nullptr);
  chequer::PageWish wish;
  wish.visible = true;
  wish.kinds = ~0u;
  client.set_wish(wish);
  static constexpr const char* kChannels[] = {"a_POSES",  "a_STATUS", "a_ROBOTS", "a_TRACKS", "a_PREVIEW",
                                              "a_DETAIL", "a_CAMERA", "b_POSES",  "a_SETUP"};
  for (std::size_t at = 0; at + 3 <= bytes.size();) {
    const char* channel = kChannels[bytes[at] % 9];
    const std::size_t length =
        std::min<std::size_t>(bytes[at + 1] | std::size_t{bytes[at + 2]} << 8, bytes.size() - at - 3);
    feed.Take(channel, bytes.subspan(at + 3, length));
    at += 3 + length;
    while (client.HasNews(feed, {})) client.Take(feed, {});
  }
  return 0;
}
