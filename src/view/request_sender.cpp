#include "view/request_sender.h"

#include <algorithm>

#include "publish/channels.h"
#include "publish/wire_view.h"

namespace chequer {
namespace {

/// A request lasts two seconds; one may be lost.
constexpr std::chrono::milliseconds kAskAgain{700};

bool LooksAt(const PageWish& wish, std::uint16_t camera) { return !wish.camera || *wish.camera == camera; }

}  // namespace

CameraAsks AsksFor(std::uint16_t camera, const std::vector<PageWish>& wishes, std::int64_t asker) {
  CameraAsks asks;
  asks.whole.asker = asker;
  asks.part.asker = asker + 1;
  for (const PageWish& wish : wishes) {
    if (!wish.visible) continue;
    asks.any = true;
    asks.whole.wants_camera = true;
    if (wish.Wants(TopicKind::kPicture) && LooksAt(wish, camera)) {
      if (!asks.whole.preview) asks.whole.preview = AskMessage::Preview{{}, kLeastPreviewWidth};
      asks.whole.preview->width = std::max(asks.whole.preview->width, wish.picture_width);
    }
    if (wish.camera != camera) continue;
    if (wish.Wants(TopicKind::kZoom) && !wish.region.IsWhole())
      asks.part.preview = AskMessage::Preview{wish.region, 640};
    if (wish.detail) asks.whole.detail = wish.detail;
  }
  return asks;
}

bool AsksForCalibrations(const std::vector<PageWish>& wishes) {
  return std::any_of(wishes.begin(), wishes.end(),
                     [](const PageWish& wish) { return wish.visible && wish.Wants(TopicKind::kCalibration); });
}

void RequestSender::Ask(const Feed& feed, const std::vector<PageWish>& wishes, MonotonicTime now) {
  if (AsksForCalibrations(wishes) && now >= next_calibration_) {
    // An asker of its own: a daemon whose prefix this is must not take it for one that wants nothing any more.
    sender_.Send(std::string(kCalibrationPrefix),
                 {.asker = ~asker_, .preview = {}, .detail = {}, .wants_calibration = true});
    next_calibration_ = now + kAskAgain;
  }
  for (std::size_t i = 0; i < feed.cameras(); ++i) {
    const CameraAsks asks = AsksFor(static_cast<std::uint16_t>(i), wishes, asker_);
    if (!asks.any) continue;
    std::vector<std::uint8_t> what = EncodeView(asks.whole);
    const std::vector<std::uint8_t> part = EncodeView(asks.part);
    what.insert(what.end(), part.begin(), part.end());
    Sent& sent = sent_[feed.prefix(i)];
    if (sent.what == what && now < sent.at + kAskAgain) continue;
    sender_.Send(feed.prefix(i), asks.whole);
    if (asks.part.preview) sender_.Send(feed.prefix(i), asks.part);
    sent = {std::move(what), now};
  }
}

}  // namespace chequer
