#include "view/replay.h"

#include <algorithm>

namespace chequer {
namespace {

/// What lies that long before a moment is read for it: statuses and the camera come once a second.
constexpr std::chrono::milliseconds kLeadIn{2500};
/// Messages that are read in one go, so that a fast replay of a dense log holds up nobody.
constexpr int kMostAtOnce = 4000;

}  // namespace

Replay::Replay(std::shared_ptr<const LogIndex> index, MonotonicTime now)
    : index_(std::move(index)), reader_(index_->path()), at_(index_->first()), began_(now), now_(at_) {
  feed_.set_watched(true);
}

void Replay::Seek(const PageSeek& seek, MonotonicTime now) {
  const UtcTime wanted{std::chrono::microseconds(static_cast<std::int64_t>(seek.at_ms * 1000))};
  at_ = now_ = std::clamp(wanted, index_->first(), index_->last());
  began_ = now;
  speed_ = seek.speed;
  playing_ = seek.playing;
  ++version_;
  next_.reset();
  reader_.Seek(index_->PlaceBefore(at_ - kLeadIn));
  feed_.Rewind();
  ReadUntil(at_);
}

void Replay::Play(MonotonicTime now) {
  if (!playing_) return;
  const auto played = std::chrono::duration_cast<std::chrono::microseconds>((now - began_) * speed_);
  now_ = std::min(at_ + played, index_->last());
  ReadUntil(now_);
  if (now_ < index_->last()) return;
  playing_ = false;
  ++version_;
}

void Replay::ReadUntil(UtcTime time) {
  for (int i = 0; i < kMostAtOnce; ++i) {
    if (!next_) next_ = reader_.Next();
    if (!next_ || next_->logged > time) return;
    feed_.Take(next_->channel, next_->data);
    next_.reset();
  }
}

ServerState::Replay Replay::State() const {
  return {index_->path().filename().string(), index_->first(), index_->last(), now_, speed_, playing_};
}

}  // namespace chequer
