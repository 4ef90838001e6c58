#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "view/client_message.h"
#include "view/feed.h"
#include "view/replay.h"
#include "view/topics.h"

namespace chequer {

/// One page: what it looks at, and which of the newest it was sent. It has no queue: what it does not take in time is
/// replaced by what is newer. One thread.
class ViewClient {
 public:
  /// @param replay of its own; null where what is live is shown.
  explicit ViewClient(std::unique_ptr<Replay> replay) : replay_(std::move(replay)) {}

  void set_wish(const PageWish& wish) { wish_ = wish; }
  const PageWish& wish() const { return wish_; }
  Replay* replay() { return replay_.get(); }
  /// Its own feed in a replay, else the one that all share.
  Feed& FeedOf(Feed& live) { return replay_ ? replay_->feed() : live; }

  /// Whether there is anything new for it.
  bool HasNews(Feed& feed, const Topic& server) const;
  /// The next for it, each kind of each camera in turn; null where there is nothing new.
  SharedPacket Take(Feed& feed, const Topic& server);

 private:
  bool Wants(std::size_t camera, TopicKind kind) const;
  bool IsNew(Feed& feed, std::size_t place) const;
  std::uint64_t SentOf(std::size_t place) const { return place < sent_.size() ? sent_[place] : 0; }

  PageWish wish_;
  std::unique_ptr<Replay> replay_;
  std::uint64_t server_sent_ = 0;
  std::vector<std::uint64_t> sent_;  ///< versions, by camera and kind
  std::size_t turn_ = 0;
};

}  // namespace chequer
