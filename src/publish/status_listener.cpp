#include "publish/status_listener.h"

#include <utility>
#include <variant>

#include "publish/wire.h"

namespace chequer {

StatusListener::StatusListener(const LcmUrl& url, std::string channel) : listener_(url, std::move(channel)) {}

std::optional<StatusListener::Heard> StatusListener::Next() {
  while (auto heard = listener_.Next()) {
    auto message = DecodeMessage(heard->message);
    if (message && std::holds_alternative<StatusMessage>(*message))
      return Heard{std::get<StatusMessage>(std::move(*message)), std::move(heard->from)};
  }
  return std::nullopt;
}

}  // namespace chequer
