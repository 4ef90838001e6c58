#pragma once

#include <cstring>
#include <nlohmann/json.hpp>
#include <string>

#include "view/topics.h"

namespace chequer::test {

/// A number of a packet, as the page reads it.
template <typename Value>
Value At(const SharedPacket& packet, std::size_t at) {
  Value value{};
  std::memcpy(&value, packet->data() + at, sizeof value);
  return value;
}

/// The JSON of a packet that holds one.
inline nlohmann::json JsonOf(const SharedPacket& packet) {
  return nlohmann::json::parse(packet->data() + 8, packet->data() + packet->size());
}

inline TopicKind KindOf(const SharedPacket& packet) { return static_cast<TopicKind>(packet->data()[0]); }

}  // namespace chequer::test
