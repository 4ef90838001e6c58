#pragma once

#include <memory>
#include <optional>

#include "core/clock.h"
#include "view/client_message.h"
#include "view/feed.h"
#include "view/log_index.h"

namespace chequer {

/// Plays a log for one page: each page has its own time, so none disturbs another. One thread.
class Replay {
 public:
  /// Begins at the log's beginning. Throws std::runtime_error naming the file where it cannot be read.
  Replay(std::shared_ptr<const LogIndex> index, MonotonicTime now);

  void Seek(const PageSeek& seek, MonotonicTime now);
  /// Gives the feed what is due. At the end it stands still.
  void Play(MonotonicTime now);

  Feed& feed() { return feed_; }
  ServerState::Replay State() const;
  /// Rises with each Seek, and at the end.
  std::uint64_t version() const { return version_; }

 private:
  void ReadUntil(UtcTime time);

  std::shared_ptr<const LogIndex> index_;
  LogEventReader reader_;
  Feed feed_{0};
  std::optional<LogEvent> next_;
  UtcTime at_{};  ///< of the log, at began_
  MonotonicTime began_{};
  UtcTime now_{};
  double speed_ = 1;
  bool playing_ = true;
  std::uint64_t version_ = 1;
};

}  // namespace chequer
