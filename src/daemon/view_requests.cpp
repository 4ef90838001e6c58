#include "daemon/view_requests.h"

#include <algorithm>

namespace chequer {
namespace {

std::size_t Index(ViewRequests::Kind kind) { return static_cast<std::size_t>(kind); }

std::chrono::milliseconds PeriodOf(ViewRequests::Kind kind) {
  switch (kind) {
    case ViewRequests::Kind::kPreview: return ViewRequests::kPreviewPeriod;
    case ViewRequests::Kind::kDetail: return ViewRequests::kDetailPeriod;
    default: return ViewRequests::kCameraPeriod;
  }
}

bool Wants(const AskMessage& message, ViewRequests::Kind kind) {
  switch (kind) {
    case ViewRequests::Kind::kPreview: return message.preview.has_value();
    case ViewRequests::Kind::kDetail: return message.detail.has_value();
    default: return message.wants_camera;
  }
}

}  // namespace

std::size_t ViewRequests::NextPlace(Kind kind) const {
  for (std::size_t i = 1; i <= kMostAskers; ++i) {
    const std::size_t place = (last_turn_[Index(kind)] + i) % kMostAskers;
    if (askers_[place] && Wants(askers_[place]->message, kind)) return place;
  }
  return kMostAskers;
}

const AskMessage* ViewRequests::Next(Kind kind) const {
  const std::size_t place = NextPlace(kind);
  return place == kMostAskers ? nullptr : &askers_[place]->message;
}

void ViewRequests::Take(const AskMessage& message, MonotonicTime now) {
  Expire(now);
  auto place = std::find_if(askers_.begin(), askers_.end(),
                            [&](const auto& asker) { return asker && asker->message.asker == message.asker; });
  if (place == askers_.end())
    place = std::find_if(askers_.begin(), askers_.end(), [](const auto& asker) { return !asker; });
  if (place != askers_.end()) *place = Asker{message, now + kAskLasts};
}

void ViewRequests::Expire(MonotonicTime now) {
  for (auto& asker : askers_)
    if (asker && asker->until <= now) asker.reset();
}

bool ViewRequests::Any() const {
  return std::any_of(askers_.begin(), askers_.end(), [](const auto& asker) { return asker.has_value(); });
}

std::optional<MonotonicTime> ViewRequests::NextFrame() const {
  std::optional<MonotonicTime> next;
  for (const Kind kind : {Kind::kPreview, Kind::kDetail})
    if (Next(kind) && (!next || due_[Index(kind)] < *next)) next = due_[Index(kind)];
  return next;
}

bool ViewRequests::IsDue(Kind kind, MonotonicTime now) const { return Next(kind) && due_[Index(kind)] <= now; }

void ViewRequests::Done(Kind kind, MonotonicTime now, std::chrono::microseconds took) {
  const std::chrono::microseconds period = std::max<std::chrono::microseconds>(PeriodOf(kind), kShare * took);
  if (const std::size_t place = NextPlace(kind); place != kMostAskers) last_turn_[Index(kind)] = place;
  MonotonicTime& due = due_[Index(kind)];
  // On a grid of whole periods, so that frames that come a little late do not make it slower; what is missed is gone.
  due = due + 2 * period > now ? due + period : now + period;
}

}  // namespace chequer
