#include "view/view_client.h"

namespace chequer {

bool ViewClient::Wants(std::size_t camera, TopicKind kind) const {
  if (!wish_.visible || !wish_.Wants(kind)) return false;
  switch (kind) {
    case TopicKind::kFrame:
    case TopicKind::kPicture: return !wish_.camera || *wish_.camera == camera;
    case TopicKind::kZoom: return wish_.camera == camera && !wish_.region.IsWhole();
    case TopicKind::kDetail: return wish_.camera == camera && wish_.detail;
    default: return true;
  }
}

bool ViewClient::IsNew(Feed& feed, std::size_t place) const {
  const std::size_t camera = place / kTopicKinds;
  const auto kind = static_cast<TopicKind>(place % kTopicKinds);
  if (!Wants(camera, kind)) return false;
  const std::uint64_t version = feed.topic(camera, kind).version;
  // The history comes once: the page goes on with it by the statuses.
  return kind == TopicKind::kHistory ? version > 0 && SentOf(place) == 0 : version > SentOf(place);
}

bool ViewClient::HasNews(Feed& feed, const Topic& server) const {
  if (server.packet && server.version > server_sent_) return true;
  for (std::size_t place = 0; place < feed.cameras() * kTopicKinds; ++place)
    if (IsNew(feed, place)) return true;
  return false;
}

SharedPacket ViewClient::Take(Feed& feed, const Topic& server) {
  if (server.packet && server.version > server_sent_) {
    server_sent_ = server.version;
    return server.packet;
  }
  const std::size_t places = feed.cameras() * kTopicKinds;
  if (sent_.size() < places) sent_.resize(places);
  for (std::size_t i = 0; i < places; ++i) {
    turn_ = (turn_ + 1) % places;
    if (!IsNew(feed, turn_)) continue;
    const std::size_t camera = turn_ / kTopicKinds;
    const auto kind = static_cast<TopicKind>(turn_ % kTopicKinds);
    sent_[turn_] = feed.topic(camera, kind).version;
    if (auto packet = feed.PacketOf(camera, kind)) return packet;
  }
  return nullptr;
}

}  // namespace chequer
