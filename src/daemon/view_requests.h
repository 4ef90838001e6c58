#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "chequer/frame.h"
#include "publish/view_messages.h"

namespace chequer {

/// What is asked for at the moment, and when the next of each kind is due. Holds kMostAskers at most; a request runs
/// out after kAskLasts. One thread.
class ViewRequests {
 public:
  static constexpr std::size_t kMostAskers = 4;
  static constexpr std::chrono::seconds kAskLasts{2};
  static constexpr std::chrono::milliseconds kPreviewPeriod{100}, kDetailPeriod{200}, kCameraPeriod{1000};
  /// Of the time of one core that a kind may take: one part in so many.
  static constexpr int kShare = 50;

  enum class Kind : std::uint8_t { kPreview, kDetail, kCamera };

  /// A request came. One of another asker than those there are is heeded where a place is free.
  void Take(const AskMessage& message, MonotonicTime now);
  /// Forgets what has run out.
  void Expire(MonotonicTime now);

  /// Whether anything is asked for.
  bool Any() const;
  /// When a frame is wanted next; nothing while neither a preview nor a detail is asked for.
  std::optional<MonotonicTime> NextFrame() const;
  bool IsDue(Kind kind, MonotonicTime now) const;
  /// The request whose turn it is; askers take turns. Null where the kind is not asked for.
  const AskMessage* Next(Kind kind) const;
  /// It was answered, which took so much of a processor's time: when the kind is due next.
  void Done(Kind kind, MonotonicTime now, std::chrono::microseconds took);

 private:
  struct Asker {
    AskMessage message;
    MonotonicTime until{};
  };
  /// The place of the request whose turn it is; kMostAskers where there is none.
  std::size_t NextPlace(Kind kind) const;

  std::array<std::optional<Asker>, kMostAskers> askers_;
  std::array<MonotonicTime, 3> due_{};
  std::array<std::size_t, 3> last_turn_{};
};

}  // namespace chequer
